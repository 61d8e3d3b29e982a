// What does accuracy cost: error against processor time, over tolerances and steps.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "lib/model/error.h"
#include "lib/report/comparison.h"
#include "lib/report/experiment.h"

namespace {

using namespace lanc;

struct Options {
  std::string problems, integrators = "*", stabilisations = "*";
};

std::vector<ReferenceProblem> chosen_problems(const Options& options, bool quick) {
  // one of each kind: a tree, redundant and singular loops, a stiff tree, fast and slow loops, a driven one
  static const std::vector<std::string> standard = {"a01",     "a02-2",    "a04",         "a05",
                                                    "andrews", "car-axis", "slider-crank"};
  std::vector<ReferenceProblem> list;
  for (ReferenceProblem& problem : read_reference_problems(LANC_DATA_DIR)) {
    if (problem.model.empty() || problem.end == 0) continue;
    const std::string name = problem.short_name();
    const auto matches = [&](const std::string& glob) { return matching({name}, glob) == std::vector{name}; };
    const bool asked = !options.problems.empty() ? matches(options.problems)
                       : quick                   ? name == "slider-crank"
                                                 : std::find(standard.begin(), standard.end(), name) != standard.end();
    if (asked) list.push_back(std::move(problem));
  }
  if (list.empty()) throw InputError(fmt::format("--problems '{}' matches nothing", options.problems));
  return list;
}

void measure(Experiment& e, const ReferenceProblem& problem, const Mechanism& m, const Way& way, int level,
             bool& worth) {
  // levels 1e-3 .. 1e-12; fixed steps from a hundred on, doubled each time
  const double tolerance = std::pow(10.0, -3 - level), step = problem.end / (100 * std::pow(2.0, level));
  const Cell cell = e.cell(problem.short_name(), m.model, std::string(way.formulation->name),
                           fmt::format("{}", way.parameters(tolerance, step)));
  if (e.report().has(cell) || !worth) return;
  std::vector<double> times;
  Comparison c;
  for (int r = 0; r < e.options().repetitions && c.seconds < 2; ++r) {
    c = compare(problem, m, way.options(tolerance, step));
    times.push_back(c.seconds);
  }
  std::sort(times.begin(), times.end());
  const std::string status(to_string(c.outcome.status));
  const double nothing = std::numeric_limits<double>::quiet_NaN();
  const Measurement list[] = {
      {"total", "error", c.outcome.usable() ? c.error : nothing, "1", status},
      {"total", "worst_error", c.outcome.usable() ? c.worst : nothing, "tolerances", status},
      {"total", "energy_drift", c.outcome.usable() ? c.energy_drift : nothing, "of the energy", status},
      {"total", "time", times[times.size() / 2], "s", status},
      {"total", "steps", static_cast<double>(c.steps.steps), "1", status},
      {"total", "evaluations", static_cast<double>(c.evaluations.rates), "1", status}};
  e.report().write(cell, list);
  constexpr double long_enough = 60;  // s: finer ones would take longer still
  worth = c.seconds < long_enough;
}

void run(Experiment& e, const Options& options) {
  const int levels = e.options().quick ? 4 : 10;
  for (const ReferenceProblem& problem : chosen_problems(options, e.options().quick)) {
    const Mechanism m = load_mechanism(problem.model);
    const auto pairs = pairs_of(options.integrators, options.stabilisations, m.model.has_closures());
    e.progress().start(static_cast<std::int64_t>(pairs.size() * e.formulations().size() * levels));
    for (const FormulationInfo* f : e.formulations()) {
      if (!f->create_double || f->objection(m.model)) continue;
      for (const auto& [integrator, stabilisation] : pairs) {
        bool worth = true;
        for (int level = 0; level < levels; ++level) {
          measure(e, problem, m, {f, integrator, stabilisation}, level, worth);
          e.progress().advance(1, fmt::format("{} {} {}", problem.short_name(), integrator, stabilisation));
        }
      }
    }
  }
  e.progress().clear();
}

}  // namespace

int main(int argc, char** argv) {
  Experiment experiment(
      {.name = "work-precision",
       .question = "What does accuracy cost: error against processor time, over tolerances and steps?",
       .repetitions = 3,
       .quick_repetitions = 1,
       .models = [](bool) { return std::vector<std::string>(); },
       .formulations = [](const FormulationInfo& info) { return &info == default_formulation(); }});
  Options options;
  experiment.option("--problems", options.problems,
                    "glob over the names of the files in data/reference (default: seven)");
  experiment.option("--integrators", options.integrators, "glob");
  experiment.option("--stabilisations", options.stabilisations, "glob");
  return experiment.run(argc, argv, [&](Experiment& e) { run(e, options); });
}
