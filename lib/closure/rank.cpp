#include "lib/closure/rank.h"

#include <limits>

#include "lib/closure/components.h"
#include "lib/closure/curvature.h"
#include "lib/closure/row_space.h"
#include "lib/closure/scaling.h"
#include "lib/system/closure_jacobian.h"
#include "lib/system/equations.h"

namespace lanc {

template <class S>
struct ClosureRank<S>::Work {
  /// The rows of loops that hang together.
  struct Block {
    ClosureComponent part;
    std::vector<Eigen::Triplet<double>> entries;
    Eigen::SparseMatrix<double> Gt;  // scaled, transposed
    std::unique_ptr<RowSpace> space;

    int rows() const { return static_cast<int>(part.rows.size()); }
    int redundant() const { return rows() - space->rank(); }
  };

  Model model;
  ClosureScaling scaling;
  std::vector<double> row_unit, column_unit;  // of g and η: the inverse of a row's scale, and of a column's
  ClosureJacobian<S> jacobian;
  std::vector<Block> blocks;
  Solution<S> at_rest;
  std::vector<S> bias;
  ClosureDecision decision;
  std::unique_ptr<ClosureCurvature> curvature;
  int constant_rank = -1;  // the largest rank seen where it does not vary, or −1

  explicit Work(const Model& m) : model(m), scaling(m), jacobian(m), at_rest(m) {
    for (ClosureComponent& part : closure_components(jacobian.starts(), jacobian.columns(), m.nv())) {
      Block block;
      const auto rows = static_cast<Eigen::Index>(part.rows.size()),
                 columns = static_cast<Eigen::Index>(part.columns.size());
      block.Gt.resize(columns, rows);
      block.space = RowSpace::create(rows, columns);
      block.part = std::move(part);
      blocks.push_back(std::move(block));
    }
    for (const double scale : scaling.row) row_unit.push_back(1 / scale);
    for (const double scale : scaling.column) column_unit.push_back(1 / scale);
    decision.independent.resize(m.closures().rows());
    decision.correction.resize(m.closures().rows());
  }

  void decompose(Block& block) const {
    block.entries.clear();
    for (int r = 0; r < block.rows(); ++r) {
      const int k = block.part.rows[r];
      for (int p = jacobian.starts()[k]; p < jacobian.starts()[k + 1]; ++p) {
        const int c = jacobian.columns()[p];
        block.entries.emplace_back(block.part.local_column(c), r,
                                   to_double(jacobian.values()[p]) * scaling.row[k] * scaling.column[c]);
      }
    }
    block.Gt.setFromTriplets(block.entries.begin(), block.entries.end());
    block.space->decompose(block.Gt);
  }

  /// Rank of every block: singular values above the threshold, or the given number of largest ones of all.
  void choose_rank(RankPolicy policy) {
    std::vector<double> all;
    for (const Block& block : blocks) all.insert(all.end(), block.space->sigma().begin(), block.space->sigma().end());
    std::sort(all.begin(), all.end(), std::greater<>());
    const double unit = all.empty() ? 1 : std::max(1.0, all[0]);
    double threshold = zero_singular_value * unit;
    if (!policy.automatic())
      threshold = policy.rank == 0                             ? std::numeric_limits<double>::infinity()
                  : policy.rank > static_cast<int>(all.size()) ? 0
                                                               : all[policy.rank - 1];
    if (!policy.automatic()) threshold = std::max(threshold, policy.smallest * unit);
    decision.rank = 0;
    for (Block& block : blocks) {
      const Eigen::VectorXd& sigma = block.space->sigma();
      block.space->set_rank(static_cast<int>((sigma.array() >= threshold && sigma.array() > 0).count()));
      decision.rank += block.space->rank();
    }
    decision.redundant = model.closures().rows() - decision.rank;
    decision.sigma = decision.rank > 0 ? all[decision.rank - 1] : 0;
    decision.next_sigma = decision.rank < static_cast<int>(all.size()) ? all[decision.rank] : 0;
    decision.near_singular = decision.rank > 0 && decision.sigma < clear_singular_value * unit;
  }

  void select_rows(const Block& block) {
    const bool all = block.redundant() == 0;
    for (const int k : block.part.rows) decision.independent[k] = all;
    if (all || block.space->rank() == 0) return;
    for (const int r : block.space->independent()) decision.independent[block.part.rows[r]] = true;
  }

  /// The part of γ̿ outside the range of G, by block.
  /// `floor`: what accelerations are compared with at least.
  void split_bias(const System<S>& system, double floor) {
    bias_accelerations(system, system.rhs, at_rest);  // η̇ = 0
    closure_accelerations(system, system.rhs, at_rest, bias);
    double size = 0, worst = 0;
    for (int k = 0; k < jacobian.rows(); ++k) size = std::max(size, bias_size(system, k) * scaling.row[k]);
    std::fill(decision.correction.begin(), decision.correction.end(), 0.0);
    for (const Block& block : blocks) {
      if (block.redundant() == 0) continue;
      Eigen::VectorXd gamma(block.rows());
      for (int r = 0; r < block.rows(); ++r)
        gamma[r] = to_double(bias[block.part.rows[r]]) * scaling.row[block.part.rows[r]];
      const Eigen::VectorXd rest = block.space->outside(gamma);
      for (int r = 0; r < block.rows(); ++r) {
        const int k = block.part.rows[r];
        decision.correction[k] = -rest[r] / scaling.row[k];
        if (std::abs(rest[r]) > worst) worst = std::abs(rest[r]), decision.worst_row = k;
      }
    }
    decision.contradiction = worst > 0 ? worst / std::max(size, floor) : 0;
  }

  /// What γ̿ of row k is made of, every term positive.
  double bias_size(const System<S>& system, int k) const {
    const auto length = [](const Vec3<S>& a) { return std::sqrt(to_double(dot(a, a))); };
    double size = std::abs(to_double(system.rhs.closure[k]));
    if (k >= model.closures().body_rows) return size;
    const Closure& c = closure_of_row(k);
    for (const auto& [body, row] :
         {std::pair{c.body_a, system.closure_rows[k].a}, std::pair{c.body_b, system.closure_rows[k].b}})
      if (body != ground)
        size += length(row.moment) * length(at_rest.acceleration[body].angular) +
                length(row.force) * length(at_rest.acceleration[body].linear);
    return size;
  }

  const Closure& closure_of_row(int k) const {
    const auto& closures = model.closures().closures;
    const auto after =
        std::upper_bound(closures.begin(), closures.end(), k, [](int row, const Closure& c) { return row < c.row; });
    return *std::prev(after);
  }

  void check_state(const System<S>& system) {
    decision.position_violation = decision.velocity_violation = 0;
    if (jacobian.rows() == 0) return;  // such a system does not keep its state
    double speed = 1;
    for (int k = 0; k < model.nv(); ++k)
      speed = std::max(speed, std::abs(to_double(system.state.v[k])) * column_unit[k]);
    const double per_speed = 1 / speed;
    for (int k = 0; k < jacobian.rows(); ++k) {
      const auto& row = system.closure_rows[k];
      const double g = std::abs(to_double(row.g)) * scaling.row[k];
      const double rate = std::abs(to_double(row.rate)) * scaling.row[k] * per_speed;
      if (std::max(g, rate) > std::max(decision.position_violation, decision.velocity_violation))
        decision.worst_row = k;
      decision.position_violation = std::max(decision.position_violation, g);
      decision.velocity_violation = std::max(decision.velocity_violation, rate);
    }
  }

  /// Who decided, and how far conditions may then contradict one another: off the manifold redundant ones differ by
  /// what the state violates, of which curvatures make some hundred times.
  void accept(RankPolicy policy) {
    constexpr double spread = 1e3, most = 1e-2;
    const double violation = std::max(decision.position_violation, decision.velocity_violation);
    decision.held = !policy.automatic();
    decision.varying_rank = false;
    decision.tolerated_contradiction =
        largest_contradiction + (decision.held ? std::min(spread * violation, most) : 0.0);
  }

  /// Whether neighbouring states have a larger rank. Known once it was found constant somewhere on the branch.
  void judge_rank(const System<S>& system) {
    decision.varying_rank = false;
    if (decision.redundant == 0 || decision.rank == constant_rank) return;
    if (decision.rank < constant_rank) {
      decision.varying_rank = true;
      return;
    }
    if (!curvature) curvature = std::make_unique<ClosureCurvature>(model);
    State<double> state{system.state.t, {}, {}};
    for (const S& q : system.state.q) state.q.push_back(to_double(q));
    constexpr int trials = 3;
    for (int trial = 0; trial < trials && !decision.varying_rank; ++trial)
      decision.varying_rank = leaves_range((*curvature)(state, kernel_direction(trial)));
    // off the manifold redundant rows are independent, which says nothing about states on it
    const bool assembled = std::max(decision.position_violation, decision.velocity_violation) <= largest_violation;
    if (!decision.varying_rank && assembled) constant_rank = decision.rank;
  }

  /// Some direction in the kernel of G, its largest component 1; zero where there is no kernel, since what projection
  /// leaves there is a rounding error, and the rank cannot grow.
  std::vector<double> kernel_direction(int trial) const {
    Eigen::VectorXd xi(model.nv());
    for (int k = 0; k < model.nv(); ++k) xi[k] = std::sin(1.0 + 0.7 * k * k + 2.3 * trial * (k + 1));  // any will do
    for (const Block& block : blocks) {
      const std::vector<int>& columns = block.part.columns;
      if (block.space->rank() == static_cast<int>(columns.size()))
        xi(columns).setZero();
      else
        xi(columns) = block.space->in_kernel(Eigen::VectorXd(xi(columns)));
    }
    if (const double largest = xi.lpNorm<Eigen::Infinity>(); largest > 0) xi /= largest;
    std::vector<double> v(model.nv());
    for (int k = 0; k < model.nv(); ++k) v[k] = xi[k] * scaling.column[k];
    return v;
  }

  bool leaves_range(const std::vector<double>& rows) const {
    constexpr double rounding = 1e-6;
    for (const Block& block : blocks) {
      if (block.redundant() == 0) continue;
      Eigen::VectorXd scaled(block.rows());
      for (int r = 0; r < block.rows(); ++r) scaled[r] = rows[block.part.rows[r]] * scaling.row[block.part.rows[r]];
      if (block.space->outside(scaled).norm() > rounding) return true;
    }
    return false;
  }
};

template <class S>
ClosureRank<S>::ClosureRank(const Model& model) : work_(std::make_unique<Work>(model)) {}
template <class S>
ClosureRank<S>::~ClosureRank() = default;

template <class S>
const ClosureDecision& ClosureRank<S>::decide(const System<S>& system, RankPolicy policy) {
  Work& work = *work_;
  ClosureDecision& decision = work.decision;
  decision.worst_row = -1;
  decision.by_pivots = false;
  work.jacobian.evaluate(system);
  for (auto& block : work.blocks) work.decompose(block);
  work.choose_rank(policy);
  for (const auto& block : work.blocks) work.select_rows(block);
  // on a motion: rounding errors at rest contradict one another, too, which nobody would notice beside gravity
  constexpr double negligible = 1e-3;
  const Vec3<double>& g = work.model.gravity();
  const double unit = std::sqrt(dot(g, g)) > 0 ? std::sqrt(dot(g, g)) / work.model.length() : 1.0;
  work.split_bias(system, policy.automatic() ? 0 : negligible * unit);
  work.check_state(system);
  work.accept(policy);
  if (policy.automatic()) work.judge_rank(system);
  // what is dropped on the way through a singular configuration is not obeyed there
  decision.dropped = decision.held && decision.rank < policy.rank;
  if (decision.dropped) decision.tolerated_contradiction = std::numeric_limits<double>::infinity();
  return decision;
}

template <class S>
const ClosureDecision& ClosureRank<S>::hold(const System<S>& system, RankPolicy policy) {
  Work& work = *work_;
  ClosureDecision& decision = work.decision;
  decision.worst_row = -1;
  decision.rank = policy.rank;
  decision.redundant = work.jacobian.rows() - policy.rank;
  decision.sigma = decision.next_sigma = std::numeric_limits<double>::quiet_NaN();
  decision.near_singular = decision.dropped = false;
  decision.contradiction = 0;
  if (!decision.by_pivots) {  // else they are from last time
    std::fill(decision.independent.begin(), decision.independent.end(), true);
    std::fill(decision.correction.begin(), decision.correction.end(), 0.0);
  }
  decision.by_pivots = true;
  work.check_state(system);
  work.accept(policy);
  return decision;
}

template <class S>
const ClosureDecision& ClosureRank<S>::decision() const {
  return work_->decision;
}

/// Takes the part outside the range of G away from numbers that are scaled by `unit` a row.
template <class S>
void ClosureRank<S>::remove_outside(std::vector<S>& rows, const std::vector<double>& unit) const {
  for (const auto& block : work_->blocks) {
    if (block.redundant() == 0) continue;
    Eigen::VectorXd scaled(block.rows());
    for (int r = 0; r < block.rows(); ++r) scaled[r] = to_double(rows[block.part.rows[r]]) / unit[block.part.rows[r]];
    const Eigen::VectorXd rest = block.space->outside(scaled);
    for (int r = 0; r < block.rows(); ++r) rows[block.part.rows[r]] -= S(rest[r] * unit[block.part.rows[r]]);
  }
}

template <class S>
void ClosureRank<S>::make_consistent(std::vector<S>& rows) const {
  remove_outside(rows, work_->row_unit);
}

template <class S>
void ClosureRank<S>::minimum_norm(std::vector<S>& lambda) const {
  remove_outside(lambda, work_->scaling.row);
}

template <class S>
double ClosureRank<S>::largest(const std::vector<S>& rows) const {
  double result = 0;
  for (std::size_t k = 0; k < rows.size(); ++k)
    if (const double x = std::abs(to_double(rows[k])) * work_->scaling.row[k]; !(x <= result)) result = x;
  return result;
}

template class ClosureRank<double>;
template class ClosureRank<long double>;
template class ClosureRank<Count>;

}  // namespace lanc
