#include "lib/integrate/minimal_coordinates.h"

#include <algorithm>
#include <limits>

#include "lib/integrate/coordinates.h"
#include "lib/integrate/full_coordinates.h"

namespace lanc {
namespace {

constexpr double never = std::numeric_limits<double>::infinity();

}  // namespace

MinimalCoordinates::MinimalCoordinates(MotionSolver& solver, const State<double>& start,
                                       const std::vector<int>& chosen, const std::vector<int>& candidates)
    : solver_(solver),
      nq_(solver.model().nq()),
      rank_(solver.model()),
      evaluator_(solver.model()),
      choice_(solver.model(), {.candidates = candidates}),
      fixed_(solver.model(), {.candidates = candidates, .leave = never}) {
  if (!chosen.empty()) choice_.choose(chosen);
  independent_ = conditions(start, choice_).independent;
  fixed_.choose(independent_);
  dependent_ = conditions(start, fixed_);
  set_scale();
}

void MinimalCoordinates::set_scale() {
  scale_ = position_scale(solver_.model());
  const std::vector<double> speeds = velocity_scale(solver_.model());
  for (const int k : independent_) scale_.push_back(speeds[k]);
  scale_.push_back(1);
}

const ExplicitConditions& MinimalCoordinates::conditions(const State<double>& state, ExplicitClosures& closures) const {
  const System<double>& system = evaluator_.system(state);
  ++solver_.counts().kinematics;
  return closures.at(system, rank_.decide(system, solver_.policy()));
}

void MinimalCoordinates::pack(const MotionPoint& point, double* y) const {
  y = std::copy(point.state.q.begin(), point.state.q.end(), y);
  for (const int k : independent_) *y++ = point.state.v[k];
  *y = point.work;
}

std::optional<MotionPoint> MinimalCoordinates::complete(double t, const double* y) const {
  State<double> guess{t, {y, y + nq_}, std::vector<double>(solver_.model().nv())};
  normalise(solver_.model(), guess.q.data());
  std::optional<State<double>> state = solve_dependent(solver_.model(), std::move(guess), dependent_);
  if (!state) return std::nullopt;
  const ExplicitConditions& now = conditions(*state, fixed_);
  const Eigen::Map<const Eigen::VectorXd> s(y + nq_, static_cast<Eigen::Index>(independent_.size()));
  Eigen::Map<Eigen::VectorXd>(state->v.data(), static_cast<Eigen::Index>(state->v.size())) = now.J * s + now.eta;
  return MotionPoint{std::move(*state), y[size() - 1]};
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
  counts_ = solver_.counts();
  if (!outcome_.usable()) return evaluation_of(outcome_);
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
  const std::vector<int>& better = conditions(point->state, choice_).independent;
  const bool changed = better != independent_;
  if (changed) {
    independent_ = better;
    fixed_.choose(independent_);
    dependent_ = conditions(point->state, fixed_);
    set_scale();
  }
  pack(*point, y.data());
  return changed ? Settled::renewed : Settled::kept;
}

}  // namespace lanc
