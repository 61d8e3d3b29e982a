#include "lib/integrate/minimal_coordinates.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "lib/closure/retraction.h"
#include "lib/integrate/full_coordinates.h"
#include "lib/model/coordinates.h"

namespace lanc {
namespace {

/// Errors of the independent coordinates grow by the condition of G^d on their way into the others, and stay there.
constexpr double worst_condition = 10;

}  // namespace

MinimalCoordinates::MinimalCoordinates(MotionSolver& solver, const State<double>& start, const std::vector<int>& chosen,
                                       const std::vector<int>& candidates)
    : solver_(solver),
      nq_(solver.model().nq()),
      scaling_(solver.model()),
      rank_(solver.model()),
      choice_(solver.model(), {.candidates = candidates, .leave = worst_condition}),
      evaluator_(solver.model()),
      jacobian_(solver.model()) {
  if (!chosen.empty()) choice_.choose(chosen);
  choose(start);
}

bool MinimalCoordinates::choose(const State<double>& state) {
  const System<double>& system = solver_.evaluator().system(state, solver_.loads());
  ++solver_.counts().kinematics;
  const ClosureDecision& decision = rank_.decide(system, solver_.policy());
  // where the rank drops for a moment, what was chosen before serves on
  if (!independent_.empty() && decision.rank < solver_.policy().rank) return false;
  const ExplicitConditions& conditions = choice_.at(system, decision);
  rows_.clear();
  for (std::size_t k = 0; k < decision.independent.size(); ++k)
    if (decision.independent[k]) rows_.push_back(static_cast<int>(k));
  dependent_ = conditions.dependent;
  if (conditions.independent == independent_) return false;
  independent_ = conditions.independent;
  scale_ = position_scale(solver_.model());
  const std::vector<double> speeds = velocity_scale(solver_.model());
  for (const int k : independent_) scale_.push_back(speeds[k]);
  scale_.push_back(1);
  return true;
}

void MinimalCoordinates::pack(const MotionPoint& point, double* y) const {
  y = std::copy(point.state.q.begin(), point.state.q.end(), y);
  for (const int k : independent_) *y++ = point.state.v[k];
  *y = point.work;
}

Eigen::VectorXd MinimalCoordinates::violation(const State<Real>& state, bool of_velocities) const {
  system_ = &evaluator_.system(state);
  ++solver_.counts().kinematics;
  Eigen::VectorXd result(static_cast<Eigen::Index>(rows_.size()));
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    const auto& row = system_->closure_rows[rows_[r]];
    result[static_cast<Eigen::Index>(r)] =
        static_cast<double>((of_velocities ? row.rate : row.g) * Real(scaling_.row[rows_[r]]));
  }
  return result;
}

/// The scaled G^d at the last evaluation.
void MinimalCoordinates::factorise() const {
  jacobian_.evaluate(*system_);
  const auto size = static_cast<Eigen::Index>(rows_.size());
  std::vector<Eigen::Index> place(solver_.model().nv(), -1);
  for (std::size_t k = 0; k < dependent_.size(); ++k) place[dependent_[k]] = static_cast<Eigen::Index>(k);
  Eigen::MatrixXd G = Eigen::MatrixXd::Zero(size, size);
  for (Eigen::Index r = 0; r < size; ++r)
    for (int p = jacobian_.starts()[rows_[r]]; p < jacobian_.starts()[rows_[r] + 1]; ++p) {
      const int c = jacobian_.columns()[p];
      if (place[c] >= 0)
        G(r, place[c]) = static_cast<double>(jacobian_.values()[p]) * scaling_.row[rows_[r]] * scaling_.column[c];
    }
  dependent_columns_.compute(G);
}

std::vector<MinimalCoordinates::Real> MinimalCoordinates::correction(const Eigen::VectorXd& violation) const {
  const Eigen::VectorXd x = dependent_columns_.solve(violation);
  std::vector<Real> result(solver_.model().nv(), Real(0));
  for (std::size_t k = 0; k < dependent_.size(); ++k)
    result[dependent_[k]] = -Real(x[static_cast<Eigen::Index>(k)]) * Real(scaling_.column[dependent_[k]]);
  return result;
}

/// An estimate of 1/σ_min of the scaled G^d, by inverse iteration.
double MinimalCoordinates::inverse_size() const {
  const auto size = static_cast<Eigen::Index>(rows_.size());
  if (size == 0) return 0;
  Eigen::VectorXd x(size);
  for (Eigen::Index k = 0; k < size; ++k) x[k] = std::sin(1.0 + 0.7 * static_cast<double>(k * k));  // any will do
  double result = 0;
  for (int step = 0; step < 3; ++step) {
    x /= x.norm();
    x = dependent_columns_.solve_transposed(dependent_columns_.solve(x));
    result = std::sqrt(x.norm());
  }
  return result;
}

/// β^d(q_s, t) by Newton's method, as far as rounding allows. Only from where it leads to the solution nearby, by the
/// criterion of Kantorovich (‖G_d⁻¹‖ ‖G_d⁻¹ g‖ |g''| ≤ ½; curvatures are of the order of 1 in the model's length): near
/// a singular configuration branches cross, and another one must not be taken.
bool MinimalCoordinates::find_positions(State<Real>& state) const {
  constexpr double accepted = 1e-13, rounding = 1e-18, most_curved = 0.25;
  constexpr int most_steps = 30;
  double before = std::numeric_limits<double>::infinity();
  for (int step = 0; step < most_steps; ++step) {
    const Eigen::VectorXd g = violation(state, false);
    const double error = g.size() == 0 ? 0 : g.lpNorm<Eigen::Infinity>();
    if (!(error < 1e3)) return false;
    factorise();
    if (step == 0) {
      const double first = dependent_columns_.solve(g).lpNorm<Eigen::Infinity>();
      if (!(first * inverse_size() <= most_curved)) return false;
    }
    if (error <= rounding || (error < accepted && error > before / 4)) return true;
    before = error;
    state.q = moved(solver_.model(), state.q, correction(g));
  }
  return false;
}

/// η^d = −(G^d)⁻¹ (Gⁱ s + γ̄), refined until rounding of ġ stops it.
bool MinimalCoordinates::find_velocities(State<Real>& state) const {
  constexpr int most_steps = 6;
  double before = std::numeric_limits<double>::infinity();
  for (int step = 0; step < most_steps; ++step) {
    const Eigen::VectorXd rate = violation(state, true);
    const double error = rate.size() == 0 ? 0 : rate.lpNorm<Eigen::Infinity>();
    if (!std::isfinite(error)) return false;
    if (error == 0 || (step > 1 && error > before / 4)) return true;
    before = error;
    const std::vector<Real> change = correction(rate);
    for (const int k : dependent_) state.v[k] += change[k];
  }
  return true;
}

std::optional<MotionPoint> MinimalCoordinates::complete(double t, const double* y) const {
  State<Real> state{t, {y, y + nq_}, std::vector<Real>(solver_.model().nv(), Real(0))};
  normalise(solver_.model(), state.q.data());
  for (std::size_t k = 0; k < independent_.size(); ++k) state.v[independent_[k]] = y[nq_ + k];
  if (!find_positions(state) || !find_velocities(state)) return std::nullopt;
  MotionPoint point{{t, {state.q.begin(), state.q.end()}, {state.v.begin(), state.v.end()}}, y[size() - 1]};
  normalise(solver_.model(), point.state.q.data());
  return point;
}

MotionPoint MinimalCoordinates::unpack(double t, const double* y) const {
  if (std::optional<MotionPoint> point = complete(t, y)) return *point;
  MotionPoint open{{t, {y, y + nq_}, std::vector<double>(solver_.model().nv())}, y[size() - 1]};
  normalise(solver_.model(), open.state.q.data());
  return open;
}

Evaluation MinimalCoordinates::rate(double t, const double* y, double* ydot) {
  const std::optional<MotionPoint> point = complete(t, y);
  if (!point) {
    outcome_ = {Status::not_converged, "the dependent coordinates cannot be found from the independent ones"};
    return Evaluation::retry;
  }
  outcome_ = solver_.solve(point->state);
  if (!outcome_.usable()) return evaluation_of(outcome_, solver_.policy());
  coordinate_rates(solver_.model(), point->state.q.data(), point->state.v.data(), ydot);
  ydot += nq_;
  for (const int k : independent_) *ydot++ = solver_.solution().vdot[k];
  *ydot = solver_.power().total();
  return Evaluation::fine;
}

Evaluation MinimalCoordinates::jacobian(double, const double*, double*) {
  outcome_ = {Status::objection, "minimal coordinates are not offered for implicit integrators"};
  return Evaluation::stop;
}

Settled MinimalCoordinates::settle(double t, std::span<double> y) {
  const std::optional<MotionPoint> point = complete(t, y.data());
  if (!point) {
    outcome_ = {Status::not_converged, "the dependent coordinates cannot be found from the independent ones"};
    return Settled::failed;
  }
  const bool changed = choose(point->state);
  pack(*point, y.data());
  return changed ? Settled::renewed : Settled::kept;
}

}  // namespace lanc
