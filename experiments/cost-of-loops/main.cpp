// What do closed loops cost, in time and operations, against their number and kind?
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "lib/report/crossing.h"
#include "lib/report/experiment.h"
#include "lib/report/phases.h"
#include "lib/report/table.h"

namespace {

using namespace lanc;

std::vector<std::string> default_models(bool quick) {
  std::vector<std::string> models;
  for (const char* shape : {"four-bar-ladder:{}", "four-bar-ladder:{}:cut=weld", "four-bar-chain:{}",
                            "four-bar-tree:{}", "four-bar-nest:{}", "polygon:{}", "random-loops:{}"})
    for (const int n : {1, 2, 5, 10, 20, 50, 100}) {
      const bool random = shape[0] == 'r';
      if (n == 1 && shape[0] == 'p') continue;
      if (n <= (quick ? 10 : random ? 20 : 100)) models.push_back(fmt::format(fmt::runtime(shape), n));
    }
  return models;
}

std::vector<Measurement> measured(const FormulationInfo& info, const Mechanism& m, int repetitions, double time_limit) {
  constexpr double nothing = std::numeric_limits<double>::quiet_NaN();
  if (info.objection(m.model)) return {{"total", "time", nothing, "s", std::string(to_string(Status::objection))}};
  PhaseTimer timer(info.create_double, m.model, m.state);
  const std::string status(to_string(timer.outcome().status));
  if (!timer.outcome().has_answer()) return {{"total", "time", nothing, "s", status}};
  std::map<std::string, std::vector<double>> times;
  double spent = 0;
  for (int r = 0; r < repetitions && spent < time_limit; ++r)
    for (const Measurement& time : timer.repetition()) {
      times[time.phase].push_back(time.value);
      if (time.phase == "total") spent += 5 * time.value;
    }
  std::vector<Measurement> rows;
  for (auto& [phase, values] : times) rows.push_back({phase, "time", median(values), "s", status});
  if (info.create_count) {
    for (const Measurement& count : measurements(count_phases(info, m.model, m.state)))
      if (count.metric == "flops") rows.push_back(count);
  } else if (const auto library = timer.formulation().statistics()) {
    rows.push_back({"factorise", "flops", library->factorise_flops, "1", status});
    rows.push_back({"solve", "flops", library->solve_flops, "1", status});
  }
  return rows;
}

void run(Experiment& e, double time_limit) {
  Progress& progress = e.progress();
  progress.start(static_cast<std::int64_t>(e.models().size() * e.formulations().size()));
  for (const std::string& name : e.models()) {
    const Mechanism m = e.load(name);
    for (const FormulationInfo* info : e.formulations()) {
      const Cell cell = e.cell(name, m.model, std::string(info->name));
      if (!e.report().has(cell)) e.report().write(cell, measured(*info, m, e.options().repetitions, time_limit));
      progress.advance(1, fmt::format("{} {}", name, info->name));
    }
  }
  progress.clear();
  TextTable table({"model", "formulation", "status", "total [µs]", "rank [µs]", "flops"}, 3);
  std::map<std::pair<std::string, std::string>, std::map<std::string, double>> values;
  std::map<std::pair<std::string, std::string>, std::string> status;
  std::vector<std::pair<std::string, std::string>> order;
  for (const Row& row : e.report().rows()) {
    const auto key = std::pair(row.cell.model, row.cell.formulation);
    if (!status.count(key)) order.push_back(key);
    status.emplace(key, row.measurement.status);
    values[key][row.measurement.phase + " " + row.measurement.metric] = row.measurement.value;
  }
  const auto number = [&](const auto& key, const char* what, double scale) {
    const auto found = values[key].find(what);
    return found == values[key].end() || !std::isfinite(found->second) ? std::string("-")
                                                                       : fmt::format("{:.4g}", scale * found->second);
  };
  for (const auto& key : order)
    table.row({key.first, key.second, status[key], number(key, "total time", 1e6), number(key, "rank time", 1e6),
               number(key, "total flops", 1)});
  fmt::print(e.options().out == "-" ? stderr : stdout, "\n{}", table.text(1000));
}

}  // namespace

int main(int argc, char** argv) {
  Experiment experiment(
      {.name = "cost-of-loops",
       .question = "What do closed loops cost, in time and operations, against their number and kind?",
       .repetitions = 5,
       .quick_repetitions = 1,
       .models = default_models});
  double time_limit = 5;
  experiment.option("--time-limit", time_limit, {0, std::numeric_limits<double>::infinity()},
                    "seconds of repetitions of a formulation on one model");
  return experiment.run(argc, argv, [&](Experiment& e) { run(e, time_limit); });
}
