// From how many bodies on does the recursion need fewer operations, and less time, than the other ways to solve eq. 14?
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <set>

#include "experiments/crossover/curves.h"
#include "experiments/crossover/published.h"
#include "lib/report/experiment.h"
#include "lib/report/phases.h"

namespace {

using namespace lanc;

constexpr int largest = 64;
constexpr double none = std::numeric_limits<double>::quiet_NaN();

/// Sizes that are timed. Operations are counted at every size, so that their crossing is an exact whole number.
const std::set<int> timed_sizes = {1,  2,  3,  4,  5,  6,  7,  8,  9,  10, 11, 12,     13,
                                   14, 15, 16, 18, 20, 22, 24, 28, 32, 40, 48, largest};

std::vector<std::string> default_models(bool quick) {
  std::vector<std::string> models;
  for (const char* shape : {"chain", "tree", "star"})
    for (const char* joint : {"", ":joint=spherical", ":joint=free"}) {
      if (quick && (*joint != '\0' && std::string(shape) != "chain")) continue;
      for (int n = 1; n <= largest; ++n)
        if (!quick || (timed_sizes.count(n) && (n < 8 || n % 2 == 0)))
          models.push_back(fmt::format("{}:{}{}", shape, n, joint));
    }
  return models;
}

/// Flops by the library's counter where the arithmetic is the library's; empty where it has none.
std::vector<Measurement> library_flops(const LibraryStatistics& library, const Tally& kinematics,
                                       const std::string& status) {
  const auto coefficients = static_cast<double>(kinematics.flops());
  return {{"kinematics", "flops", coefficients, "1", status},
          {"assemble", "flops", 0.0, "1", status},  // copies coefficients
          {"factorise", "flops", library.factorise_flops, "1", status},
          {"solve", "flops", library.solve_flops, "1", status},
          {"total", "flops", coefficients + library.factorise_flops + library.solve_flops, "1", status},
          {"factorise", "nonzeros", static_cast<double>(library.factor_nonzeros), "1", status}};
}

/// What needs no repetition: operations, memory, and the time and outcome of binding.
std::vector<Measurement> counted(const FormulationInfo& info, const Mechanism& mechanism, PhaseTimer& timer,
                                 const Tally& kinematics) {
  const std::string status(to_string(timer.outcome().status));
  std::vector<Measurement> rows;
  if (info.create_count)
    rows = measurements(count_phases(info, mechanism.model, mechanism.state));
  else if (const auto library = timer.formulation().statistics())
    rows = library_flops(*library, kinematics, status);
  else
    rows = {{"total", "flops", none, "1", status}};
  rows.push_back({"analyse", "time", timer.analyse_seconds(), "s", status});
  rows.push_back({"total", "memory", static_cast<double>(timer.bytes()), "B", status});
  return rows;
}

Tally kinematics_operations(const Mechanism& mechanism) {
  Evaluator<Count> evaluator(mechanism.model);
  const State<Count> state = cast<Count>(mechanism.state);
  const Tally before = Count::tally();
  evaluator.system(state);
  return Count::tally() - before;
}

/// All cells of one model: counts first, then repetition by repetition over all formulations, so that a machine that
/// slows down slows all of them.
void measure(Experiment& experiment, const std::string& name) {
  const Mechanism mechanism = experiment.load(name);
  const Model& model = mechanism.model;
  Report& report = experiment.report();
  const bool timed = !experiment.options().models.empty() || timed_sizes.count(model.bodies()) > 0;
  const int repetitions = timed ? experiment.options().repetitions : 0;
  const Tally kinematics = kinematics_operations(mechanism);

  std::vector<std::pair<const FormulationInfo*, std::unique_ptr<PhaseTimer>>> timers;
  for (const FormulationInfo* info : experiment.formulations()) {
    const Cell cell = experiment.cell(name, model, std::string(info->name));
    if (info->objection(model)) {
      if (!report.has(cell))
        report.write(
            cell, std::vector<Measurement>{{"total", "flops", none, "1", std::string(to_string(Status::objection))}});
      continue;
    }
    auto timer = std::make_unique<PhaseTimer>(info->create_double, model, mechanism.state);
    if (!report.has(cell)) report.write(cell, counted(*info, mechanism, *timer, kinematics));
    if (timer->outcome().usable())
      timers.emplace_back(info, std::move(timer));  // a time without an answer says nothing
  }
  for (int r = 0; r < repetitions; ++r)
    for (auto& [info, timer] : timers) {
      const Cell cell = experiment.cell(name, model, std::string(info->name), {}, r);
      if (!report.has(cell)) report.write(cell, timer->repetition());
    }
}

/// Published counts join the family of revolute chains as formulations without times.
void add_published(std::map<std::string, Family>& families, Experiment& experiment) {
  const auto chain = families.find("chain:N");
  if (chain == families.end()) return;
  for (const PublishedCount& published : published_counts())
    for (const auto& [n, velocities] : chain->second.velocities) {
      const double operations = published.operations(n);
      chain->second.curves[std::string(published.name)].flops[n] = operations;
      Cell cell;
      cell.model = fmt::format("chain:{}", n);
      cell.bodies = n;
      cell.velocities = velocities;
      cell.formulation = published.name;
      cell.parameters = fmt::format("source={}", published.source);
      std::replace(cell.parameters.begin(), cell.parameters.end(), ';', ',');
      if (!experiment.report().has(cell))
        experiment.report().write(cell, std::vector<Measurement>{{"total", "flops", operations, "1"}});
    }
}

/// Rows of one crossing: where the lines meet, in bodies and velocities, and the first size from which on it holds.
void crossing_rows(std::vector<Measurement>& rows, const std::string& metric, const Family& family,
                   const PairCrossing& pair, bool measured) {
  if (pair.last == 0) return;
  const bool never = pair.kind == CrossingPoint::Kind::never;
  rows.push_back({"total", metric + "_from", never ? none : pair.first, "bodies"});
  rows.push_back({"total", metric, never ? none : pair.at, "bodies"});
  rows.push_back({"total", metric, never ? none : in_velocities(family, pair.at), "velocities"});
  if (!measured) return;
  rows.push_back({"total", metric + "_lower_quartile", pair.lower, "bodies"});
  rows.push_back({"total", metric + "_upper_quartile", pair.upper, "bodies"});
}

void write_crossings(Experiment& experiment, const std::map<std::string, Family>& families) {
  for (const auto& [name, family] : families) {
    if (family.velocities.size() < 2) continue;
    for (const auto& [a, cost] : family.curves)
      for (const auto& [b, other] : family.curves) {
        if (a == b) continue;
        Cell cell;
        cell.model = name;
        cell.bodies = family.velocities.rbegin()->first;
        cell.velocities = family.velocities.rbegin()->second;
        cell.formulation = a;
        cell.parameters = "against=" + b;
        cell.seed = experiment.options().seed;
        if (experiment.report().has(cell)) continue;
        std::vector<Measurement> rows;
        crossing_rows(rows, "crossing_flops", family, flops_crossing(cost, other), false);
        crossing_rows(rows, "crossing_time", family, time_crossing(cost, other, *cell.seed), true);
        experiment.report().write(cell, rows);
      }
  }
}

/// "11": from 11 bodies on; "1": always; "-": not compared; measured ones with the quartiles of the meeting point.
std::string told(const PairCrossing& pair, bool measured) {
  switch (pair.kind) {
    case CrossingPoint::Kind::never: return pair.last == 0 ? "-" : "never";
    case CrossingPoint::Kind::always: return "1";
    case CrossingPoint::Kind::crosses: break;
  }
  if (!measured) return fmt::format("{}", pair.first);
  const std::string upper = std::isfinite(pair.upper) ? fmt::format("{:.1f}", pair.upper) : "never";
  return fmt::format("{} [{:.1f}, {}]", pair.first, pair.lower, upper);
}

/// Up to how many bodies pairs told as "never" were compared; nothing when none was.
std::string reach_of_never(const std::set<int>& last) {
  if (last.empty()) return {};
  if (last.size() == 1) return fmt::format("; never: not up to {} bodies", *last.begin());
  return fmt::format("; never: not up to the largest size both have, {} to {} bodies", *last.begin(), *last.rbegin());
}

/// Models down, formulations that are not recursive across.
template <class Crossing>
void print_table(std::FILE* out, const std::string& title, const std::string& recursive,
                 const std::map<std::string, Family>& families, const std::vector<std::string>& others, bool measured,
                 Crossing&& crossing_of) {
  std::string rows;
  std::set<int> never;
  for (const auto& [name, family] : families) {
    const auto cost = family.curves.find(recursive);
    if (cost == family.curves.end() || family.velocities.size() < 2) continue;
    rows += fmt::format("  {:<24}", name);
    for (const std::string& other : others) {
      const auto found = family.curves.find(other);
      const PairCrossing pair =
          found == family.curves.end() ? PairCrossing() : crossing_of(cost->second, found->second);
      if (pair.last > 0 && pair.kind == CrossingPoint::Kind::never) never.insert(pair.last);
      rows += fmt::format(" {:<15}", told(pair, measured));
    }
    rows += "\n";
  }
  fmt::print(out, "\n{}{}\n  {:<24}", title, reach_of_never(never), "than:");
  for (const std::string& other : others) fmt::print(out, " {:<15}", other);
  fmt::print(out, "\n{}", rows);
}

/// For each formulation that is not recursive: the n from which on a recursive one is cheaper.
void print_tables(std::FILE* out, const Experiment& experiment, const std::map<std::string, Family>& families) {
  std::vector<std::string> others;
  for (const FormulationInfo* info : experiment.formulations())
    if (!info->recursive) others.emplace_back(info->name);
  for (const FormulationInfo* info : experiment.formulations()) {
    if (!info->recursive || others.empty()) continue;
    const std::string name(info->name);
    print_table(out, fmt::format("Bodies from which on '{}' needs fewer operations", name), name, families, others,
                false, flops_crossing);
    print_table(out, fmt::format("Bodies from which on '{}' needs less time [quartiles of the crossing]", name), name,
                families, others, true,
                [&](const Curve& a, const Curve& b) { return time_crossing(a, b, experiment.options().seed); });
  }
}

/// The same comparison between published counts.
void print_published(std::FILE* out, const std::map<std::string, Family>& families) {
  const auto chain = families.find("chain:N");
  if (chain == families.end() || chain->second.velocities.size() < 2) return;
  fmt::print(out, "\nThe same from published operation counts of revolute chains:\n");
  for (const PublishedCount& a : published_counts())
    for (const PublishedCount& b : published_counts())
      if (a.recursive && !b.recursive)
        fmt::print(out, "  {:<18} than {:<26} {}\n", a.name.substr(11), b.name.substr(11),
                   told(flops_crossing(chain->second.curves.at(std::string(a.name)),
                                       chain->second.curves.at(std::string(b.name))),
                        false));
}

void crossover(Experiment& experiment) {
  Progress& progress = experiment.progress();
  progress.start(static_cast<std::int64_t>(experiment.models().size()));
  for (const std::string& model : experiment.models()) {
    progress.advance(0, model);
    measure(experiment, model);
    progress.advance(1, model);
  }
  progress.clear();
  auto families = families_of(experiment.report().rows());
  add_published(families, experiment);
  write_crossings(experiment, families);
  std::FILE* out = experiment.options().out == "-" ? stderr : stdout;
  print_tables(out, experiment, families);
  print_published(out, families);
}

}  // namespace

int main(int argc, char** argv) {
  Experiment experiment({.name = "crossover",
                         .question = "From how many bodies on does the recursion need fewer operations, and less time, "
                                     "than other ways to solve eq. 14?",
                         .repetitions = 5,
                         .quick_repetitions = 3,
                         .models = default_models});
  return experiment.run(argc, argv, crossover);
}
