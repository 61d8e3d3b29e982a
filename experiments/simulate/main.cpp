// The motion of a mechanism from a state on, by any formulation, integrator and stabilisation: a trajectory as CSV.
#include <fmt/format.h>

#include <algorithm>

#include "experiments/simulate/run.h"
#include "lib/model/error.h"

namespace {

using namespace lanc;

void read_singular_policy(const std::string& text, SimulationOptions& options) {
  if (text == "stop") {
    options.singular = SingularPolicy::stop;
  } else if (text == "pass") {
    options.singular = SingularPolicy::pass;
  } else if (text.size() == 8 && text.rfind("branch:", 0) == 0 && text[7] >= '1' && text[7] <= '9') {
    options.singular = SingularPolicy::branch;
    options.branch = text[7] - '0';
  } else {
    throw InputError(fmt::format("--singular '{}': choose stop, pass, or branch:1 to branch:9", text));
  }
}

template <class List>
std::string names_of(const List& list) {
  std::string text;
  for (const auto& info : list) text += fmt::format("{}{}", text.empty() ? "" : ", ", info.name);
  return text;
}

}  // namespace

int main(int argc, char** argv) {
  const FormulationInfo* const preset = default_formulation();
  RunOptions options;
  SimulationOptions& simulation = options.simulation;
  simulation.formulation = preset ? preset->name : "";
  simulation.integrator = integrators().front().name;
  for (const IntegratorInfo& info : integrators())
    if (info.name == "erk8") simulation.integrator = info.name;
  const std::string preset_stabilisation(to_string(Stabilisation::projection));
  simulation.stabilisation = preset_stabilisation;
  std::string singular = "stop";
  std::vector<std::string> points, independent;

  StateProgram program("simulate",
                       "The motion of a mechanism: coordinates, points, energy and its balance, closure conditions and "
                       "their rank, as CSV.\nExit code 0 when the run came to its end, 1 when a status ended it (the "
                       "state is then in FILE.state.json), 2 for bad input.",
                       true, true);
  program.option("--formulation", simulation.formulation, "see --list-formulations");
  program.option("--integrator", simulation.integrator, names_of(integrators()));
  program.option("--stabilisation", simulation.stabilisation,
                 "of closed loops: " + names_of(stabilisations()) +
                     "; trees need none. adams and bdf take baumgarte, ida and generalized-alpha none, for the preset");
  program.option("--end", options.end, {-1e12, 1e12}, "time at which to end, s");
  program.option("--interval", options.interval, {1e-12, 1e12}, "time between rows of output, s");
  program.option("--tolerance", simulation.tolerance, {1e-16, 1}, "of the error estimate, relative and absolute");
  program.option("--step", simulation.step, {1e-12, 1e12},
                 "of integrators with fixed steps, s; the interval is divided");
  program.option("--spectral-radius", simulation.spectral_radius, {0, 1},
                 "at infinite frequency, of generalized-alpha");
  program.option("--baumgarte-time", simulation.baumgarte_time, {0, 1e12},
                 "1/alpha, s; 0: ten fixed steps, or a twentieth of sqrt(length/gravity)");
  program.option(
      "--singular", singular,
      "where the rank drops: stop, pass, or branch:K, the K-th of the branches that cross, the straightest first");
  program.list("--independent", independent, "velocity that may be independent (minimal); repeatable; default: all");
  program.list("--point", points,
               "NAME=BODY:x,y,z: a point to be traced, body axes, from the reference point; repeatable");
  program.flag("--accelerations", options.quantities.accelerations, "also accelerations of coordinates and points");
  program.flag("--bodies", options.quantities.bodies, "also angular velocities of bodies");
  program.flag("--reactions", options.quantities.reactions, "also wrenches of joints, and forces of drives");
  program.flag("--multipliers", options.quantities.multipliers, "also multipliers of closure conditions");
  program.list("--stop-when", options.stop_when,
               "'QUANTITY<VALUE' or 'QUANTITY>VALUE', by a metric's name; repeatable");
  program.option("--checkpoint-every", options.checkpoint_every, {1, 1e9}, "rows of output between two checkpoints");
  program.flag("--resume", options.resume, "go on from the last checkpoint of an interrupted run");
  program.flag("--quiet", options.quiet, "no progress on stderr");
  return program.run(argc, argv, [&](const StateInput& input) {
    read_singular_policy(singular, simulation);
    if (options.end <= input.state.t)
      throw InputError(fmt::format("--end {} is not after the start, t = {}", options.end, input.state.t));
    const IntegratorInfo& integrator = find_integrator(simulation.integrator);
    // so that every row is at the end of a step
    if (integrator.fixed_step)
      simulation.step = options.interval / std::ceil(options.interval / simulation.step - 1e-9);
    (void)find_stabilisation(simulation.stabilisation);
    // the preset where it does not go together; what was asked for is refused with the reason
    if (!input.model.has_closures() || (integrator.holds_closures && simulation.stabilisation == preset_stabilisation))
      simulation.stabilisation = to_string(Stabilisation::none);
    else if (integrator.memory && simulation.stabilisation == preset_stabilisation)
      simulation.stabilisation = to_string(Stabilisation::baumgarte);
    simulation.candidates = velocities_named(input.model, "--independent", independent);
    for (const std::string& text : points) {
      options.quantities.points.push_back(read_point(input.model, text));
      const auto& all = options.quantities.points;
      if (std::any_of(all.begin(), all.end() - 1, [&](const TracedPoint& p) { return p.name == all.back().name; }))
        throw InputError(fmt::format("--point: two points are called '{}'", all.back().name));
    }
    options.parameters =
        fmt::format("integrator={};stabilisation={};{}{}", simulation.integrator, simulation.stabilisation,
                    integrator.fixed_step ? fmt::format("step={}", simulation.step)
                                          : fmt::format("tolerance={}", simulation.tolerance),
                    singular == "stop" ? "" : ";singular=" + singular);
    return run(input, options);
  });
}
