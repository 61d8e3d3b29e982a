// Which sparse solver, with which order and pivoting, for eq. 14 of which topology?
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <set>

#include "lib/report/accuracy.h"
#include "lib/report/crossing.h"
#include "lib/report/experiment.h"
#include "lib/report/phases.h"

namespace {

using namespace lanc;

std::vector<std::string> default_models(bool quick) {
  std::vector<std::string> models;
  for (const char* shape : {"chain", "tree", "star", "random"})
    for (const int n : {10, 100, 1000}) {
      if (quick && n == 1000) continue;
      if (n == 1000 && std::string_view(shape) == "star") continue;  // wrong orders fill up completely: hours
      // Random trees without massless bodies: solvers that divide by M* object to those.
      const char* options = std::string_view(shape) == "random" ? ":massless=no" : "";
      models.push_back(fmt::format("{}:{}{}", shape, n, options));
    }
  return models;
}

/// A formulation with one of its settings.
struct Choice {
  const FormulationInfo* info;
  std::string parameters;
  Factory<double> create;
};

std::vector<Choice> choices(const std::vector<const FormulationInfo*>& formulations) {
  std::vector<Choice> list;
  for (const FormulationInfo* info : formulations) {
    if (info->variants.empty()) list.push_back({info, {}, info->create_double});
    for (const Variant& variant : info->variants)
      list.push_back({info, std::string(variant.parameters), variant.create});
  }
  return list;
}

/// Set-up, fill-in, operations and errors: what needs no repetition.
std::vector<Measurement> properties(PhaseTimer& timer, const Reference& reference) {
  const std::string status(to_string(timer.outcome().status));
  std::vector<Measurement> rows = {{"analyse", "time", timer.analyse_seconds(), "s", status},
                                   {"total", "memory", static_cast<double>(timer.bytes()), "B", status}};
  if (const auto library = timer.formulation().statistics()) {
    const auto row = [&](const char* phase, const char* metric, double value) {
      rows.push_back({phase, metric, value, "1", status});
    };
    row("assemble", "nonzeros", static_cast<double>(library->matrix_nonzeros));
    row("factorise", "nonzeros", static_cast<double>(library->factor_nonzeros));
    row("factorise", "fill_in", static_cast<double>(library->factor_nonzeros - library->matrix_nonzeros));
    row("factorise", "flops", library->factorise_flops);
    row("solve", "flops", library->solve_flops);
    rows.push_back({"factorise", "memory", static_cast<double>(library->bytes), "B", status});
  }
  const auto errors = reference.errors(timer.system(), timer.solution(), status);
  rows.insert(rows.end(), errors.begin(), errors.end());
  return rows;
}

constexpr double longest_solution = 10;  // s

/// Shape of a model: "chain" of "chain:100".
std::string shape_of(const std::string& model) { return model.substr(0, model.find(':')); }

/// Seconds one solution may take if the order fills up: cubic growth from the largest smaller model of the same shape.
double worst_case(const std::vector<Row>& rows, const Cell& cell) {
  double seconds = 0;
  for (const auto& [c, m] : rows)
    if (m.phase == "total" && m.metric == "time" && std::isfinite(m.value) && c.bodies < cell.bodies &&
        c.formulation == cell.formulation && c.parameters == cell.parameters &&
        shape_of(c.model) == shape_of(cell.model))
      seconds = m.value * std::pow(static_cast<double>(cell.bodies) / c.bodies, 3);
  return seconds;
}

void measure(Experiment& experiment, const std::string& name, const std::vector<Choice>& list) {
  const Mechanism mechanism = experiment.load(name);
  const Model& model = mechanism.model;
  Report& report = experiment.report();
  const Reference reference(model, mechanism.state);
  std::vector<std::pair<const Choice*, std::unique_ptr<PhaseTimer>>> timers;
  for (const Choice& choice : list) {
    const Cell cell = experiment.cell(name, model, std::string(choice.info->name), choice.parameters);
    experiment.progress().advance(1, fmt::format("{} {} {}", name, choice.info->name, choice.parameters));
    if (choice.info->objection(model)) {
      const std::string status(to_string(Status::objection));
      if (!report.has(cell))
        report.write(
            cell, std::vector<Measurement>{{"total", "time", std::numeric_limits<double>::quiet_NaN(), "s", status}});
      continue;
    }
    if (const double seconds = worst_case(report.rows(), cell); seconds > longest_solution) {
      const std::string status(to_string(Status::objection));
      if (!report.has(cell))
        report.write(cell, std::vector<Measurement>{{"total", "time_forecast", seconds, "s", status}});
      continue;
    }
    auto timer = std::make_unique<PhaseTimer>(choice.create, model, mechanism.state);
    if (!report.has(cell)) report.write(cell, properties(*timer, reference));
    if (timer->outcome().usable()) timers.emplace_back(&choice, std::move(timer));
  }
  constexpr double slowest_repeated = 0.02;  // s: what takes longer is timed once, which is enough to see it
  std::set<const Choice*> slow;
  for (int r = 0; r < experiment.options().repetitions; ++r)
    for (auto& [choice, timer] : timers) {
      const Cell cell = experiment.cell(name, model, std::string(choice->info->name), choice->parameters, r);
      if (report.has(cell) || (r > 0 && slow.count(choice) > 0)) continue;
      const auto rows = timer->repetition();
      if (rows.back().value > slowest_repeated) slow.insert(choice);
      report.write(cell, rows);
    }
}

/// What one looks at first: time of assemble to solve, relative to the recursion, fill and error.
struct Line {
  int bodies = 0;
  std::string model, formulation, parameters, status;
  std::map<std::string, std::vector<double>> values;  // by phase/metric

  double value(const std::string& key) const {
    const auto found = values.find(key);
    return found == values.end() ? std::numeric_limits<double>::quiet_NaN() : median(found->second);
  }
  /// Without kinematics, which is the same for all.
  double seconds() const { return value("assemble/time") + value("factorise/time") + value("solve/time"); }
};

std::vector<Line> lines_of(const std::vector<Row>& rows) {
  std::vector<Line> lines;
  for (const auto& [cell, m] : rows) {
    const auto same = [&, &cell = cell](const Line& l) {
      return l.model == cell.model && l.formulation == cell.formulation && l.parameters == cell.parameters;
    };
    auto line = std::find_if(lines.begin(), lines.end(), same);
    if (line == lines.end())
      line = lines.insert(lines.end(), {cell.bodies, cell.model, cell.formulation, cell.parameters, m.status, {}});
    if (std::isfinite(m.value)) line->values[m.phase + "/" + m.metric].push_back(m.value);
  }
  return lines;
}

void print_table(std::FILE* out, const std::vector<Row>& rows) {
  const auto lines = lines_of(rows);
  fmt::print(out, "\n{:<24} {:<14} {:<38} {:>11} {:>12} {:>11} {:>10} {:>10}\n", "model", "formulation", "settings",
             "µs a body", "x recursion", "nz of L, U", "error v'", "backward");
  for (const Line& line : lines) {
    double recursion = std::numeric_limits<double>::quiet_NaN();
    for (const Line& other : lines)
      if (const auto* info = find_formulation(other.formulation); other.model == line.model && info && info->recursive)
        recursion = other.seconds();
    if (!std::isfinite(line.seconds())) {
      fmt::print(out, "{:<24} {:<14} {:<38} {:>11}\n", line.model, line.formulation, line.parameters, line.status);
      continue;
    }
    fmt::print(out, "{:<24} {:<14} {:<38} {:>11.3f} {:>12.1f} {:>11.0f} {:>10.1e} {:>10.1e}\n", line.model,
               line.formulation, line.parameters, 1e6 * line.seconds() / line.bodies, line.seconds() / recursion,
               line.value("factorise/nonzeros") / line.bodies, line.value("solve/error_vdot"),
               line.value("solve/backward_error_componentwise"));
  }
  fmt::print(out, "\nTimes without kinematics, medians; nz of L, U: non-zeros of the factors a body.\n");
}

}  // namespace

int main(int argc, char** argv) {
  Experiment experiment(
      {.name = "backends",
       .question = "Which sparse solver, in which order and with which pivoting, for eq. 14 of which topology?",
       .repetitions = 5,
       .quick_repetitions = 1,
       .models = default_models,
       .formulations = [](const FormulationInfo& info) { return info.recursive || !info.variants.empty(); }});
  return experiment.run(argc, argv, [](Experiment& e) {
    const auto list = choices(e.formulations());
    e.progress().start(static_cast<std::int64_t>(e.models().size() * list.size()));
    for (const std::string& model : e.models()) measure(e, model, list);
    e.progress().clear();
    print_table(e.options().out == "-" ? stderr : stdout, e.report().rows());
  });
}
