// How far do closure conditions and energy drift, by stabilisation, over a long motion?
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "lib/report/comparison.h"
#include "lib/report/experiment.h"
#include "lib/report/table.h"

namespace {

using namespace lanc;

struct Options {
  std::string integrators = "rk4", stabilisations = "*";
  double end = 100, step = 5e-3, tolerance = 1e-6, baumgarte_time = 0;
};

struct Largest {
  double position = 0, velocity = 0, energy = 0;
};

/// Rows at 1, 2, 3, … hundredths of the run.
Outcome follow(Experiment& e, const std::string& name, const Mechanism& m, const Way& way, const Options& options,
               Largest& largest) {
  SimulationOptions simulation_options = way.options(options.tolerance, options.step);
  simulation_options.baumgarte_time = options.baumgarte_time;
  Simulation simulation(m.model, simulation_options);
  Outcome outcome = simulation.begin(m.state);
  constexpr int rows = 200;
  double energy = 0;
  for (int row = 0; row <= rows && outcome.usable(); ++row) {
    const double t = m.state.t + options.end * row / rows;
    while (outcome.usable() && simulation.t() < t) outcome = simulation.step(t);
    if (!outcome.usable()) break;
    const Instant now = simulation.instant();
    outcome = now.outcome;
    if (row == 0) energy = std::max(1e-300, now.energy.kinetic + std::abs(now.energy.potential));
    const std::string status(to_string(outcome.status));
    const Measurement list[] = {{"total", "violation.position", now.position_violation, "1", status},
                                {"total", "violation.velocity", now.velocity_violation, "1/s", status},
                                {"total", "violation.acceleration", now.acceleration_violation, "1/s^2", status},
                                {"total", "energy_drift", now.energy_drift / energy, "of the energy", status}};
    largest.position = std::max(largest.position, now.position_violation);
    largest.velocity = std::max(largest.velocity, now.velocity_violation);
    largest.energy = std::max(largest.energy, std::abs(now.energy_drift) / energy);
    const Cell cell = e.cell(name, m.model, std::string(way.formulation->name),
                             fmt::format("t={};{}", t, way.parameters(options.tolerance, options.step)));
    if (!e.report().has(cell)) e.report().write(cell, list);
  }
  return outcome;
}

void run(Experiment& e, const Options& options) {
  TextTable table(
      {"model", "formulation", "integrator", "stabilisation", "status", "violation", "of velocities", "energy drift"},
      5);
  for (const std::string& name : e.models()) {
    const Mechanism m = e.load(name);
    for (const FormulationInfo* f : e.formulations()) {
      if (!f->create_double || f->objection(m.model)) continue;
      for (const auto& [integrator, stabilisation] :
           pairs_of(options.integrators, options.stabilisations, m.model.has_closures())) {
        const Way way{f, integrator, stabilisation};
        e.progress().say(fmt::format("{} {} {} {}", name, f->name, integrator, stabilisation));
        Largest largest;
        const Outcome outcome = follow(e, name, m, way, options, largest);
        table.row({name, std::string(f->name), integrator, stabilisation, std::string(to_string(outcome.status)),
                   fmt::format("{:.2g}", largest.position), fmt::format("{:.2g}", largest.velocity),
                   fmt::format("{:.2g}", largest.energy)});
      }
    }
  }
  e.progress().clear();
  fmt::print(e.options().out == "-" ? stderr : stdout, "\n{}", table.text());
}

}  // namespace

int main(int argc, char** argv) {
  Experiment experiment(
      {.name = "drift",
       .question = "How far do closure conditions and energy drift, by stabilisation, over a long motion?",
       .models =
           [](bool quick) {
             std::vector<std::string> models = {"four-bar-ladder:2:angle=2.4:rate=0"};
             if (!quick) models.push_back(LANC_DATA_DIR "/models/linkages/bricard.toml");
             return models;
           },
       .formulations = [](const FormulationInfo& info) { return &info == default_formulation(); }});
  Options options;
  experiment.option("--integrators", options.integrators, "glob");
  experiment.option("--stabilisations", options.stabilisations, "glob");
  experiment.option("--end", options.end, {1e-12, 1e12}, "s");
  experiment.option("--step", options.step, {1e-12, 1e12}, "of integrators with fixed steps, s");
  experiment.option("--tolerance", options.tolerance, {1e-16, 1}, "of integrators that choose their steps");
  experiment.option("--baumgarte-time", options.baumgarte_time, {0, 1e12}, "1/alpha, s; 0: the rule of simulate");
  return experiment.run(argc, argv, [&](Experiment& e) {
    if (e.options().quick) options.end = std::min(options.end, 20.0);
    run(e, options);
  });
}
