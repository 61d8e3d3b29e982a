#include "lib/formulation/formulation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "lib/formulation/judgement.h"
#include "lib/system/equations.h"

namespace lanc {

template <class S>
struct Formulation<S>::Refinement {
  RightHandSide<S> residual;
  Solution<S> correction, probe;
  explicit Refinement(const Model& model) : residual(model), correction(model), probe(model) {}
};

template <class S>
Formulation<S>::Formulation(const Model& model) : model_(model) {
  if (model.has_singular_inertia()) refinement_ = std::make_unique<Refinement>(model);
}

template <class S>
Formulation<S>::~Formulation() = default;

namespace {

/// Refinement must bring its correction below √ε of the answer within a few steps: then the answer has half of its
/// digits at least. Where it stagnates above, the size of the correction is the error that remains.
constexpr double largest_correction = 1e-8;
constexpr int most_refinements = 3;
/// A known answer must come back with this relative error at least; from a singular matrix any other comes back.
constexpr double largest_probe_error = 1e-3;

}  // namespace

template <class S>
Outcome Formulation<S>::solve(const System<S>& system, Solution<S>& solution) {
  using judgement::FirstLook;
  assemble(system);
  Outcome outcome = factorise(system);
  if (outcome.usable()) {
    substitute(system, system.rhs, solution);
    drive_forces(system, solution);
    const FirstLook look = judgement::first_look(system, solution);
    if (look == FirstLook::not_finite)
      outcome = {
          Status::singular,
          "the answer is not finite: a pivot vanished or has the wrong sign, so the mass matrix is singular or not "
          "positive definite at this state"};
    else if (look == FirstLook::suspicious || model_.has_singular_inertia())
      outcome = verified(system, solution);
  }
  if (!outcome.usable() && !judgement::finite(system))
    outcome = {Status::not_finite,
               "the coefficients of eq. 14 are not finite, or overflow; look at the state, the loads and the motions"};
  return outcome;
}

/// Refines the answer, and sees whether the factors bring back an answer that is known. The second is needed because a
/// singular system that happens to have solutions has no residual.
template <class S>
Outcome Formulation<S>::verified(const System<S>& system, Solution<S>& solution) {
  Outcome outcome;
  for (int step = 0; step < most_refinements && !(outcome.forward_error < largest_correction); ++step)
    outcome.forward_error = refine(system, solution);
  const bool refined = outcome.forward_error < largest_correction;
  const double probe = refined ? probe_error(system) : 0;
  if (refined && probe < largest_probe_error) return outcome;
  const int body = model_.singular_inertia_body();
  outcome.status = Status::singular;
  outcome.message =
      fmt::format("the mass matrix is singular to working precision ({}); {}",
                  refined ? fmt::format("a known answer comes back with an error of {:.1e}", probe)
                          : fmt::format("refinement changes the answer by {:.1e} of itself", outcome.forward_error),
                  body < 0 ? "some bodies are too light for what they are fastened to"
                           : fmt::format("body '{}' or one it carries has too little inertia for its freedoms",
                                         model_.spec().bodies[body].name));
  return outcome;
}

template <class S>
double Formulation<S>::probe_error(const System<S>& system) {
  // Without loads and velocities eq. 14 is M̄ η̇ = τ: the τ of given accelerations, and back.
  Solution<S>& known = refinement_->probe;
  Solution<S>& found = refinement_->correction;
  RightHandSide<S>& rhs = refinement_->residual;
  const S zero(0.0);
  const Vec3<S> none{zero, zero, zero};
  for (int i = 0; i < model_.bodies(); ++i) rhs.force[i] = {none, none}, rhs.bias[i] = {none, none};
  for (int k = 0; k < model_.nv(); ++k) {
    const double unit = model_.column_kind(k) == ColumnKind::translation ? 1 : 1 / model_.length();
    known.vdot[k] = S(unit * (k % 3 == 0 ? 1.0 : k % 3 == 1 ? -0.75 : 0.5));
  }
  accelerations(system, rhs, known);
  wrenches(system, rhs, known);
  for (int k = 0; k < model_.nv(); ++k) {
    rhs.tau[k] = project(model_.column_kind(k), system.columns[k], known.wrench[model_.body_of_velocity(k)]);
    if (model_.armature()[k] != 0) rhs.tau[k] += S(model_.armature()[k]) * known.vdot[k];
  }
  substitute(system, rhs, found);
  double error = 0;
  for (int k = 0; k < model_.nv(); ++k) {
    const double change = std::abs(to_double(found.vdot[k]) - to_double(known.vdot[k]));
    const double unit = model_.column_kind(k) == ColumnKind::translation ? 1 : model_.length();
    if (!(change * unit <= error)) error = change * unit;
  }
  return error;
}

template <class S>
double Formulation<S>::refine(const System<S>& system, Solution<S>& solution) {
  if (!refinement_) refinement_ = std::make_unique<Refinement>(model_);
  Solution<S>& correction = refinement_->correction;
  residual(system, system.rhs, solution, refinement_->residual);
  substitute(system, refinement_->residual, correction);
  judgement::Sizes size(model_, solution);
  size.include_loads(system);
  for (int k = 0; k < model_.nv(); ++k) solution.vdot[k] += correction.vdot[k];
  for (int i = 0; i < model_.bodies(); ++i) {
    solution.acceleration[i] += correction.acceleration[i];
    solution.wrench[i] += correction.wrench[i];
  }
  drive_forces(system, solution);
  return judgement::relative(judgement::Sizes(model_, correction), size);
}

template class Formulation<double>;
template class Formulation<long double>;
template class Formulation<Count>;

}  // namespace lanc
