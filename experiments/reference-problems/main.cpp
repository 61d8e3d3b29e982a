// Which published problems does each formulation, integrator and stabilisation solve, how exactly, and how fast?
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include "lib/model/error.h"
#include "lib/report/comparison.h"
#include "lib/report/experiment.h"
#include "lib/report/table.h"

namespace {

using namespace lanc;

struct Options {
  std::string problems = "*", integrators, stabilisations = "*";
  double tolerance = 1e-12, steps = 20000;
};

std::vector<ReferenceProblem> chosen_problems(const Options& options, bool quick) {
  static const std::vector<std::string> quick_ones = {"a01", "a02-2", "slider-crank", "four-bar-spring"};
  std::vector<ReferenceProblem> list;
  std::vector<std::string> names;
  for (ReferenceProblem& problem : read_reference_problems(LANC_DATA_DIR)) {
    if (problem.model.empty()) continue;
    const std::string name = problem.short_name();
    names.push_back(name);
    const bool asked = !matching({name}, options.problems).empty() && matching({name}, options.problems)[0] == name;
    const bool in_quick = std::find(quick_ones.begin(), quick_ones.end(), name) != quick_ones.end();
    if (asked && (!quick || options.problems != "*" || in_quick)) list.push_back(std::move(problem));
  }
  if (list.empty())
    throw InputError(
        fmt::format("--problems '{}' matches nothing; there are {}", options.problems, fmt::join(names, ", ")));
  return list;
}

/// With --integrators everything that goes together; without, each formulation with the best integrator there is and
/// minimal coordinates, which pass singular positions best, and the recursive formulation with each pair.
std::vector<Way> ways(const Experiment& e, const Options& options, const ReferenceProblem& problem,
                      const Model& model) {
  std::vector<Way> list;
  const auto add = [&](const FormulationInfo* f, const std::pair<std::string, std::string>& pair) {
    const Way way{f, pair.first, pair.second};
    const bool known = std::any_of(list.begin(), list.end(), [&](const Way& w) {
      return w.formulation == f && w.integrator == way.integrator && w.stabilisation == way.stabilisation;
    });
    if (!known && f->create_double) list.push_back(way);
  };
  if (problem.end == 0) return list;
  const bool loops = model.has_closures();
  const std::string stabilisation(loops ? options.stabilisations : "none");
  if (!options.integrators.empty()) {
    for (const FormulationInfo* f : e.formulations())
      for (const auto& pair : pairs_of(options.integrators, stabilisation, loops)) add(f, pair);
    return list;
  }
  const std::string best = pairs_of("erk8", "*", loops).empty() ? "rk4" : "erk8";
  const std::string standard(to_string(loops ? Stabilisation::minimal : Stabilisation::none));
  for (const FormulationInfo* f : e.formulations()) add(f, {best, standard});
  if (!e.options().quick)
    for (const FormulationInfo* f : e.formulations())
      if (f->recursive)
        for (const auto& pair : pairs_of("*", stabilisation, loops)) add(f, pair);
  return list;
}

std::vector<Measurement> measurements(const Comparison& c) {
  const std::string status(to_string(c.outcome.status));
  const auto m = [&](const char* metric, double value, const char* unit) {
    return Measurement{"total", metric, value, unit, status};
  };
  return {m("passed", c.passed() ? 1 : 0, "1"),
          m("worst_error", c.outcome.usable() ? c.worst : std::numeric_limits<double>::quiet_NaN(), "tolerances"),
          m("error", c.outcome.usable() ? c.error : std::numeric_limits<double>::quiet_NaN(), "1"),
          m("energy_drift", c.energy_drift, "of the energy"),
          m("violation", c.violation, "1"),
          m("values", c.values, "1"),
          m("rank", c.held_rank, "1"),
          m("time", c.seconds, "s"),
          m("steps", static_cast<double>(c.steps.steps), "1"),
          m("evaluations", static_cast<double>(c.evaluations.rates), "1"),
          m("kinematics", static_cast<double>(c.evaluations.kinematics), "1"),
          m("dual_kinematics", static_cast<double>(c.evaluations.dual_kinematics), "1"),
          m("jacobians", static_cast<double>(c.evaluations.jacobians), "1")};
}

std::vector<Measurement> refused(const std::string& status) {
  return {{"total", "passed", 0, "1", status},
          {"total", "worst_error", std::numeric_limits<double>::quiet_NaN(), "tolerances", status}};
}

void solve(Experiment& e, const Options& options, const ReferenceProblem& problem) {
  const Mechanism mechanism = load_mechanism(problem.model);
  const double step = problem.end / options.steps;
  const std::vector<Way> list = ways(e, options, problem, mechanism.model);
  e.progress().start(static_cast<std::int64_t>(list.size()));
  if (problem.end == 0) {
    const Cell cell = e.cell(problem.short_name(), mechanism.model, "", "rest");
    if (!e.report().has(cell)) e.report().write(cell, measurements(compare_rest(problem, mechanism)));
  }
  for (const Way& way : list) {
    const Cell cell = e.cell(problem.short_name(), mechanism.model, std::string(way.formulation->name),
                             way.parameters(options.tolerance, step));
    e.progress().advance(0, fmt::format("{} {} {}", problem.short_name(), way.formulation->name, way.integrator));
    if (!e.report().has(cell)) {
      if (const auto why = way.formulation->objection(mechanism.model)) {
        e.report().write(cell, refused(std::string(to_string(Status::objection))));
      } else {
        const Comparison c = compare(problem, mechanism, way.options(options.tolerance, step));
        if (!c.outcome.usable())
          e.progress().say(fmt::format("{} {} {} {}: {}: {}", problem.short_name(), way.formulation->name,
                                       way.integrator, way.stabilisation, to_string(c.outcome.status),
                                       c.outcome.message));
        else if (!c.passed())
          e.progress().say(fmt::format("{} {} {} {}: {} at t = {} misses by {:.3g} tolerances", problem.short_name(),
                                       way.formulation->name, way.integrator, way.stabilisation, c.worst_quantity,
                                       c.worst_t, c.worst));
        e.report().write(cell, measurements(c));
      }
    }
    e.progress().advance(1, "");
  }
  e.progress().clear();
}

/// Problems down, ways across; worst error in tolerances (below 1 is passed) and time.
void print_table(Experiment& e, std::FILE* file) {
  TextTable table({"problem", "formulation", "integrator and stabilisation", "status", "error/tolerance", "passed",
                   "energy drift", "time [s]", "evaluations"},
                  4);
  std::vector<std::pair<Cell, std::string>> order;
  std::map<std::string, std::map<std::string, double>> values;
  const auto key = [](const Cell& c) { return c.model + "\n" + c.formulation + "\n" + c.parameters; };
  for (const Row& row : e.report().rows()) {
    if (!values.count(key(row.cell))) order.emplace_back(row.cell, row.measurement.status);
    values[key(row.cell)][row.measurement.metric] = row.measurement.value;
  }
  for (const auto& [cell, status] : order) {
    auto& v = values[key(cell)];
    const auto number = [&](const char* metric) {
      return v.count(metric) && std::isfinite(v[metric]) ? fmt::format("{:.3g}", v[metric]) : std::string("-");
    };
    table.row({cell.model, cell.formulation, cell.parameters.substr(0, cell.parameters.rfind(';')), status,
               number("worst_error"), v["passed"] == 1 ? "yes" : "no", number("energy_drift"), number("time"),
               number("evaluations")});
  }
  fmt::print(file, "\n{}", table.text(10000));
}

void run(Experiment& e, const Options& options) {
  for (const ReferenceProblem& problem : chosen_problems(options, e.options().quick)) solve(e, options, problem);
  print_table(e, e.options().out == "-" ? stderr : stdout);
}

}  // namespace

int main(int argc, char** argv) {
  Experiment experiment(
      {.name = "reference-problems",
       .question = "Which published problems does each formulation, integrator and stabilisation solve, how exactly, "
                   "and how fast?",
       .models = [](bool) { return std::vector<std::string>(); }});
  Options options;
  experiment.option("--problems", options.problems, "glob over the names of the files in data/reference");
  experiment.option("--integrators", options.integrators,
                    "glob; each with all formulations and stabilisations (default: not all of these)");
  experiment.option("--stabilisations", options.stabilisations, "glob");
  experiment.option("--tolerance", options.tolerance, {1e-16, 1}, "of integrators that choose their steps");
  experiment.option("--steps", options.steps, {1, 1e9}, "of integrators with fixed steps, over the whole motion");
  return experiment.run(argc, argv, [&](Experiment& e) { run(e, options); });
}
