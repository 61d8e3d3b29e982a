// What does a state cost among many: in the lanes of SIMD registers, and on several cores?
#include "lib/formulation/batch.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>

#include "lib/model/coordinates.h"
#include "lib/model/error.h"
#include "lib/report/crossing.h"
#include "lib/report/experiment.h"
#include "lib/report/table.h"
#include "lib/system/evaluator.h"

namespace {

using namespace lanc;

/// States about that of the mechanism.
struct Cloud {
  std::vector<double> q, v;
  BatchStates states;

  Cloud(const Mechanism& m, int count) {
    for (int k = 0; k < count; ++k) {
      State<double> state = m.state;
      for (std::size_t i = 0; i < state.v.size(); ++i) state.v[i] += 0.1 * std::cos(2 + 5.0 * k + double(i));
      // moved along the velocities
      std::vector<double> step = state.v;
      for (double& x : step) x *= 0.1 * std::sin(1.0 + k);
      state.q = displaced(m.model, state.q, step);
      q.insert(q.end(), state.q.begin(), state.q.end());
      v.insert(v.end(), state.v.begin(), state.v.end());
    }
    states = {m.state.t, q, v, {}};
  }
};

double wall_seconds(const std::function<void()>& call) {
  const auto begin = std::chrono::steady_clock::now();
  call();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

/// The phases on one state after the other, without a look at the answers.
class OneByOne {
 public:
  OneByOne(const Model& model, const FormulationInfo& info, const BatchStates& states, int count)
      : evaluator_(model), solution_(model), formulation_(info.create_double(model)) {
    for (int k = 0; k < count; ++k) states_.push_back(states.state(model, k));
  }
  void solve() {
    for (const State<double>& state : states_) {
      const System<double>& system = evaluator_.system(state);
      formulation_->assemble(system);
      if (formulation_->factorise(system).usable()) formulation_->substitute(system, system.rhs, solution_);
    }
  }

 private:
  Evaluator<double> evaluator_;
  Solution<double> solution_;
  std::unique_ptr<Formulation<double>> formulation_;
  std::vector<State<double>> states_;
};

struct Way {
  std::string parameters;
  std::function<void()> solve;
  std::vector<double> times = {};
};

/// So many that a second core is awake before they are done: less than half a millisecond of work showed one core only.
int enough_states(const Model& model) {
  constexpr int bodies = 100'000, least = 64;
  return std::max(bodies / std::max(1, model.bodies()), least);
}

/// `count`: of states; 0 for enough_states().
void measure(Experiment& e, const std::string& name, const FormulationInfo& info, int count, TextTable& table) {
  const Mechanism m = e.load(name);
  if (count == 0) count = enough_states(m.model);
  if (const auto reason = info.objection(m.model)) return e.progress().say(fmt::format("{}: {}", name, *reason));
  if (m.model.has_closures() || m.model.nv() == 0)
    return e.progress().say(fmt::format("{}: batches are compared on open mechanisms that can move", name));
  const Cell once = e.cell(name, m.model, std::string(info.name));
  const Cloud cloud(m, count);
  OneByOne one_by_one(m.model, info, cloud.states, count);
  const int cores = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  Batch alone(m.model, info, {1}), together(m.model, info, {cores});
  BatchAnswers answers, answers_together;  // none waits for lines that another core has written
  const auto parameters = [&](int lanes, int threads) {
    return fmt::format("lanes={};threads={};states={}", lanes, threads, count);
  };
  std::vector<Way> ways = {{parameters(1, 1), [&] { one_by_one.solve(); }},
                           {parameters(alone.lanes(), 1), [&] { alone.solve(cloud.states, answers); }}};
  if (cores > 1)
    ways.push_back({parameters(alone.lanes(), cores), [&] { together.solve(cloud.states, answers_together); }});
  alone.solve(cloud.states, answers);
  const auto solved = std::count_if(answers.status.begin(), answers.status.end(), usable);
  for (int r = -1; r < e.options().repetitions; ++r)  // the first warms up
    for (Way& way : ways) {
      const double seconds = wall_seconds(way.solve) / count;
      if (r < 0) continue;
      way.times.push_back(seconds);
      Cell cell = once;
      cell.parameters = way.parameters, cell.repetition = r;
      if (!e.report().has(cell)) e.report().write(cell, std::vector<Measurement>{{"total", "time", seconds, "s"}});
    }
  std::vector<std::string> cells = {name, std::string(info.name), fmt::format("{} of {}", solved, count)};
  for (const Way& way : ways) cells.push_back(fmt::format("{:.1f}", 1e9 * median(way.times) / m.model.bodies()));
  const double faster = median(ways[0].times) / median(ways[1].times);
  cells.push_back(fmt::format("{:.2f} = {:.2f} × {}", faster, faster / alone.lanes(), alone.lanes()));
  cells.push_back(cores > 1 ? fmt::format("{:.2f}", median(ways[1].times) / median(ways[2].times)) : "");
  table.row(cells);
}

}  // namespace

int main(int argc, char** argv) {
  int states = 0;
  Experiment experiment({.name = "batch",
                         .question = "What does a state cost among many: in SIMD lanes, and on all cores?",
                         .repetitions = 21,
                         .quick_repetitions = 5,
                         .models =
                             [](bool quick) {
                               return quick ? std::vector<std::string>{"chain:6", "chain:32"}
                                            : std::vector<std::string>{
                                                  "chain:6",   "chain:12", "chain:32",  "chain:64",
                                                  "chain:100", "tree:63",  "tree:1023", "chain:20:joint=spherical"};
                             },
                         .formulations = [](const FormulationInfo& info) { return info.create_kernel != nullptr; }});
  experiment.option("--states", states, "states in a batch; 0: as many as have 100 000 bodies together, at least 64");
  return experiment.run(argc, argv, [&](Experiment& e) {
    if (states < 0) throw InputError(fmt::format("--states {}: give a number of states, or 0", states));
    TextTable table(
        {"model", "formulation", "solved", "one by one", "in lanes", "on all cores", "lanes gain", "cores gain"});
    e.progress().start(static_cast<std::int64_t>(e.models().size() * e.formulations().size()));
    for (const std::string& model : e.models())
      for (const FormulationInfo* info : e.formulations()) {
        measure(e, model, *info, states, table);
        e.progress().advance(1, model);
      }
    fmt::print(e.options().out == "-" ? stderr : stdout, "ns a body and state, wall-clock medians:\n{}", table.text());
  });
}
