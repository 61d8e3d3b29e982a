#include "lib/formulation/formulation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "lib/formulation/judgement.h"
#include "lib/system/equations.h"
#include "lib/system/finite.h"
#include "lib/system/mass_matrix.h"

namespace lanc {

template <class S>
struct Formulation<S>::Refinement {
  RightHandSide<S> residual;
  Solution<S> correction, probe;
  explicit Refinement(const Model& model) : residual(model), correction(model), probe(model) {}
};

template <class S>
Formulation<S>::Formulation(const Model& model) : model_(model) {
  if (model.has_closures()) rank_ = std::make_unique<ClosureRank<S>>(model), consistent_ = RightHandSide<S>(model);
  if (model.has_singular_inertia() || model.has_closures()) refinement_ = std::make_unique<Refinement>(model);
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

template <class S>
Outcome not_finite(const System<S>& system) {
  return {Status::not_finite, "coefficients of eq. 14 cannot be used: " + not_finite_because(system)};
}

/// Not singular, though a Cholesky factorisation says so: the rule for inertias that are allowed to be nonphysical.
template <class S>
bool indefinite_by_inertia(const System<S>& system) {
  const Model& model = system.model;
  constexpr int most = 3000;  // velocities: above, seconds
  const auto& bodies = model.spec().bodies;
  return model.nv() <= most &&
         std::any_of(bodies.begin(), bodies.end(), [](const BodySpec& b) { return b.allow_nonphysical_inertia; }) &&
         regular_but_indefinite(system);
}

Outcome not_definite() {
  return {
      Status::objection,
      "the mass matrix is not positive definite at this state, since a body has an inertia that no body can have; "
      "the equations have an answer, but this formulation needs pivots of one sign. 'recursive' and the formulations "
      "on eq. 14 do not"};
}

}  // namespace

template <class S>
void Formulation<S>::decide(const System<S>& system, RankPolicy policy) {
  if (!rank_) return;
  const bool held = !policy.automatic() && policy.smallest == 0;  // weak conditions are told by singular values only
  if (policy.by_pivots && held && dropped_rows() >= 0)
    rank_->hold(system, policy);
  else
    rank_->decide(system, policy);
}

template <class S>
Outcome Formulation<S>::factorised(const System<S>& system, RankPolicy policy) {
  decide(system, policy);
  assemble(system);
  Outcome outcome = factorise(system);
  if (!rank_ || !closures().by_pivots || (outcome.usable() && dropped_rows() == closures().redundant)) return outcome;
  policy.by_pivots = false;
  return factorised(system, policy);
}

template <class S>
Outcome Formulation<S>::solve(const System<S>& system, Solution<S>& solution, RankPolicy policy) {
  if (rank_ && !finite(system)) return not_finite(system);
  Outcome outcome = factorised(system, policy);
  if (outcome.usable()) {
    const RightHandSide<S>& rhs = consistent(system);
    substitute(system, rhs, solution);
    settle_reactions(system, rhs, solution);
    drive_forces(system, solution);
    const double excess = judgement::first_look(system, solution);
    if (std::isnan(excess))
      outcome = {
          Status::singular,
          "the answer is not finite: a pivot vanished or has the wrong sign, so the mass matrix is singular or not "
          "positive definite at this state"};
    else if (excess > 0 || model_.has_singular_inertia() || rank_)
      outcome = verified(system, solution);
  }
  if (outcome.status == Status::singular && indefinite_by_inertia(system)) outcome = not_definite();
  if (rank_) judge_closures(outcome);
  if (!outcome.usable() && !finite(system)) return not_finite(system);
  return outcome;
}

template <class S>
Outcome Formulation<S>::prepare(const System<S>& system, RankPolicy policy) {
  if (!finite(system)) return not_finite(system);
  policy.by_pivots = false;  // respond() makes right-hand sides consistent by the singular vectors
  decide(system, policy);
  assemble(system);
  Outcome outcome = factorise(system);
  if (rank_) outcome.rank = closures().rank, outcome.redundant = closures().redundant, outcome.sigma = closures().sigma;
  return outcome;
}

template <class S>
void Formulation<S>::respond(const System<S>& system, RightHandSide<S>& rhs, Solution<S>& solution) {
  if (rank_) rank_->make_consistent(rhs.closure);
  substitute(system, rhs, solution);
  settle_reactions(system, rhs, solution);
}

template <class S>
const RightHandSide<S>& Formulation<S>::consistent(const System<S>& system) {
  if (!rank_ || closures().redundant == 0) return system.rhs;
  consistent_ = system.rhs;
  for (std::size_t k = 0; k < consistent_.closure.size(); ++k) consistent_.closure[k] += S(closures().correction[k]);
  return consistent_;
}

template <class S>
void Formulation<S>::settle_reactions(const System<S>& system, const RightHandSide<S>& rhs, Solution<S>& solution) {
  // where weak conditions were dropped, others' multipliers would not do quite the same in their place
  if (!rank_ || closures().redundant == 0 || closures().dropped || closures().by_pivots) return;
  rank_->minimum_norm(solution.lambda);
  wrenches(system, rhs, solution);
}

/// What the decision on the closure conditions says of the answer.
template <class S>
void Formulation<S>::judge_closures(Outcome& outcome) const {
  const ClosureDecision& decision = closures();
  outcome.rank = decision.rank, outcome.redundant = decision.redundant;
  outcome.sigma = decision.sigma, outcome.next_sigma = decision.next_sigma;
  const auto row = [&] {
    return decision.worst_row < 0 ? std::string("?") : model_.closures().row_names[decision.worst_row];
  };
  const auto say = [&](Status status, std::string message) {
    outcome.status = status, outcome.message = std::move(message);
    outcome.conditional = !outcome.usable();
  };
  if (!outcome.usable()) return;
  if (!decision.held && std::max(decision.position_violation, decision.velocity_violation) > largest_violation)
    say(Status::inconsistent,
        fmt::format("the state does not satisfy the closure conditions (positions by {:.1e}, velocities by {:.1e} in "
                    "units of the model's length; worst: '{}'); assemble it first",
                    decision.position_violation, decision.velocity_violation, row()));
  else if (decision.contradiction > decision.tolerated_contradiction)
    say(Status::inconsistent,
        fmt::format("the closure conditions contradict one another: {:.1e} of the accelerations they demand cannot be "
                    "balanced (worst: '{}'); least squares returned",
                    decision.contradiction, row()));
  else if (decision.varying_rank)
    say(Status::singular, fmt::format("singular configuration: the rank of the closure conditions, {} here, is larger "
                                      "in neighbouring states; the answer obeys the conditions at this very state only",
                                      decision.rank));
  else if (decision.near_singular)
    say(Status::singular,
        fmt::format("so near a singular configuration that the rank is not clear: singular values {:.1e} and {:.1e}",
                    decision.sigma, decision.next_sigma));
  else if (decision.redundant > 0)
    say(Status::redundant,
        fmt::format("{} of {} closure conditions are redundant; λ {}", decision.redundant, model_.closures().rows(),
                    decision.by_pivots ? "is one of many" : "has minimum norm"));
}

/// Refines the answer, and sees whether the factors bring back an answer that is known. The second is needed because a
/// singular system that happens to have solutions has no residual.
template <class S>
Outcome Formulation<S>::verified(const System<S>& system, Solution<S>& solution) {
  Outcome outcome;
  for (int step = 0; step < most_refinements && !(outcome.forward_error < largest_correction); ++step)
    outcome.forward_error = refine(system, solution);
  // off the manifold redundant conditions are left open by as much as they differ
  const double accepted = rank_ && closures().held ? closures().tolerated_contradiction : largest_correction;
  if (const double open = open_closures(system, solution); !(open < accepted)) {
    outcome.status = Status::not_converged;
    outcome.message = fmt::format("the answer violates the closure conditions by {:.1e} of its accelerations", open);
    return outcome;
  }
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

/// Largest acceleration with which a closure opens, relative to the accelerations of the answer.
template <class S>
double Formulation<S>::open_closures(const System<S>& system, const Solution<S>& solution) {
  if (!rank_) return 0;
  std::vector<S>& open = refinement_->residual.closure;
  closure_accelerations(system, consistent(system), solution, open);
  judgement::Sizes size(model_, solution);
  size.include_loads(system);
  const double largest = rank_->largest(open) * model_.length();
  return largest == 0 ? 0 : largest / size.acceleration;
}

template <class S>
double Formulation<S>::probe_error(const System<S>& system) {
  // Without loads and velocities eq. 14 is M̄ η̇ = τ: the τ of given accelerations, and back.
  Solution<S>& known = refinement_->probe;
  Solution<S>& found = refinement_->correction;
  RightHandSide<S>& rhs = refinement_->residual;
  rhs.set_zero();
  std::fill(known.lambda.begin(), known.lambda.end(), S(0.0));
  for (int k = 0; k < model_.nv(); ++k) {
    const double unit = model_.column_kind(k) == ColumnKind::translation ? 1 : 1 / model_.length();
    known.vdot[k] = S(unit * (k % 3 == 0 ? 1.0 : k % 3 == 1 ? -0.75 : 0.5));
  }
  newton_euler(system, rhs, known);
  for (int k = 0; k < model_.nv(); ++k) {
    rhs.tau[k] = project(model_.column_kind(k), system.columns[k], known.wrench[model_.body_of_velocity(k)]);
    if (model_.armature()[k] != 0) rhs.tau[k] += S(model_.armature()[k]) * known.vdot[k];
  }
  if (rank_) {  // conditions that the known accelerations satisfy without multipliers
    closure_accelerations(system, rhs, known, found.lambda);
    for (std::size_t k = 0; k < rhs.closure.size(); ++k) rhs.closure[k] = -found.lambda[k];
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
  residual(system, consistent(system), solution, refinement_->residual);
  substitute(system, refinement_->residual, correction);
  // before it is measured: what a formulation leaves in λ along redundant rows is no error
  settle_reactions(system, refinement_->residual, correction);
  judgement::Sizes size(model_, solution);
  size.include_loads(system);
  for (int k = 0; k < model_.nv(); ++k) solution.vdot[k] += correction.vdot[k];
  for (int i = 0; i < model_.bodies(); ++i) {
    solution.acceleration[i] += correction.acceleration[i];
    solution.wrench[i] += correction.wrench[i];
  }
  for (std::size_t k = 0; k < solution.lambda.size(); ++k) solution.lambda[k] += correction.lambda[k];
  drive_forces(system, solution);
  return judgement::relative(judgement::Sizes(model_, correction), size);
}

template class Formulation<double>;
template class Formulation<long double>;
template class Formulation<Count>;

}  // namespace lanc
