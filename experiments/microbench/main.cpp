// Google Benchmark over formulations × models, phase by phase.
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <iostream>
#include <map>
#include <memory>

#include "lib/report/experiment.h"
#include "lib/system/evaluator.h"

namespace {

using namespace lanc;

std::vector<std::string> default_models(bool quick) {
  if (quick) return {"chain:8", "tree:31"};
  return {"chain:1", "chain:8",  "chain:32", "chain:100", "chain:32:joint=spherical",
          "tree:31", "tree:255", "star:32",  "random:32"};
}

/// One formulation bound to one model at the state it comes with.
struct Bound {
  Mechanism mechanism;
  Evaluator<double> evaluator;
  Solution<double> solution;
  const System<double>& system;
  std::unique_ptr<Formulation<double>> formulation;

  Bound(const FormulationInfo& info, Mechanism m)
      : mechanism(std::move(m)),
        evaluator(mechanism.model),
        solution(mechanism.model),
        system(evaluator.system(mechanism.state)),
        formulation(info.create_double(mechanism.model)) {}

  void factorise() {
    formulation->assemble(system);
    benchmark::DoNotOptimize(formulation->factorise(system));
  }
  void solve() { benchmark::DoNotOptimize(formulation->solve(system, solution)); }
};

/// What the rows of one benchmark are about.
struct Subject {
  Cell cell;
  std::string phase;
};

/// Prints as Google Benchmark does, and writes the repetitions into the CSV.
class Reporter : public benchmark::ConsoleReporter {
 public:
  Reporter(Report& report, const std::map<std::string, Subject>& subjects)
      : ConsoleReporter(OO_Tabular), report_(report), subjects_(subjects) {}

  void ReportRuns(const std::vector<Run>& runs) override {
    ConsoleReporter::ReportRuns(runs);
    for (const Run& run : runs) {
      if (run.run_type != Run::RT_Iteration) continue;
      const auto subject = subjects_.find(run.run_name.function_name);
      if (subject == subjects_.end()) continue;
      Cell cell = subject->second.cell;
      cell.repetition = static_cast<int>(run.repetition_index);
      const double seconds = run.cpu_accumulated_time / static_cast<double>(run.iterations);
      report_.write(cell, std::vector<Measurement>{{subject->second.phase, "time", seconds, "s"}});
    }
  }

 private:
  Report& report_;
  const std::map<std::string, Subject>& subjects_;
};

/// Registers what is timed of one formulation on one model. The benchmarks own what they run on.
void add(const FormulationInfo& info, const std::string& model, const Mechanism& mechanism,
         const Experiment& experiment, double seconds, std::map<std::string, Subject>& subjects, Report& report) {
  struct Phase {
    const char *name, *parameters;
    void (*run)(Bound&);
  };
  constexpr Phase phases[] = {
      {"kinematics", "", [](Bound& b) { benchmark::DoNotOptimize(&b.evaluator.system(b.mechanism.state)); }},
      {"factorise", "including=assemble", [](Bound& b) { b.factorise(); }},
      {"solve", "including=assemble+factorise", [](Bound& b) { b.solve(); }}};
  const auto bound = std::make_shared<Bound>(info, mechanism);
  for (const Phase& phase : phases) {
    const std::string name = fmt::format("{}/{}/{}", info.name, model, phase.name);
    Cell cell = experiment.cell(model, mechanism.model, std::string(info.name), phase.parameters, 0);
    if (report.has(cell)) continue;
    subjects[name] = {cell, phase.name};
    benchmark::RegisterBenchmark(name.c_str(),
                                 [bound, run = phase.run](benchmark::State& state) {
                                   for (auto _ : state) run(*bound);
                                 })
        ->MinTime(seconds)
        ->Repetitions(experiment.options().repetitions)
        ->Unit(benchmark::kMicrosecond);
  }
}

}  // namespace

int main(int argc, char** argv) {
  Experiment experiment({.name = "microbench",
                         .question = "What does each phase of each formulation take, by Google Benchmark?",
                         .repetitions = 3,
                         .quick_repetitions = 1,
                         .models = default_models});
  double seconds = 0;
  experiment.option("--min-time", seconds, {0, 1e4},
                    "seconds each benchmark takes at least; 0: 0.05, or 0.01 with --quick");
  return experiment.run(argc, argv, [&](Experiment& e) {
    if (seconds <= 0) seconds = e.options().quick ? 0.01 : 0.05;
    std::map<std::string, Subject> subjects;
    for (const std::string& model : e.models()) {
      const Mechanism mechanism = e.load(model);
      for (const FormulationInfo* info : e.formulations())
        if (!info->objection(mechanism.model)) add(*info, model, mechanism, e, seconds, subjects, e.report());
    }
    std::string program = "microbench", interleave = "--benchmark_enable_random_interleaving=true";
    char* arguments[] = {program.data(), interleave.data(), nullptr};
    int count = 2;
    benchmark::Initialize(&count, arguments);
    Reporter reporter(e.report(), subjects);
    if (e.options().out == "-") reporter.SetOutputStream(&std::cerr);
    benchmark::RunSpecifiedBenchmarks(&reporter);
  });
}
