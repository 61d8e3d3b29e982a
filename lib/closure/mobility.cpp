#include "lib/closure/mobility.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "lib/closure/assembly.h"
#include "lib/closure/rank.h"
#include "lib/closure/retraction.h"
#include "lib/closure/scaling.h"
#include "lib/closure/second_order.h"
#include "lib/solve/dense.h"
#include "lib/system/equations.h"
#include "lib/system/evaluator.h"

namespace lanc {
namespace {

constexpr double support = 1e-8;  // entries of unit vectors that are not rounding

/// The analysis of one mechanism at one state.
class Analysis {
 public:
  Analysis(const Model& model, const State<double>& state)
      : model_(model), state_(state), scaling_(model), evaluator_(model) {}

  Mobility run() {
    const System<double>& system = evaluator_.system(state_);
    const ClosureDecomposition here = decompose_closures(system);
    count(system, here);
    name_redundant_rows(here);
    find_unique_reactions(system, here);
    judge(here);
    return result_;
  }

 private:
  void count(const System<double>& system, const ClosureDecomposition& here) {
    const int nv = model_.nv(), rows = model_.closures().rows(), n = model_.bodies();
    result_.velocities = nv, result_.closure_rows = rows, result_.grubler = nv - rows;
    result_.rank = result_.generic_rank = here.rank;
    result_.mobility = nv - here.rank;
    result_.sigma = here.sigma_at(here.rank), result_.next_sigma = here.sigma_at(here.rank + 1);
    result_.absolute_coordinates = 6 * n;
    result_.absolute_rows = 6 * n - nv + rows;
    result_.absolute_rank = 6 * n - nv + here.rank;
    for (int k = 0; k < rows; ++k)
      result_.position_violation =
          std::max(result_.position_violation, std::abs(system.closure_rows[k].g) * scaling_.row[k]);
  }

  void name_redundant_rows(const ClosureDecomposition& here) {
    const Eigen::MatrixXd left = here.left_kernel();
    if (left.cols() == 0) return;
    for (int k = 0; k < left.rows(); ++k)
      if (left.row(k).lpNorm<Eigen::Infinity>() > support) result_.redundant_rows.push_back(k);
    // Rows that the null space can best be expressed by: the rest is independent.
    const std::vector<int> order = pivot_order(left.transpose());
    result_.removable_rows.assign(order.begin(), order.begin() + left.cols());
    std::sort(result_.removable_rows.begin(), result_.removable_rows.end());
  }

  /// Multipliers of the left null space load the mechanism with self-stress, at rest and without any other load.
  void find_unique_reactions(const System<double>& system, const ClosureDecomposition& here) {
    const Eigen::MatrixXd left = here.left_kernel();
    result_.unique.assign(model_.bodies(), {true, true, true, true, true, true});
    result_.unique_row.assign(left.rows(), true);
    RightHandSide<double> none(model_);
    Solution<double> stressed(model_);
    for (int mode = 0; mode < left.cols(); ++mode) {
      for (int k = 0; k < left.rows(); ++k) {
        stressed.lambda[k] = left(k, mode) * scaling_.row[k];
        if (std::abs(left(k, mode)) > support) result_.unique_row[k] = false;
      }
      wrenches(system, none, stressed);
      for (int i = 0; i < model_.bodies(); ++i) {
        // in units of λ_s = 1: a force of 1 / L where the row is a length
        const Wrench<double>& f = stressed.wrench[i];
        const double L = model_.length(),
                     parts[] = {f.moment.x, f.moment.y, f.moment.z, f.force.x * L, f.force.y * L, f.force.z * L};
        for (int c = 0; c < 6; ++c)
          if (std::abs(parts[c]) > support) result_.unique[i][c] = false;
      }
    }
  }

  void judge(const ClosureDecomposition& here) {
    result_.finite_mobility = result_.mobility;
    if (here.rank == result_.closure_rows) return;
    result_.verdict = Verdict::overconstrained;
    if (result_.mobility == 0) return;
    const SecondOrder second(model_, state_, here);
    // many: where N loops are singular at once there are 3^N branches, and the largest rank is on few of them
    constexpr int starts = 512;
    std::vector<Eigen::VectorXd> directions = second.tangents(starts);
    if (second.vanishes()) directions.resize(std::min<std::size_t>(directions.size(), 8));
    for (const Eigen::VectorXd& direction : directions) {
      walk(direction);
      walk(-direction);
    }
    result_.finite_mobility = result_.velocities - result_.generic_rank;
    if (result_.generic_rank > here.rank) {
      result_.verdict = Verdict::singular;
    } else if (!second.vanishes()) {
      // Curved away from every first-order motion, or towards ones that lead nowhere.
      result_.verdict = result_.walks == 0 ? Verdict::shaky : Verdict::singular;
      if (result_.walks == 0) result_.finite_mobility = 0;
    }
  }

  /// Some steps along the manifold; the ranks met go into generic_rank.
  void walk(Eigen::VectorXd direction) {
    constexpr int steps = 4;
    constexpr double length = 0.07;  // scaled
    State<double> state = state_;
    std::fill(state.v.begin(), state.v.end(), 0.0);
    Evaluator<double> evaluator(model_);
    for (int step = 0; step < steps; ++step) {
      direction.normalize();
      State<double> guess = state;
      std::vector<double> v(model_.nv());
      for (int k = 0; k < model_.nv(); ++k) v[k] = direction[k] * length * scaling_.column[k];
      guess.q = moved(model_, state.q, v);
      AssemblyOptions nearby;
      nearby.starts = 1;
      // dimensions that are not exact keep an overconstrained linkage as far open all along the walk
      nearby.tolerance = std::max(nearby.tolerance, 10 * result_.position_violation);
      const AssemblyResult next = assemble(model_, guess, nearby);
      if (!next.assembled() || moved_less(guess, next.state, length / 2)) return;
      state = next.state;
      const ClosureDecomposition there = decompose_closures(evaluator.system(state));
      result_.generic_rank = std::max(result_.generic_rank, there.rank);
      const Eigen::MatrixXd kernel = there.kernel();
      direction = kernel * (kernel.transpose() * direction);
      if (step == 0) ++result_.walks;
      if (!(direction.norm() > 0.5)) return;
    }
  }

  /// Whether assembly took back more than `bound` of the step that led to the guess.
  bool moved_less(const State<double>& guess, const State<double>& assembled, double bound) const {
    double square = 0;
    for (int i = 0; i < model_.bodies(); ++i) {
      const Link& link = model_.link(i);
      for (int k = 0; k < link.nq; ++k) {
        const double change = assembled.q[link.q + k] - guess.q[link.q + k];
        const bool is_length = link.kind.traits().q_units[k] == "m";
        square += std::pow(is_length ? change / model_.length() : change, 2);
      }
    }
    return std::sqrt(square) > bound;
  }

  Model model_;
  State<double> state_;
  ClosureScaling scaling_;
  Evaluator<double> evaluator_;
  Mobility result_;
};

}  // namespace

Mobility analyse_mobility(const Model& model, const State<double>& state) {
  constexpr int most = 2000;
  if (!model.has_closures()) {
    Mobility tree;
    tree.velocities = tree.grubler = tree.mobility = tree.finite_mobility = model.nv();
    tree.unique.assign(model.bodies(), {true, true, true, true, true, true});
    tree.absolute_coordinates = 6 * model.bodies();
    tree.absolute_rows = tree.absolute_rank = 6 * model.bodies() - model.nv();
    return tree;
  }
  if (std::max(model.nv(), model.closures().rows()) > most)
    throw InputError(
        fmt::format("mobility is analysed by dense singular values: {} velocities and {} closure "
                    "conditions are more than {}; analyse a shorter mechanism of the kind",
                    model.nv(), model.closures().rows(), most));
  return Analysis(model, state).run();
}

}  // namespace lanc
