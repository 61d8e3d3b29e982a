#include "lib/formulation/formulation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "lib/system/equations.h"

namespace lanc {

template <class S>
struct Formulation<S>::Refinement {
  RightHandSide<S> residual;
  Solution<S> correction;
  explicit Refinement(const Model& model) : residual(model), correction(model) {}
};

template <class S>
Formulation<S>::Formulation(const Model& model) : model_(model) {
  if (model.has_singular_inertia()) refinement_ = std::make_unique<Refinement>(model);
}

template <class S>
Formulation<S>::~Formulation() = default;

namespace {

template <class S>
bool finite(const Vec3<S>& a) {
  return std::isfinite(to_double(a.x)) && std::isfinite(to_double(a.y)) && std::isfinite(to_double(a.z));
}

template <class S>
bool finite(const Solution<S>& solution) {
  return std::all_of(solution.vdot.begin(), solution.vdot.end(),
                     [](const S& x) { return std::isfinite(to_double(x)); }) &&
         std::all_of(solution.acceleration.begin(), solution.acceleration.end(),
                     [](const Motion<S>& a) { return finite(a.angular) && finite(a.linear); }) &&
         std::all_of(solution.wrench.begin(), solution.wrench.end(),
                     [](const Wrench<S>& f) { return finite(f.moment) && finite(f.force); });
}

template <class S>
bool finite(const System<S>& system) {
  for (const auto& body : system.bodies)
    if (!finite(body.r) || !finite(body.inertia.h)) return false;
  for (const auto& bias : system.rhs.bias)
    if (!finite(bias.angular) || !finite(bias.linear)) return false;
  for (const auto& force : system.rhs.force)
    if (!finite(force.moment) || !finite(force.force)) return false;
  return std::all_of(system.rhs.tau.begin(), system.rhs.tau.end(),
                     [](const S& x) { return std::isfinite(to_double(x)); });
}

/// The place of a body on the ground enters no equation: the answer may be finite where the state is not.
template <class S>
bool roots_finite(const System<S>& system) {
  for (int i = 0; i < system.model.bodies(); ++i)
    if (system.model.link(i).parent == ground && !finite(system.bodies[i].r)) return false;
  return true;
}

/// The largest entry of each kind of quantity in a solution; the kinds differ in unit.
struct Sizes {
  double vdot = 0, angular = 0, linear = 0, moment = 0, force = 0;

  template <class S>
  explicit Sizes(const Solution<S>& solution) {
    const auto grow = [](double& largest, const S& x) {
      const double size = std::abs(to_double(x));
      if (!(size <= largest)) largest = size;  // a NaN enters and stays
    };
    const auto grow3 = [&](double& largest, const Vec3<S>& a) {
      grow(largest, a.x), grow(largest, a.y), grow(largest, a.z);
    };
    for (const S& x : solution.vdot) grow(vdot, x);
    for (const Motion<S>& a : solution.acceleration) grow3(angular, a.angular), grow3(linear, a.linear);
    for (const Wrench<S>& f : solution.wrench) grow3(moment, f.moment), grow3(force, f.force);
  }
};

/// Largest relative size over the kinds; infinite when one has a correction and no value, or is not a number.
template <class S>
double relative_size(const Solution<S>& correction, const Solution<S>& solution) {
  const Sizes change(correction), size(solution);
  const auto ratio = [](double c, double s) {
    const double r = c == 0 ? 0 : c / s;
    return std::isnan(r) ? std::numeric_limits<double>::infinity() : r;
  };
  return std::max({ratio(change.vdot, size.vdot), ratio(change.angular, size.angular),
                   ratio(change.linear, size.linear), ratio(change.moment, size.moment),
                   ratio(change.force, size.force)});
}

/// Refinement must bring its correction below √ε of the answer within a few steps: then the answer has half of its
/// digits at least. Where it stagnates above, the size of the correction is the error that remains.
constexpr double largest_correction = 1e-8;
constexpr int most_refinements = 3;

}  // namespace

template <class S>
Outcome Formulation<S>::solve(const System<S>& system, Solution<S>& solution) {
  assemble(system);
  Outcome outcome = factorise(system);
  if (outcome.usable()) {
    substitute(system, system.rhs, solution);
    drive_forces(system, solution);
    if (!finite(solution) || !roots_finite(system))
      outcome = {Status::singular,
                 "the answer is not finite: a pivot vanished, so the mass matrix is singular at this state"};
  }
  if (outcome.usable() && model_.has_singular_inertia()) {
    int steps = 0;
    do outcome.forward_error = refine(system, solution);
    while (!(outcome.forward_error < largest_correction) && ++steps < most_refinements);
    if (!(outcome.forward_error < largest_correction))
      outcome = {
          Status::singular,
          fmt::format("the mass matrix is singular to working precision (refinement changes the answer by {:.1e} of "
                      "itself); body '{}' or one it carries has too little inertia for its freedoms",
                      outcome.forward_error, model_.spec().bodies[model_.singular_inertia_body()].name),
          outcome.forward_error};
  }
  if (!outcome.usable() && !finite(system))
    outcome = {Status::not_finite,
               "the coefficients of eq. 14 are not finite; look at the state, the loads and the motions"};
  return outcome;
}

template <class S>
double Formulation<S>::refine(const System<S>& system, Solution<S>& solution) {
  if (!refinement_) refinement_ = std::make_unique<Refinement>(model_);
  Solution<S>& correction = refinement_->correction;
  residual(system, system.rhs, solution, refinement_->residual);
  substitute(system, refinement_->residual, correction);
  const double change = relative_size(correction, solution);
  for (int k = 0; k < model_.nv(); ++k) solution.vdot[k] += correction.vdot[k];
  for (int i = 0; i < model_.bodies(); ++i) {
    solution.acceleration[i] += correction.acceleration[i];
    solution.wrench[i] += correction.wrench[i];
  }
  drive_forces(system, solution);
  return change;
}

template class Formulation<double>;
template class Formulation<long double>;
template class Formulation<Count>;

}  // namespace lanc
