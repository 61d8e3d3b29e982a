#include "lib/closure/loop_search.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "lib/closure/alignment.h"
#include "lib/closure/rank.h"
#include "lib/closure/retraction.h"
#include "lib/solve/dense.h"

namespace lanc {
namespace {

constexpr double longest_step = 0.5;         // scaled: rad, or model lengths
constexpr double longest_newton_step = 0.1;  // beyond it a Newton step may reach another branch
constexpr double newton_from = 1e-6;         // largest scaled |g| from which Newton takes over
constexpr double first_damping = 1e-2;       // of |g|
constexpr double smallest_damping = 1e-10, largest_damping = 1e10;
constexpr double stationary_gradient = 1e-5;  // |Gᵀg| / (max(σ_1, 1) |g|)
constexpr double flat_gradient = 1e-3;        // the same, for a search that has stalled

/// Positions that velocity k of the model changes, appended.
void add_positions(const Model& model, int k, std::vector<int>& positions) {
  const Link& link = model.link(model.body_of_velocity(k));
  if (link.kind.traits().rates_are_velocities())
    positions.push_back(link.q + k - link.v);
  else if (k == link.v)
    for (int i = 0; i < link.nq; ++i) positions.push_back(link.q + i);
}

double relative_gradient(const Loop& loop) {
  // like a rank decision: where all of G vanishes, σ_1 is no unit to measure with
  const double unit = std::max(1.0, loop.sigma.size() > 0 ? loop.sigma[0] : 0.0);
  return (loop.G.transpose() * loop.g).norm() / (loop.g.norm() * unit);
}

/// −V diag(f(σ)) Uᵀ g.
template <class Filter>
Eigen::VectorXd filtered(const Loop& loop, Filter filter) {
  const Eigen::VectorXd c = loop.U.transpose() * loop.g;
  Eigen::VectorXd weighted(c.size());
  for (Eigen::Index k = 0; k < c.size(); ++k) weighted[k] = -filter(loop.sigma[k]) * c[k];
  return loop.V * weighted;
}

}  // namespace

LoopSearch::LoopSearch(const Model& model, double tolerance, int steps)
    : model_(model), tolerance_(tolerance), most_steps_(steps), scaling_(model), evaluator_(model), jacobian_(model) {
  for (ClosureComponent& part : closure_components(jacobian_.starts(), jacobian_.columns(), model.nv())) {
    Loop loop;
    for (const int k : part.columns) add_positions(model, k, loop.positions);
    loop.part = std::move(part);
    loops_.push_back(std::move(loop));
  }
}

void LoopSearch::evaluate(const State<double>& state) {
  const System<double>& system = evaluator_.system(state);
  jacobian_.evaluate(system);
  g_.resize(jacobian_.rows());
  for (int k = 0; k < jacobian_.rows(); ++k) g_[k] = system.closure_rows[k].g * scaling_.row[k];
  double square = 0;
  for (const Vec3<double>& p : evaluator_.positions()) square = std::max(square, dot(p, p));
  extent_ = std::max(1.0, std::sqrt(square) / model_.length());
  for (Loop& loop : loops_) {
    loop.g.resize(static_cast<Eigen::Index>(loop.part.rows.size()));
    for (Eigen::Index r = 0; r < loop.g.size(); ++r) loop.g[r] = g_[loop.part.rows[r]];
  }
}

void LoopSearch::begin(Loop& loop) {
  loop.end = LoopEnd::running;
  loop.damping = first_damping;
  loop.steps = 0;
  loop.fresh = true;
  loop.newton = loop.newton_failed = false;
}

/// G of the place last evaluated, factorised. It depends on the loop's own coordinates only.
void LoopSearch::read(Loop& loop) const {
  const auto m = static_cast<Eigen::Index>(loop.part.rows.size());
  const auto n = static_cast<Eigen::Index>(loop.part.columns.size());
  loop.G.setZero(m, n);
  for (Eigen::Index r = 0; r < m; ++r) {
    const int k = loop.part.rows[r];
    for (int p = jacobian_.starts()[k]; p < jacobian_.starts()[k + 1]; ++p) {
      const int c = jacobian_.columns()[p];
      loop.G(r, loop.part.local_column(c)) = jacobian_.values()[p] * scaling_.row[k] * scaling_.column[c];
    }
  }
  if (n == 0) {  // between bodies that cannot move against one another
    loop.U.resize(m, 0), loop.V.resize(0, 0), loop.sigma.resize(0);
    return;
  }
  SingularValues svd = singular_values(loop.G, SingularVectors::thin);
  loop.U = std::move(svd.U), loop.V = std::move(svd.V), loop.sigma = std::move(svd.sigma);
}

/// Decides whether the loop has ended where it is; else finds its next step.
void LoopSearch::prepare(Loop& loop) {
  constexpr double rounding = 2 * std::numeric_limits<double>::epsilon();
  const double largest = loop.largest();
  const bool good = largest <= tolerance_ * extent_;
  if (!loop.g.allFinite()) {
    loop.end = LoopEnd::not_finite;
    return;
  }
  if (largest <= rounding * extent_ || (good && (loop.newton_failed || loop.steps >= most_steps_))) {
    loop.end = LoopEnd::closed;
    return;
  }
  if (loop.fresh) {
    read(loop);
    if (!loop.G.allFinite()) {
      loop.end = LoopEnd::not_finite;
      return;
    }
    loop.fresh = false;
  }
  const bool exhausted = loop.steps >= most_steps_ || loop.damping > largest_damping;
  if (!good && loop.part.columns.empty())
    loop.end = LoopEnd::stationary;
  else if (largest > newton_from && relative_gradient(loop) <= (exhausted ? flat_gradient : stationary_gradient))
    loop.end = LoopEnd::stationary;
  else if (exhausted)
    loop.end = good ? LoopEnd::closed : LoopEnd::stalled;
  else
    propose(loop);
}

void LoopSearch::propose(Loop& loop) const {
  ++loop.steps;
  loop.newton = loop.largest() <= newton_from && !loop.newton_failed;
  if (loop.newton) {
    const double threshold = zero_singular_value * std::max(1.0, loop.sigma.size() > 0 ? loop.sigma[0] : 0.0);
    loop.step = filtered(loop, [&](double s) { return s > threshold ? 1 / s : 0.0; });
    if (loop.step.size() == 0 || loop.step.lpNorm<Eigen::Infinity>() <= longest_newton_step) return;
    loop.newton = false;
  }
  for (;; loop.damping *= 4) {
    const double mu = loop.damping * loop.g.norm();
    loop.step = filtered(loop, [&](double s) { return s / (s * s + mu); });
    if (loop.step.size() == 0 || loop.step.lpNorm<Eigen::Infinity>() <= longest_step) break;
  }
  loop.predicted = loop.g.squaredNorm() - (loop.g + loop.G * loop.step).squaredNorm();
}

/// Whether the step was good; g is that of the trial, `before` the one it came from.
bool LoopSearch::judge(Loop& loop, const Eigen::VectorXd& before) const {
  if (loop.newton) {
    const bool good = loop.largest() <= before.lpNorm<Eigen::Infinity>() / 2;
    loop.newton_failed = !good;
    return good;
  }
  const double gain = (before.squaredNorm() - loop.g.squaredNorm()) / loop.predicted;
  const bool good = gain > 1e-4;  // false for NaN
  if (!(gain > 0.25)) loop.damping *= 4;
  if (gain > 0.75) loop.damping = std::max(loop.damping / 4, smallest_damping);
  if (good) loop.newton_failed = false;
  return good;
}

/// Away from a flipped closure: its rows are sines, which must grow before they vanish the right way round.
void LoopSearch::turn_over(State<double>& state, const std::vector<int>& which) {
  constexpr int most_turns = 15;
  constexpr double turn = 0.3, damping = 1e-2;
  const ClosureSet& set = model_.closures();
  for (int step = 0; step < most_turns; ++step) {
    evaluate(state);
    std::vector<double> wanted = g_;
    std::vector<bool> flipped(set.rows());
    for (const int c : flipped_closures(model_, state.t, evaluator_, evaluator_.positions())) {
      const Closure& closure = set.closures[c];
      double size = 0;
      for (int k = closure.row; k < closure.row + closure.conditions().count; ++k)
        if (!set.row_is_length[k]) size = std::hypot(size, g_[k]), flipped[k] = true;
      for (int k = closure.row; k < closure.row + closure.conditions().count; ++k)
        if (flipped[k])
          wanted[k] = size > 1e-3 ? -turn * g_[k] / size : -turn / (1 + k - closure.row);  // any way will do
    }
    std::vector<double> change(model_.nv(), 0.0);
    bool turning = false;
    for (const int i : which) {
      Loop& loop = loops_[i];
      const auto& rows = loop.part.rows;
      if (std::none_of(rows.begin(), rows.end(), [&](int k) { return flipped[k]; }) || !loop.g.allFinite()) continue;
      read(loop);
      if (!loop.G.allFinite()) continue;
      for (std::size_t r = 0; r < rows.size(); ++r) loop.g[static_cast<Eigen::Index>(r)] = wanted[rows[r]];
      loop.step = filtered(loop, [&](double s) { return s / (s * s + damping); });
      if (loop.step.size() == 0) continue;
      loop.step *= std::min(1.0, longest_step / loop.step.lpNorm<Eigen::Infinity>());
      put(loop, change);
      turning = true;
    }
    if (!turning) return;
    state.q = moved(model_, state.q, change);
  }
}

void LoopSearch::put(const Loop& loop, std::vector<double>& change) const {
  for (std::size_t c = 0; c < loop.part.columns.size(); ++c)
    change[loop.part.columns[c]] = loop.step[static_cast<Eigen::Index>(c)] * scaling_.column[loop.part.columns[c]];
}

void LoopSearch::run(State<double>& state, const std::vector<int>& which) {
  turn_over(state, which);
  for (const int i : which) begin(loops_[i]);
  evaluate(state);
  std::vector<double> change(model_.nv());
  std::vector<int> moving;
  std::vector<Eigen::VectorXd> before(loops_.size());
  for (;;) {
    moving.clear();
    std::fill(change.begin(), change.end(), 0.0);
    for (const int i : which) {
      Loop& loop = loops_[i];
      if (loop.end != LoopEnd::running) continue;
      prepare(loop);
      if (loop.end != LoopEnd::running) continue;
      moving.push_back(i);
      before[i] = loop.g;
      put(loop, change);
    }
    if (moving.empty()) return;
    State<double> trial = state;
    trial.q = moved(model_, state.q, change);
    evaluate(trial);
    for (const int i : moving) {
      Loop& loop = loops_[i];
      if (judge(loop, before[i])) {
        for (const int k : loop.positions) state.q[k] = trial.q[k];
        loop.fresh = true;
      } else {
        loop.g = before[i];
      }
    }
  }
}

}  // namespace lanc
