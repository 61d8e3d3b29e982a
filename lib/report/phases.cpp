#include "lib/report/phases.h"

#include <cmath>

#include "lib/report/memory.h"

namespace lanc {

PhaseCounts count_phases(const FormulationInfo& info, const Model& model, const State<double>& state) {
  PhaseCounts counts;
  Evaluator<Count> evaluator(model);
  Solution<Count> solution(model);
  const auto formulation = info.create_count(model);
  const State<Count> counted = cast<Count>(state);
  const Tally start = Count::tally();
  const System<Count>& system = evaluator.system(counted);
  counts.kinematics = Count::tally() - start;
  formulation->decide(system);
  const Tally decided = Count::tally();
  formulation->assemble(system);
  const Tally assembled = Count::tally();
  counts.outcome = formulation->factorise(system);
  const Tally factorised = Count::tally();
  if (counts.outcome.usable()) formulation->substitute(system, system.rhs, solution);
  counts.assemble = assembled - decided;
  counts.factorise = factorised - assembled;
  counts.solve = Count::tally() - factorised;
  return counts;
}

std::vector<Measurement> measurements(const PhaseCounts& counts) {
  const std::string status(to_string(counts.outcome.status));
  std::vector<Measurement> rows;
  Tally total;
  const auto add = [&](const char* phase, const Tally& tally) {
    rows.push_back({phase, "flops", static_cast<double>(tally.flops()), "1", status});
    total.add += tally.add, total.sub += tally.sub, total.mul += tally.mul;
    total.div += tally.div, total.sqrt += tally.sqrt, total.trig += tally.trig;
  };
  add("kinematics", counts.kinematics);
  add("assemble", counts.assemble);
  add("factorise", counts.factorise);
  add("solve", counts.solve);
  const auto row = [&](const char* metric, std::int64_t n) {
    rows.push_back({"total", metric, static_cast<double>(n), "1", status});
  };
  row("flops", total.flops());
  row("add", total.add);
  row("sub", total.sub);
  row("mul", total.mul);
  row("div", total.div);
  row("sqrt", total.sqrt);
  row("trig", total.trig);
  return rows;
}

RankPolicy held_rank(Factory<double> create, const Model& model, const State<double>& state) {
  if (!model.has_closures()) return {};
  Evaluator<double> evaluator(model);
  Solution<double> solution(model);
  const Outcome outcome = create(model)->solve(evaluator.system(state), solution);
  return outcome.usable() ? RankPolicy{.rank = outcome.rank, .by_pivots = true} : RankPolicy{};
}

PhaseTimer::PhaseTimer(Factory<double> create, const Model& model, const State<double>& state, RankPolicy policy)
    : state_(state), evaluator_(model), solution_(model), system_(&evaluator_.system(state_)), policy_(policy) {
  bytes_ = heap_bytes_of([&] {
    const double begin = thread_seconds();
    formulation_ = create(model);
    analyse_seconds_ = thread_seconds() - begin;
    outcome_ = formulation_->solve(*system_, solution_, policy_);
  });
  if (!std::isnan(outcome_.sigma)) policy_.by_pivots = false;  // pivots did not do, and singular values were asked
}

std::vector<Measurement> PhaseTimer::repetition() {
  Outcome outcome;
  const auto factorise = [&] {
    formulation_->assemble(*system_);
    outcome = formulation_->factorise(*system_);
  };
  const auto solve = [&] {
    factorise();
    if (outcome.usable()) formulation_->substitute(*system_, system_->rhs, solution_);
  };
  const double kinematics = kinematics_.seconds([&] { evaluator_.system(state_); });
  const bool closed = system_->model.has_closures();
  const double decided = closed ? rank_.seconds([&] { formulation_->decide(*system_, policy_); }) : 0;
  const double assembled = assemble_.seconds([&] { formulation_->assemble(*system_); });
  const double factorised = factorise_.seconds(factorise);
  const double solved = solve_.seconds(solve);
  const double total = total_.seconds([&] {
    evaluator_.system(state_);
    formulation_->decide(*system_, policy_);
    solve();
  });
  const std::string status(to_string(outcome_.status));
  std::vector<Measurement> rows;
  const auto row = [&](const char* phase, double seconds) { rows.push_back({phase, "time", seconds, "s", status}); };
  row("kinematics", kinematics);
  if (closed) row("rank", decided);
  row("assemble", assembled);
  row("factorise", factorised - assembled);
  row("solve", solved - factorised);
  row("total", total);
  return rows;
}

}  // namespace lanc
