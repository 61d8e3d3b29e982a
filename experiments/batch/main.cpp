// What does a state cost among many: in the lanes of SIMD registers, and on several cores?
#include "lib/formulation/batch.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>

#include "experiments/batch/cores.h"
#include "lib/model/coordinates.h"
#include "lib/model/error.h"
#include "lib/report/crossing.h"
#include "lib/report/experiment.h"
#include "lib/report/table.h"
#include "lib/scalar/pack.h"
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

/// What cores are worth: work that needs nothing but a core's own registers and multipliers, on `threads` cores.
void multiply_in_registers(int threads) {
  const auto work = [] {
    using P = Pack<double, 4>;
    constexpr int rounds = 3'000'000;  // some milliseconds, so that starting a thread is a hundredth
    const P m(0.999), s(1e-3);
    P a(1.0), b(2.0), c(3.0), d(4.0), e(5.0), f(6.0), g(7.0), h(8.0);
    for (int k = 0; k < rounds; ++k)
      a = a * m + s, b = b * m + s, c = c * m + s, d = d * m + s, e = e * m + s, f = f * m + s, g = g * m + s,
      h = h * m + s;
    volatile double sum = (a + b + c + d + e + f + g + h)[0];
    (void)sum;
  };
  std::vector<std::jthread> others;
  for (int k = 1; k < threads; ++k) others.emplace_back(work);
  work();
}

struct Way {
  std::string parameters, phase;
  int count;  // of what is done in one go: states, or the control once a core
  std::function<void()> solve;
  bool on_each_core = false;  // one after the other
  std::vector<double> times = {};

  double seconds() const {
    const auto once = [&] {
      // Batches that follow one another: those before the one that is timed wake cores up, and fetch what the other
      // ways displaced.
      constexpr double long_enough = 0.03;
      for (double spent = 0; spent < long_enough;) spent += wall_seconds(solve);
      return wall_seconds(solve) / count;
    };
    const std::vector<int> cores = own_cores();
    if (!on_each_core || cores.empty()) return once();
    double rate = 0;  // of all of them, were they at work together
    for (const int core : cores) {
      const OnCore here(core);
      rate += 1 / once();
    }
    return static_cast<double>(cores.size()) / rate;
  }
};

/// So many that the start of a second core, and of each on memory that is new to it, is a hundredth of the work: with a
/// quarter of them two cores gained 1.76 where they now gain 1.9.
int enough_states(const Model& model) {
  constexpr int bodies = 400'000, least = 64;
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
  const auto way = [&](int lanes, int threads, std::function<void()> solve) {
    return Way{fmt::format("lanes={};threads={};states={}", lanes, threads, count), "total", count, std::move(solve)};
  };
  const auto control = [&](int threads) {
    return Way{fmt::format("lanes=0;threads={};states=0", threads), "registers", threads,
               [threads] { multiply_in_registers(threads); }};
  };
  // What a core does alone, on the mean of them: another's guest may share one of them, and then they are not alike.
  const auto on_each_core = [](Way way) {
    way.parameters += ";core=each";
    way.on_each_core = true;
    return way;
  };
  std::vector<Way> ways = {way(1, 1, [&] { one_by_one.solve(); }),
                           way(alone.lanes(), 1, [&] { alone.solve(cloud.states, answers); })};
  if (cores > 1) {
    ways.push_back(way(alone.lanes(), cores, [&] { together.solve(cloud.states, answers_together); }));
    ways.push_back(on_each_core(ways[1]));
    ways.push_back(control(cores)), ways.push_back(on_each_core(control(1)));
  }
  alone.solve(cloud.states, answers);
  const auto solved = std::count_if(answers.status.begin(), answers.status.end(), usable);
  for (int r = -1; r < e.options().repetitions; ++r)  // the first warms up
    for (Way& w : ways) {
      const double seconds = w.seconds();
      if (r < 0) continue;
      w.times.push_back(seconds);
      Cell cell = once;
      cell.parameters = w.parameters, cell.repetition = r;
      if (!e.report().has(cell)) e.report().write(cell, std::vector<Measurement>{{w.phase, "time", seconds, "s"}});
    }
  const auto gain = [&](int slow, int fast) { return median(ways[slow].times) / median(ways[fast].times); };
  const auto nanoseconds = [&](int k) { return fmt::format("{:.1f}", 1e9 * median(ways[k].times) / m.model.bodies()); };
  std::vector<std::string> cells = {name, std::string(info.name), fmt::format("{} of {}", solved, count)};
  for (int k : {0, 1}) cells.push_back(nanoseconds(k));
  cells.push_back(cores > 1 ? nanoseconds(2) : "");
  cells.push_back(fmt::format("{:.2f} = {:.2f} × {}", gain(0, 1), gain(0, 1) / alone.lanes(), alone.lanes()));
  cells.push_back(cores > 1 ? fmt::format("{:.2f} of {:.2f}", gain(3, 2), gain(5, 4)) : "");
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
  experiment.option("--states", states, "states in a batch; 0: as many as have 400 000 bodies together, at least 64");
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
