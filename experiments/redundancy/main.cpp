// What do redundant closure conditions do to each formulation? A catalogue of linkages, regular, overconstrained,
// singular and shaky.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>

#include "lib/closure/mobility.h"
#include "lib/report/crossing.h"
#include "lib/report/experiment.h"
#include "lib/report/phases.h"
#include "lib/report/table.h"

namespace {

using namespace lanc;

std::vector<std::string> default_models(bool quick) {
  std::vector<std::string> models;
  for (const auto& entry : std::filesystem::directory_iterator(LANC_DATA_DIR "/models/linkages"))
    if (entry.path().extension() == ".toml") models.push_back(entry.path().string());
  std::sort(models.begin(), models.end());
  for (const char* ladder : {"four-bar-ladder:1:cut=hinge", "four-bar-ladder:10:cut=hinge",
                             "four-bar-ladder:1:cut=hinge:angle=1.5707963267948966"})
    models.emplace_back(ladder);
  if (!quick) models.emplace_back("four-bar-ladder:40:cut=hinge");
  return models;
}

/// What is told of a mechanism, whatever solves it.
std::vector<Measurement> mobility_rows(const Mobility& m) {
  const auto count = [](const char* metric, int value) {
    return Measurement{"", metric, static_cast<double>(value), "1"};
  };
  int unique = 0, reactions = 0;
  for (const auto& joint : m.unique)
    for (const bool is : joint) unique += is, ++reactions;
  std::vector<Measurement> rows = {count("grubler", m.grubler),
                                   count("rank", m.rank),
                                   count("generic_rank", m.generic_rank),
                                   count("redundant", m.redundant()),
                                   count("mobility", m.mobility),
                                   count("finite_mobility", m.finite_mobility),
                                   count("absolute_coordinates", m.absolute_coordinates),
                                   count("absolute_rows", m.absolute_rows),
                                   count("absolute_rank", m.absolute_rank),
                                   count("unique_reaction_components", unique),
                                   count("reaction_components", reactions),
                                   {"", "sigma", m.sigma, "1"},
                                   {"", "next_sigma", m.next_sigma, "1"}};
  for (const Verdict v : {Verdict::regular, Verdict::overconstrained, Verdict::singular, Verdict::shaky})
    rows.push_back(count(fmt::format("verdict_{}", to_string(v)).c_str(), m.verdict == v));
  return rows;
}

/// An answer to compare with: of the first formulation in long double that has one.
std::optional<Solution<double>> reference(const Mechanism& m) {
  Evaluator<long double> evaluator(m.model);
  const System<long double>& system = evaluator.system(cast<long double>(m.state));
  for (const FormulationInfo& info : formulations()) {
    if (!info.create_long_double || info.objection(m.model)) continue;
    Solution<long double> wide(m.model);
    if (!info.create_long_double(m.model)->solve(system, wide).has_answer()) continue;
    Solution<double> result(m.model);
    for (std::size_t k = 0; k < wide.vdot.size(); ++k) result.vdot[k] = to_double(wide.vdot[k]);
    for (std::size_t k = 0; k < wide.lambda.size(); ++k) result.lambda[k] = to_double(wide.lambda[k]);
    return result;
  }
  return std::nullopt;
}

double relative_difference(const std::vector<double>& a, const std::vector<double>& b, double size) {
  double difference = 0;
  for (std::size_t k = 0; k < a.size(); ++k)
    difference = std::max(difference, std::abs(a[k] - b[k])), size = std::max(size, std::abs(b[k]));
  return difference == 0 ? 0 : difference / size;
}

/// What accelerations balance, in m/s² or rad/s², whichever is less: a mechanism in equilibrium has none.
double acceleration_of_loads(const Model& model) {
  const Vec3<double>& g = model.gravity();
  return std::sqrt(dot(g, g)) * std::min(1.0, 1 / model.length());
}

std::vector<Measurement> formulation_rows(const FormulationInfo& info, const Mechanism& m,
                                          const std::optional<Solution<double>>& exact, int repetitions) {
  constexpr double nothing = std::numeric_limits<double>::quiet_NaN();
  if (info.objection(m.model)) return {{"total", "time", nothing, "s", std::string(to_string(Status::objection))}};
  PhaseTimer timer(info.create_double, m.model, m.state);
  const Outcome& outcome = timer.outcome();
  const std::string status(to_string(outcome.status));
  if (!outcome.has_answer()) return {{"total", "time", nothing, "s", status}};
  double norm = 0;
  for (const double l : timer.solution().lambda) norm = std::hypot(norm, l);
  std::vector<Measurement> rows = {{"solve", "lambda_norm", norm, "SI", status}};
  if (exact) {
    rows.push_back({"solve", "error_vdot",
                    relative_difference(timer.solution().vdot, exact->vdot, acceleration_of_loads(m.model)), "1",
                    status});
    rows.push_back(
        {"solve", "error_lambda", relative_difference(timer.solution().lambda, exact->lambda, 0), "1", status});
  }
  std::map<std::string, std::vector<double>> times;
  for (int r = 0; r < repetitions; ++r)
    for (const Measurement& time : timer.repetition()) times[time.phase].push_back(time.value);
  for (auto& [phase, values] : times) rows.push_back({phase, "time", median(values), "s", status});
  return rows;
}

std::string short_name(const std::string& model) {
  return model.find('/') == std::string::npos ? model : std::filesystem::path(model).stem().string();
}

void run(Experiment& e) {
  Progress& progress = e.progress();
  progress.start(static_cast<std::int64_t>(e.models().size() * (1 + e.formulations().size())));
  TextTable table({"linkage", "verdict", "rows", "rank", "generic", "redundant", "Grübler", "mobility", "finite",
                   "statuses", "worst error of v'"},
                  2);
  for (const std::string& argument : e.models()) {
    const Mechanism m = e.load(argument);
    const std::string name = short_name(argument);
    const Mobility mobility = analyse_mobility(m.model, m.state);
    const Cell cell = e.cell(name, m.model);
    if (!e.report().has(cell)) e.report().write(cell, mobility_rows(mobility));
    progress.advance(1, name);
    std::optional<Solution<double>> exact;
    bool asked = false;
    for (const FormulationInfo* info : e.formulations()) {
      const Cell own = e.cell(name, m.model, std::string(info->name));
      if (!e.report().has(own)) {
        if (!asked) exact = reference(m), asked = true;
        e.report().write(own, formulation_rows(*info, m, exact, e.options().repetitions));
      }
      progress.advance(1, name);
    }
    std::map<std::string, std::string> status;  // by formulation
    double worst = 0;
    for (const Row& row : e.report().rows())
      if (row.cell.model == name && !row.cell.formulation.empty()) {
        status[row.cell.formulation] = row.measurement.status;
        if (row.measurement.metric == "error_vdot") worst = std::max(worst, row.measurement.value);
      }
    std::map<std::string, int> statuses;
    for (const auto& [formulation, how] : status) ++statuses[how];
    std::string counts;
    for (const auto& [how, count] : statuses) counts += fmt::format("{}{} {}", counts.empty() ? "" : ", ", count, how);
    table.row({name, std::string(to_string(mobility.verdict)), std::to_string(mobility.closure_rows),
               std::to_string(mobility.rank), std::to_string(mobility.generic_rank),
               std::to_string(mobility.redundant()), std::to_string(mobility.grubler),
               std::to_string(mobility.mobility), std::to_string(mobility.finite_mobility), counts,
               fmt::format("{:.1e}", worst)});
  }
  progress.clear();
  fmt::print(e.options().out == "-" ? stderr : stdout, "\n{}", table.text());
}

}  // namespace

int main(int argc, char** argv) {
  Experiment experiment({.name = "redundancy",
                         .question = "What do redundant closure conditions do to each formulation?",
                         .repetitions = 5,
                         .quick_repetitions = 1,
                         .models = default_models});
  return experiment.run(argc, argv, run);
}
