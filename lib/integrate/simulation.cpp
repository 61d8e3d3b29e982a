#include "lib/integrate/simulation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "lib/integrate/branch_choice.h"
#include "lib/integrate/full_coordinates.h"
#include "lib/integrate/minimal_coordinates.h"
#include "lib/integrate/residual_form.h"
#include "lib/system/equations.h"

namespace lanc {

double baumgarte_rule(const Model& model, const SimulationOptions& options, bool fixed_step) {
  if (options.baumgarte_time > 0) return options.baumgarte_time;
  if (fixed_step) return 10 * options.step;
  const double g = std::sqrt(dot(model.gravity(), model.gravity()));
  return std::sqrt(model.length() / (g > 0 ? g : 9.81)) / 20;
}

std::optional<std::string> objection(const IntegratorInfo& integrator, Stabilisation stabilisation) {
  if (integrator.holds_closures && stabilisation != Stabilisation::none)
    return "this integrator holds the closure conditions itself; choose 'none'";
  if (integrator.memory && stabilisation == Stabilisation::projection)
    return "a projection after each step is no solution of the equations the earlier steps belong to; choose a "
           "Runge-Kutta method, or another stabilisation";
  if (integrator.implicit && stabilisation == Stabilisation::minimal)
    return "the derivatives of minimal coordinates are not offered; choose an explicit integrator, or projection";
  return std::nullopt;
}

struct Simulation::Parts {
  Model model;
  SimulationOptions options;
  const FormulationInfo* formulation;
  const IntegratorInfo* integrator;
  Stabilisation stabilisation;
  std::unique_ptr<MotionSolver> solver;
  std::unique_ptr<MotionForm> form;
  std::unique_ptr<Stepper> stepper;
  double start_energy = 0;
  std::vector<PassedStep> passed;  // the last three
  std::vector<BranchChange> branch_changes;
  int tiny_steps = 0;          // one after another
  StepperCounts steps_before;  // of earlier parts of this run
  MotionCounts evaluations_before;

  Parts(const Model& m, SimulationOptions o) : model(m), options(std::move(o)) {
    formulation = find_formulation(options.formulation);
    if (!formulation) {
      std::string names;
      for (const FormulationInfo& info : formulations())
        names += fmt::format("{}{}", names.empty() ? "" : ", ", info.name);
      throw InputError(fmt::format("there is no formulation '{}'; choose from {}", options.formulation, names));
    }
    integrator = &find_integrator(options.integrator);
    stabilisation = find_stabilisation(options.stabilisation);
    if (!model.has_closures()) stabilisation = Stabilisation::none;
    check();
    solver = std::make_unique<MotionSolver>(model, *formulation, options.loads);
  }

  void check() const {
    if (const auto why = objection(*integrator, stabilisation))
      throw InputError(fmt::format("integrator '{}' and stabilisation '{}' do not go together: {}", integrator->name,
                                   to_string(stabilisation), *why));
  }

  void build(const MotionPoint& point, const std::vector<int>& independent, double first_step) {
    const double alpha = 1 / baumgarte_rule(model, options, integrator->fixed_step);
    if (integrator->holds_closures)
      form = std::make_unique<ResidualForm>(*solver);
    else if (stabilisation == Stabilisation::minimal)
      form = std::make_unique<MinimalCoordinates>(*solver, point.state, independent, options.candidates);
    else
      form = std::make_unique<FullCoordinates>(*solver, stabilisation, alpha);
    stepper = integrator->create(*form, {.tolerance = options.tolerance,
                                         .step = options.step,
                                         .spectral_radius = options.spectral_radius,
                                         .first_step = first_step});
    std::vector<double> y(form->size());
    form->pack(point, y.data());
    stepper->start(point.state.t, y);
  }

  Energy<double> energy_at(const State<double>& state) {
    Evaluator<double> evaluator(model);
    return energy(evaluator, state);
  }
};

Simulation::Simulation(const Model& model, SimulationOptions options)
    : parts_(std::make_unique<Parts>(model, std::move(options))) {}
Simulation::~Simulation() = default;

Outcome Simulation::begin(const State<double>& start) {
  Parts& s = *parts_;
  Outcome outcome = s.solver->hold(start, s.options.singular != SingularPolicy::stop);
  if (!outcome.usable()) return outcome;
  s.start_energy = s.energy_at(start).total();
  s.passed.clear();
  s.build({start, 0}, {}, 0);
  return outcome;
}

Outcome Simulation::resume(const Checkpoint& checkpoint) {
  Parts& s = *parts_;
  s.solver = std::make_unique<MotionSolver>(s.model, *s.formulation, s.options.loads);
  RankPolicy policy{checkpoint.rank};
  if (s.options.singular != SingularPolicy::stop) policy.smallest = passing_singular_value;
  s.solver->hold(policy);
  s.start_energy = checkpoint.start_energy;
  s.steps_before = checkpoint.steps;
  s.evaluations_before = checkpoint.evaluations;
  s.passed = checkpoint.passed;
  s.build(checkpoint.point, checkpoint.independent, checkpoint.next_step);
  return {};
}

Checkpoint Simulation::renew() {
  Parts& s = *parts_;
  Checkpoint checkpoint{
      point(), s.stepper->next_step(), s.start_energy, s.solver->policy().rank, s.form->independent(), s.passed,
      steps(), evaluations()};
  (void)resume(checkpoint);
  return checkpoint;
}

namespace {

/// The smallest σ_r that a motion comes to between two instants, and where: golden section, the way there by small
/// steps.
PassedStep weakest(MotionSolver& solver, const MotionPoint& from, double end) {
  PassedStep result{from, std::numeric_limits<double>::max()};
  const auto sigma = [&](double t) {
    FullCoordinates form(solver, Stabilisation::projection, 0);
    const std::unique_ptr<Stepper> stepper =
        find_integrator("rk4").create(form, {.step = std::max((t - from.state.t) / 4, 1e-300)});
    std::vector<double> y(form.size());
    form.pack(from, y.data());
    stepper->start(from.state.t, y);
    while (stepper->t() < t)
      if (!stepper->step(t)) break;  // too near to be evaluated
    const MotionPoint point = form.unpack(t, stepper->y().data());
    const bool there = stepper->t() >= t;
    if (there) (void)solver.solve(point.state);
    const double found = there ? solver.sigma() : 0.0;
    if (found < result.sigma) result = {point, found};
    return found;
  };
  const double ratio = (std::sqrt(5.0) - 1) / 2;
  double a = from.state.t, b = end, c = b - ratio * (b - a), d = a + ratio * (b - a), fc = sigma(c), fd = sigma(d);
  for (int k = 0; k < 45 && fc > 0 && fd > 0; ++k)
    if (fc < fd)
      b = d, d = c, fd = fc, c = b - ratio * (b - a), fc = sigma(c);
    else
      a = c, c = d, fc = fd, d = a + ratio * (b - a), fd = sigma(d);
  return result;
}

}  // namespace

/// Steps pass over the instant at which the rank drops; σ_r before and behind tells.
Outcome Simulation::watch_rank() {
  Parts& s = *parts_;
  if (!s.model.has_closures() || s.options.singular == SingularPolicy::pass) return {};
  const MotionPoint here = point();
  if (s.integrator->holds_closures) (void)s.solver->solve(here.state);
  s.passed.push_back({here, s.solver->sigma()});
  if (s.passed.size() > 3) s.passed.erase(s.passed.begin());
  if (s.passed.size() < 3) return {};
  const double before = s.passed[0].sigma, middle = s.passed[1].sigma, behind = s.passed[2].sigma;
  // a dip that may reach zero between the steps, as |t − t*| does
  if (!(middle <= before && middle <= behind && middle < before - middle + behind - middle)) return {};
  const PassedStep least = weakest(*s.solver, s.passed[0].point, here.state.t);
  constexpr double zero = 1e-6;
  if (least.sigma > zero) return {};
  const bool choose = s.options.singular == SingularPolicy::branch;
  if (choose && take_branch(least.point)) return {};
  Outcome outcome;
  outcome.status = Status::singular;
  outcome.rank = s.solver->policy().rank;
  outcome.message = fmt::format(
      "singular configuration at t = {:.9g} s: the rank of the closure conditions drops below {} for a moment, and "
      "which way the motion goes on is not determined by them; {}",
      least.point.state.t, outcome.rank,
      choose ? "there is no such branch, or the mechanism has more freedoms than one"
             : "the policy 'pass' goes on with the present velocities, 'branch' along a branch you name");
  return outcome;
}

bool Simulation::take_branch(const MotionPoint& crossing) {
  Parts& s = *parts_;
  const std::optional<BranchStart> start = choose_branch(*s.solver, crossing.state, s.options.branch);
  if (!start) return false;
  s.branch_changes.push_back({start->crossing, s.options.branch, start->branches, start->energy_change});
  s.steps_before = steps();
  s.passed.clear();
  s.build({start->state, crossing.work + start->energy_change}, {}, 0);
  return true;
}

Outcome Simulation::step(double limit) {
  Parts& s = *parts_;
  const double before = s.stepper->t();
  if (s.stepper->step(limit)) {
    constexpr double shortest = 1e-12;
    constexpr int most = 100;
    const bool tiny = !s.integrator->fixed_step &&
                      s.stepper->t() - before < shortest * std::max(1.0, std::abs(before)) && s.stepper->t() < limit;
    s.tiny_steps = tiny ? s.tiny_steps + 1 : 0;
    if (s.tiny_steps < most) return watch_rank();
    return {
        Status::not_converged,
        fmt::format("t = {:.9g} s: the error estimate asks for ever shorter steps; the motion ends here (a singular "
                    "configuration, an impact), or the tolerance is below what rounding allows",
                    s.stepper->t())};
  }
  Outcome outcome = s.form->outcome();
  if (outcome.usable()) outcome = {Status::not_converged, s.stepper->message()};
  outcome.message = fmt::format("t = {:.9g} s: {}", s.stepper->t(), outcome.message);
  return outcome;
}

bool Simulation::begun() const { return parts_->stepper != nullptr; }
double Simulation::t() const { return parts_->stepper->t(); }
MotionPoint Simulation::point() const { return parts_->form->unpack(t(), parts_->stepper->y().data()); }
double Simulation::next_step() const { return parts_->stepper->next_step(); }
int Simulation::held_rank() const { return parts_->solver->policy().rank; }
std::span<const IndependentChange> Simulation::changes() const { return parts_->form->changes(); }

std::span<const BranchChange> Simulation::branch_changes() const { return parts_->branch_changes; }

StepperCounts Simulation::steps() const {
  StepperCounts counts = parts_->stepper->counts();
  const StepperCounts& before = parts_->steps_before;
  counts.steps += before.steps, counts.rejected += before.rejected;
  counts.newton_iterations += before.newton_iterations;
  return counts;
}

MotionCounts Simulation::evaluations() const {
  MotionCounts counts = parts_->solver->counts();
  const MotionCounts& before = parts_->evaluations_before;
  counts.rates += before.rates, counts.jacobians += before.jacobians;
  counts.kinematics += before.kinematics, counts.dual_kinematics += before.dual_kinematics;
  return counts;
}

Instant Simulation::instant() {
  Parts& s = *parts_;
  Instant now;
  const MotionCounts before = s.solver->counts();  // looking on is no part of the integration
  now.point = point();
  now.outcome = s.solver->solve(now.point.state);
  now.solution = s.solver->solution();
  now.position_violation = s.solver->position_violation();
  now.velocity_violation = s.solver->velocity_violation();
  if (s.model.has_closures()) {
    std::vector<double> open(s.model.closures().rows());
    closure_accelerations(s.solver->system(), s.solver->system().rhs, now.solution, open);
    const ClosureScaling scaling(s.model);
    for (std::size_t k = 0; k < open.size(); ++k)
      now.acceleration_violation = std::max(now.acceleration_violation, std::abs(open[k]) * scaling.row[k]);
  }
  now.energy = s.energy_at(now.point.state);
  now.energy_drift = now.energy.total() - s.start_energy - now.point.work;
  now.choice_condition = s.form->condition();
  s.solver->counts() = before;
  return now;
}

}  // namespace lanc
