#include "lib/report/comparison.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>

#include "lib/integrate/linearise.h"
#include "lib/integrate/quantities.h"
#include "lib/model/error.h"
#include "lib/report/experiment.h"
#include "lib/report/timing.h"

namespace lanc {
namespace {

/// q.… or .x, .y, .z of a point.
bool is_position(const std::string& quantity) {
  const std::size_t n = quantity.size();
  return quantity.rfind("q.", 0) == 0 ||
         (n > 2 && quantity[n - 2] == '.' && quantity[n - 1] >= 'x' && quantity[n - 1] <= 'z');
}

void judge(const ReferenceValue& expected, double found, bool recomputed_there, Comparison& result) {
  const double error = std::abs(expected.factor * found - expected.value), ratio = error / expected.tolerance;
  ++result.values;
  if (!(ratio <= result.worst))
    result.worst = std::isnan(ratio) ? HUGE_VAL : ratio, result.worst_quantity = expected.quantity,
    result.worst_t = expected.t;
  if (is_position(expected.quantity) && (expected.origin == "recomputed" || !recomputed_there))
    result.error = std::max(result.error, error);
}

bool has_recomputed_positions(const ReferenceProblem& problem) {
  return std::any_of(problem.values.begin(), problem.values.end(),
                     [](const ReferenceValue& v) { return v.origin == "recomputed" && is_position(v.quantity); });
}

/// Values that are still to come at this time, from `next` on.
void judge_instant(const ReferenceProblem& problem, std::size_t& next, Simulation& simulation, Quantities& quantities,
                   double& energy, Comparison& result) {
  const Instant now = simulation.instant();
  result.outcome = now.outcome;
  if (!now.outcome.usable()) return;
  energy = std::max(energy, now.energy.kinetic + std::abs(now.energy.potential));
  result.energy_drift = std::max(result.energy_drift, std::abs(now.energy_drift));
  result.violation = std::max(result.violation, now.position_violation);
  const bool recomputed = has_recomputed_positions(problem);
  const std::vector<Quantity> list = quantities.at(now);
  for (; next < problem.values.size() && problem.values[next].t <= simulation.t(); ++next)
    judge(problem.values[next], value_of(list, problem.values[next].quantity), recomputed, result);
}

}  // namespace

Comparison compare(const ReferenceProblem& problem, const Mechanism& mechanism, const SimulationOptions& options) {
  Comparison result;
  QuantityChoice choice{.points = {}, .accelerations = true, .reactions = true, .multipliers = true, .bodies = true};
  for (const std::string& text : problem.points) choice.points.push_back(read_point(mechanism.model, text));
  Quantities quantities(mechanism.model, std::move(choice));
  const double begin = thread_seconds();
  double beside = 0, energy = 0;  // time for comparing
  Simulation simulation(mechanism.model, options);
  result.outcome = simulation.begin(mechanism.state);
  for (std::size_t next = 0; result.outcome.usable() && next < problem.values.size();) {
    const double t = problem.values[next].t;
    while (result.outcome.usable() && simulation.t() < t) result.outcome = simulation.step(t);
    if (!result.outcome.usable()) break;
    const double pause = thread_seconds();
    judge_instant(problem, next, simulation, quantities, energy, result);
    beside += thread_seconds() - pause;
  }
  result.seconds = thread_seconds() - begin - beside;
  if (energy > 0) result.energy_drift /= energy;
  if (simulation.begun()) {
    result.held_rank = simulation.held_rank();
    result.steps = simulation.steps(), result.evaluations = simulation.evaluations();
  }
  return result;
}

SimulationOptions Way::options(double tolerance, double step) const {
  SimulationOptions options;
  options.formulation = formulation->name;
  options.integrator = integrator, options.stabilisation = stabilisation;
  options.tolerance = tolerance, options.step = step;
  options.singular = SingularPolicy::pass;
  return options;
}

std::string Way::parameters(double tolerance, double step) const {
  return fmt::format(
      "integrator={};stabilisation={};{}", integrator, stabilisation,
      find_integrator(integrator).fixed_step ? fmt::format("step={}", step) : fmt::format("tolerance={}", tolerance));
}

std::vector<std::pair<std::string, std::string>> pairs_of(const std::string& integrator_glob,
                                                          const std::string& stabilisation_glob, bool closed_loops) {
  const auto chosen = [](const auto& list, const std::string& glob) {
    std::vector<std::string> names;
    for (const auto& info : list) names.emplace_back(info.name);
    return matching(names, glob);
  };
  std::vector<std::pair<std::string, std::string>> pairs;
  for (const std::string& integrator : chosen(integrators(), integrator_glob)) {
    const IntegratorInfo& info = find_integrator(integrator);
    if (!closed_loops || info.holds_closures) {
      pairs.emplace_back(integrator, to_string(Stabilisation::none));
      continue;
    }
    for (const std::string& stabilisation : chosen(stabilisations(), stabilisation_glob))
      if (!objection(info, find_stabilisation(stabilisation))) pairs.emplace_back(integrator, stabilisation);
  }
  return pairs;
}

Comparison compare_rest(const ReferenceProblem& problem, const Mechanism& mechanism) {
  Comparison result;
  const double begin = thread_seconds();
  State<double> state = mechanism.state;
  LinearisedMotion motion;
  result.outcome = equilibrium(mechanism.model, state, {.stable = true});
  const std::vector<std::string> positions = mechanism.model.position_names(),
                                 velocities = mechanism.model.velocity_names();
  // the coordinate that the problem speaks of
  std::vector<int> chosen;
  for (const ReferenceValue& v : problem.values)
    for (std::size_t k = 0; k < positions.size() && chosen.empty(); ++k)
      if (v.quantity == "equilibrium." + positions[k])
        for (int c = 0; c < mechanism.model.nv(); ++c) {
          const Link& link = mechanism.model.link(mechanism.model.body_of_velocity(c));
          if (link.q <= static_cast<int>(k) && static_cast<int>(k) < link.q + link.nq) chosen = {c};
        }
  if (result.outcome.usable()) result.outcome = linearise(mechanism.model, state, chosen, motion);
  if (!result.outcome.usable()) return result;
  std::vector<Quantity> list;
  for (std::size_t k = 0; k < positions.size(); ++k) list.push_back({"equilibrium." + positions[k], state.q[k], ""});
  list.push_back({"mass", motion.M.at(0), ""});
  list.push_back({"damping", motion.C.at(0), ""});
  list.push_back({"stiffness", motion.K.at(0), ""});
  list.push_back({"frequency", std::sqrt(motion.K[0] / motion.M[0]), ""});
  for (std::size_t k = 0; k < motion.eigenvalues.size(); ++k) {
    list.push_back({"eigenvalue." + std::to_string(k + 1) + ".re", motion.eigenvalues[k].real(), ""});
    list.push_back({"eigenvalue." + std::to_string(k + 1) + ".im", motion.eigenvalues[k].imag(), ""});
  }
  for (const ReferenceValue& v : problem.values) judge(v, value_of(list, v.quantity), true, result);
  result.seconds = thread_seconds() - begin;
  return result;
}

}  // namespace lanc
