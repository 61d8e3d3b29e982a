#include "lib/integrate/motion_solver.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "lib/closure/mobility.h"
#include "lib/closure/retraction.h"

namespace lanc {

MotionSolver::MotionSolver(const Model& model, const FormulationInfo& formulation, Loads<double> loads)
    : model_(model),
      loads_(std::move(loads)),
      evaluator_(model),
      scaling_(model),
      solution_(model),
      change_(model),
      rhs_(model) {
  if (!formulation.create_double) throw InputError(fmt::format("'{}' does not run on double", formulation.name));
  if (const auto why = formulation.objection(model))
    throw InputError(fmt::format("formulation '{}' cannot take this model: {}", formulation.name, *why));
  formulation_ = formulation.create_double(model);
}

void MotionSolver::evaluate(const State<double>& state) {
  state_ = state;
  system_ = &evaluator_.system(state, loads_);
  ++counts_.kinematics;
}

Outcome MotionSolver::hold(const State<double>& state, bool through_singular) {
  policy_ = {};
  Outcome outcome = solve(state);
  if (!model_.has_closures()) return outcome;
  int rank = outcome.rank;
  if (outcome.status == Status::singular && through_singular) rank = analyse_mobility(model_, state).generic_rank;
  policy_.rank = rank;
  if (through_singular) policy_.smallest = passing_singular_value;
  if (outcome.status == Status::singular && through_singular) outcome = solve(state);
  return outcome;
}

Outcome MotionSolver::solve(const State<double>& state, double alpha) {
  evaluate(state);
  if (alpha > 0) evaluator_.stabilise(alpha);
  ++counts_.rates;
  Outcome outcome = formulation_->solve(*system_, solution_, policy_);
  if (model_.has_closures() && outcome.rank > 0) sigma_ = outcome.rank < policy_.rank ? 0 : outcome.sigma;
  return outcome;
}

Power MotionSolver::power() { return lanc::power(evaluator_, *system_, state_, loads_, solution_); }

double MotionSolver::position_violation() const {
  double largest = 0;
  for (std::size_t k = 0; k < system_->closure_rows.size(); ++k)
    if (const double g = std::abs(system_->closure_rows[k].g) * scaling_.row[k]; !(g <= largest)) largest = g;
  return largest;
}

double MotionSolver::velocity_violation() const {
  double largest = 0, speed = 1;
  for (int k = 0; k < model_.nv(); ++k) speed = std::max(speed, std::abs(state_.v[k]) / scaling_.column[k]);
  for (std::size_t k = 0; k < system_->closure_rows.size(); ++k)
    if (const double g = std::abs(system_->closure_rows[k].rate) * scaling_.row[k]; !(g <= largest)) largest = g;
  return largest / speed;
}

/// Least change of velocities with G δ = −violation, into change_.vdot.
Outcome MotionSolver::move(const std::vector<double>& violation) {
  Outcome outcome = formulation_->prepare(*system_, policy_);
  if (!outcome.usable()) return outcome;
  rhs_.set_zero();
  rhs_.closure = violation;
  formulation_->respond(*system_, rhs_, change_);
  return outcome;
}

Outcome MotionSolver::project(State<double>& state) {
  if (!model_.has_closures()) return {};
  constexpr double rounding = 1e-14, accepted = 1e-10;
  constexpr int most_steps = 12;
  std::vector<double> violation(model_.closures().rows());
  double before = std::numeric_limits<double>::infinity();
  bool dropped = false;  // singular: fewer conditions than held
  const auto correct = [&]() -> Outcome {
    const Outcome outcome = move(violation);
    dropped = outcome.rank < policy_.rank;
    return outcome;
  };
  evaluate(state);
  for (int step = 0; step < most_steps; ++step) {
    const double error = position_violation();
    if (error <= rounding || (error < accepted && error > before / 4)) break;
    before = error;
    for (std::size_t k = 0; k < violation.size(); ++k) violation[k] = system_->closure_rows[k].g;
    if (Outcome outcome = correct(); !outcome.usable()) return outcome;
    state.q = moved(model_, state.q, change_.vdot);
    evaluate(state);
  }
  before = std::numeric_limits<double>::infinity();
  for (int step = 0; step < 3; ++step) {  // linear: the later ones take away rounding errors
    const double error = velocity_violation();
    if (error <= rounding || (error < accepted && error > before / 4)) break;
    before = error;
    for (std::size_t k = 0; k < violation.size(); ++k) violation[k] = system_->closure_rows[k].rate;
    if (Outcome outcome = correct(); !outcome.usable()) return outcome;
    for (int k = 0; k < model_.nv(); ++k) state.v[k] += change_.vdot[k];
    evaluate(state);
  }
  const double left = std::max(position_violation(), velocity_violation());
  // conditions that are dropped for a moment are not followed, either
  constexpr double accepted_of_dropped = 1e-6;
  if (left <= (dropped ? accepted_of_dropped : accepted)) return {};
  Outcome outcome;
  outcome.status = Status::inconsistent;
  outcome.message = fmt::format("projection on the closure conditions does not converge: {:.1e} is left", left);
  return outcome;
}

}  // namespace lanc
