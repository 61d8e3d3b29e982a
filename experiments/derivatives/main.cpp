// What do the derivatives of forward dynamics take, against forward dynamics itself?
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "lib/derivatives/forward_derivatives.h"
#include "lib/report/crossing.h"
#include "lib/report/experiment.h"
#include "lib/report/table.h"
#include "lib/report/timing.h"

namespace {

using namespace lanc;

std::vector<std::string> default_models(bool quick) {
  std::vector<std::string> models;
  for (const int n : {1, 2, 4, 6, 8, 12, 16, 24, 32, 48, 64, 100})
    if (n <= (quick ? 16 : 100)) models.push_back(fmt::format("chain:{}", n));
  for (const char* model : {"tree:31", "random:32", "four-bar-ladder:10", "four-bar-ladder:10:cut=weld"})
    if (!quick) models.push_back(model);
  return models;
}

/// One model: kinematics and a formulation, and on top of them derivatives in either way.
class Subject {
 public:
  Subject(const FormulationInfo& info, const Mechanism& m)
      : m_(m),
        evaluator_(m.model),
        solution_(m.model),
        formulation_(info.create_double(m.model)),
        analytic_(m.model),
        dual_(m.model, {}) {}

  Outcome forward() {
    system_ = &evaluator_.system(m_.state);
    return formulation_->solve(*system_, solution_);
  }
  Outcome analytic() { return analytic_.at(evaluator_, *system_, m_.state, {}, solution_); }
  Outcome dual() { return dual_.at(*system_, m_.state, solution_); }

  /// Largest difference of the two in ∂η̇/∂q and ∂η̇/∂η, relative to the largest entry.
  double difference() const {
    const ForwardDerivatives &a = analytic_.derivatives(), &b = dual_.derivatives();
    double worst = 0;
    for (const auto& [x, y] : {std::pair{&a.position, &b.position}, {&a.velocity, &b.velocity}}) {
      double error = 0, size = 0;
      for (std::size_t k = 0; k < y->size(); ++k)
        error = std::max(error, std::abs((*x)[k] - (*y)[k])), size = std::max(size, std::abs((*y)[k]));
      worst = std::max(worst, size > 0 ? error / size : error);
    }
    return worst;
  }

 private:
  const Mechanism& m_;
  Evaluator<double> evaluator_;
  Solution<double> solution_;
  std::unique_ptr<Formulation<double>> formulation_;
  AnalyticDerivatives analytic_;
  DualDerivatives dual_;
  const System<double>* system_ = nullptr;
};

const std::string ways[] = {"none", "analytic", "dual"};

void measure(Experiment& e, const std::string& name, const FormulationInfo& info) {
  const Mechanism m = e.load(name);
  const auto cell = [&](const std::string& way, std::optional<int> repetition) {
    return e.cell(name, m.model, std::string(info.name), "derivatives=" + way, repetition);
  };
  if (info.objection(m.model)) return;
  Subject subject(info, m);
  Outcome outcome = subject.forward();
  if (outcome.usable()) outcome = subject.analytic();
  const std::string status(to_string(outcome.status));
  if (!outcome.usable() || !subject.dual().usable()) {
    e.progress().say(fmt::format("{} {}: {}", name, info.name, outcome.message));
    return;
  }
  if (!e.report().has(cell("analytic", std::nullopt)))
    e.report().write(cell("analytic", std::nullopt),
                     std::vector<Measurement>{{"total", "difference", subject.difference(), "1", status}});
  Repeat repeat[3];
  for (int r = 0; r < e.options().repetitions; ++r)
    for (int way = 0; way < 3; ++way) {
      const double seconds = repeat[way].seconds([&] {
        (void)subject.forward();
        if (way == 1) (void)subject.analytic();
        if (way == 2) (void)subject.dual();
      });
      if (!e.report().has(cell(ways[way], r)))
        e.report().write(cell(ways[way], r), std::vector<Measurement>{{"total", "time", seconds, "s", status}});
    }
}

void print_table(Experiment& e) {
  struct Line {
    std::map<std::string, std::vector<double>> times;
    double difference = 0;
  };
  std::map<std::pair<std::string, std::string>, Line> lines;
  for (const auto& [cell, m] : e.report().rows()) {
    Line& line = lines[{cell.model, cell.formulation}];
    if (m.metric == "difference") line.difference = m.value;
    if (m.metric == "time") line.times[cell.parameters.substr(cell.parameters.find('=') + 1)].push_back(m.value);
  }
  TextTable table({"model", "formulation", "forward [µs]", "analytic [µs]", "dual [µs]", "analytic/forward",
                   "dual/forward", "difference"},
                  2);
  for (const std::string& model : e.models())
    for (const FormulationInfo* info : e.formulations()) {
      const auto found = lines.find({model, std::string(info->name)});
      if (found == lines.end()) continue;
      const auto of = [&](const std::string& way) { return median(found->second.times[way]); };
      const double forward = of("none");
      table.row({model, std::string(info->name), fmt::format("{:.2f}", 1e6 * forward),
                 fmt::format("{:.2f}", 1e6 * of("analytic")), fmt::format("{:.1f}", 1e6 * of("dual")),
                 fmt::format("{:.2f}", of("analytic") / forward), fmt::format("{:.1f}", of("dual") / forward),
                 fmt::format("{:.0e}", found->second.difference)});
    }
  fmt::print(e.options().out == "-" ? stderr : stdout, "\n{}", table.text(1000));
}

}  // namespace

int main(int argc, char** argv) {
  Experiment experiment({.name = "derivatives",
                         .question = "What do the derivatives of forward dynamics take, against forward dynamics?",
                         .repetitions = 21,
                         .quick_repetitions = 3,
                         .models = default_models,
                         .formulations = [](const FormulationInfo& info) { return info.recursive; }});
  return experiment.run(argc, argv, [](Experiment& e) {
    e.progress().start(static_cast<std::int64_t>(e.models().size() * e.formulations().size()));
    for (const std::string& model : e.models())
      for (const FormulationInfo* info : e.formulations()) {
        measure(e, model, *info);
        e.progress().advance(1, fmt::format("{} {}", model, info->name));
      }
    e.progress().clear();
    print_table(e);
  });
}
