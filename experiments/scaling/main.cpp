// How do time, memory and errors grow with the number of bodies, up to a million?
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>

#include "lib/report/accuracy.h"
#include "lib/report/crossing.h"
#include "lib/report/experiment.h"
#include "lib/report/memory.h"
#include "lib/report/phases.h"

namespace {

using namespace lanc;

std::vector<std::string> default_models(bool quick) {
  // The quick sizes lie closer together: forecasts from them are good enough to leave out what would take long.
  const std::vector<int> sizes = quick ? std::vector<int>{1, 10, 100, 300, 1'000, 3'000}
                                       : std::vector<int>{1, 10, 100, 1'000, 10'000, 100'000, 1'000'000};
  std::vector<std::string> models;
  for (const char* shape : {"chain", "tree"})
    for (const int n : sizes) models.push_back(fmt::format("{}:{}", shape, n));
  for (const int n : sizes)  // N loops of 2 N + 1 bodies
    if (n > 1) models.push_back(fmt::format("four-bar-ladder:{}", n / 2));
  return models;
}

/// What a formulation took on the models before, to foresee what the next, larger one of the same kind takes.
class Forecast {
 public:
  void add(int bodies, double cost) { costs_[bodies] = cost; }
  /// Along the power law through the last two sizes, at least linear; nothing known: 0.
  double at(int bodies) const {
    const auto above = costs_.lower_bound(bodies);
    if (above == costs_.begin()) return 0;
    const auto last = std::prev(above);
    double exponent = 1;
    if (last != costs_.begin()) {
      const auto before = std::prev(last);
      exponent =
          std::clamp(std::log(last->second / before->second) / std::log(double(last->first) / before->first), 1.0, 3.0);
    }
    return last->second * std::pow(static_cast<double>(bodies) / last->first, exponent);
  }

 private:
  std::map<int, double> costs_;
};

struct Forecasts {
  Forecast bytes, seconds;
};

/// Singular values of 10⁶ loops would take longer than all the rest. Of a regular mechanism the rank is known from
/// two smaller ones, and the pivots of formulations that have some confirm it.
class Rank {
 public:
  RankPolicy of(const Model& model) const {
    const std::int64_t rows = model.closures().rows();
    if (!agreed_ || rows * rank_ % rows_ != 0) return {};
    return {.rank = static_cast<int>(rows * rank_ / rows_), .by_pivots = true};
  }
  void learn(const Model& model, const Outcome& outcome) {
    const std::int64_t rows = model.closures().rows();
    if (!outcome.usable() || rows == 0 || rows == rows_) return;
    agreed_ = rows_ > 0 && rank_ * rows == outcome.rank * rows_;
    rows_ = rows, rank_ = outcome.rank;
  }

 private:
  std::int64_t rows_ = 0, rank_ = 0;
  bool agreed_ = false;  // two sizes had the same share of independent rows
};

/// The kind of model: its argument without the size.
std::string kind_of(const std::string& model) {
  const std::size_t begin = model.find(':');
  if (begin == std::string::npos) return model;
  return model.substr(0, begin) + model.substr(std::min(model.find(':', begin + 1), model.size()));
}

constexpr double slowest_repeated = 0.2;  // s: what takes longer is timed once
constexpr int phases = 5;                 // times every phase of a repetition is run through, at least

class Scaling {
 public:
  Scaling(Experiment& experiment, double time_limit, double memory_share)
      : experiment_(experiment), time_limit_(time_limit), memory_share_(memory_share) {}

  void run() {
    Progress& progress = experiment_.progress();
    progress.start(static_cast<std::int64_t>(experiment_.models().size() * experiment_.formulations().size()));
    for (const std::string& name : experiment_.models()) {
      const Mechanism mechanism = experiment_.load(name);
      std::unique_ptr<Reference> reference;  // made when the first formulation asks for it
      for (const FormulationInfo* info : experiment_.formulations()) {
        progress.advance(0, fmt::format("{} {}", name, info->name));
        measure(name, mechanism, *info, reference);
        progress.advance(1, name);
      }
    }
  }

 private:
  void refuse(const Cell& cell, const std::string& metric, double value, const std::string& unit) {
    experiment_.report().write(
        cell, std::vector<Measurement>{{"total", metric, value, unit, std::string(to_string(Status::objection))}});
  }

  void measure(const std::string& name, const Mechanism& mechanism, const FormulationInfo& info,
               std::unique_ptr<Reference>& reference) {
    const Model& model = mechanism.model;
    const Cell cell = experiment_.cell(name, model, std::string(info.name));
    Forecasts& forecasts = forecasts_[{kind_of(name), std::string(info.name)}];
    if (experiment_.report().has(cell)) return recall(cell, forecasts);
    if (const auto reason = info.objection(model)) {
      experiment_.progress().say(fmt::format("{} {}: {}", name, info.name, *reason));
      return refuse(cell, "time", std::numeric_limits<double>::quiet_NaN(), "s");
    }
    const double bytes = forecasts.bytes.at(model.bodies()), room = memory_share_ * double(available_bytes());
    if (bytes > room) return refuse(cell, "memory_forecast", bytes, "B");
    const double once = forecasts.seconds.at(model.bodies());
    const int repetitions = once < slowest_repeated ? experiment_.options().repetitions : 1;
    const double seconds = once * (phases * repetitions + 2);
    if (seconds > time_limit_) return refuse(cell, "time_forecast", seconds, "s");

    Rank& rank = ranks_[kind_of(name)];
    if (!reference) reference = std::make_unique<Reference>(model, mechanism.state, rank.of(model));
    experiment_.report().write(cell, measured(info, mechanism, *reference, forecasts, rank, repetitions));
  }

  std::vector<Measurement> measured(const FormulationInfo& info, const Mechanism& mechanism, const Reference& reference,
                                    Forecasts& forecasts, Rank& rank, int repetitions) {
    PhaseTimer timer(info.create_double, mechanism.model, mechanism.state, rank.of(mechanism.model));
    rank.learn(mechanism.model, timer.outcome());
    const std::string status(to_string(timer.outcome().status));
    std::vector<Measurement> rows = {{"analyse", "time", timer.analyse_seconds(), "s", status},
                                     {"total", "memory", static_cast<double>(timer.bytes()), "B", status},
                                     {"total", "reference_refinement", reference.last_refinement(), "1"}};
    const auto append = [&](const std::vector<Measurement>& more) {
      rows.insert(rows.end(), more.begin(), more.end());
    };
    forecasts.bytes.add(mechanism.model.bodies(), static_cast<double>(timer.bytes()));
    append(reference.errors(timer.system(), timer.solution(), status));
    if (timer.outcome().usable()) {
      (void)timer.formulation().refine(timer.system(), timer.solution());
      append(reference.errors(timer.system(), timer.solution(), status, "_refined"));
      append(medians(timer, forecasts, mechanism.model.bodies(), repetitions));
    }
    return rows;
  }

  /// Times by phase: medians over the repetitions.
  std::vector<Measurement> medians(PhaseTimer& timer, Forecasts& forecasts, int bodies, int repetitions) {
    std::vector<Measurement> rows;
    std::vector<std::vector<double>> values;
    for (int r = 0; r < repetitions; ++r) {
      rows = timer.repetition();
      values.resize(rows.size());
      for (std::size_t k = 0; k < rows.size(); ++k) values[k].push_back(rows[k].value);
    }
    for (std::size_t k = 0; k < rows.size(); ++k) rows[k].value = median(values[k]);
    forecasts.seconds.add(bodies, rows.back().value);
    return rows;
  }

  /// A cell of the CSV that is continued, for the forecasts.
  void recall(const Cell& cell, Forecasts& forecasts) {
    for (const auto& [c, m] : experiment_.report().rows()) {
      if (c.model != cell.model || c.formulation != cell.formulation || m.phase != "total") continue;
      if (m.metric == "memory") forecasts.bytes.add(c.bodies, m.value);
      if (m.metric == "time" && std::isfinite(m.value)) forecasts.seconds.add(c.bodies, m.value);
    }
  }

  Experiment& experiment_;
  double time_limit_, memory_share_;
  std::map<std::pair<std::string, std::string>, Forecasts> forecasts_;
  std::map<std::string, Rank> ranks_;  // by kind of model
};

/// One line a cell: what one looks at first.
void print_table(std::FILE* out, const std::vector<Row>& rows) {
  fmt::print(out, "\n{:<16} {:<14} {:>13} {:>13} {:>12} {:>12} {:>12}\n", "model", "formulation", "µs a body",
             "bytes a body", "error of v'", "refined", "backward");
  std::map<std::string, double> values;
  const auto print = [&](const Cell& cell) {
    const auto text = [&](const char* metric, const char* format, double scale) {
      const auto found = values.find(metric);
      return found == values.end() ? std::string("-") : fmt::format(fmt::runtime(format), scale * found->second);
    };
    fmt::print(out, "{:<16} {:<14} {:>13} {:>13} {:>12} {:>12} {:>12}\n", cell.model, cell.formulation,
               text("time", "{:.3f}", 1e6 / cell.bodies), text("memory", "{:.0f}", 1.0 / cell.bodies),
               text("error_vdot", "{:.1e}", 1), text("error_vdot_refined", "{:.1e}", 1),
               text("backward_error_componentwise", "{:.1e}", 1));
  };
  const Cell* last = nullptr;
  for (const auto& [cell, m] : rows) {
    if (cell.formulation.empty()) continue;
    if (last && (last->model != cell.model || last->formulation != cell.formulation)) print(*last), values.clear();
    last = &cell;
    if ((m.phase == "total" || m.phase == "solve") && std::isfinite(m.value) &&
        !(m.phase == "solve" && m.metric == "time"))
      values[m.metric] = m.value;
  }
  if (last) print(*last);
}

}  // namespace

int main(int argc, char** argv) {
  Experiment experiment({.name = "scaling",
                         .question = "How do time, memory and errors grow with the number of bodies, up to a million?",
                         .repetitions = 3,
                         .quick_repetitions = 1,
                         .models = default_models});
  double time_limit = 0, memory_share = 0.6;
  experiment.option("--time-limit", time_limit, {0, std::numeric_limits<double>::infinity()},
                    "seconds a formulation may take on one model; 0: 60, or 0.5 with --quick");
  experiment.option("--memory-share", memory_share, {0, 1}, "of the memory now available that a formulation may take");
  return experiment.run(argc, argv, [&](Experiment& e) {
    Scaling(e, time_limit > 0 ? time_limit : e.options().quick ? 0.5 : 60, memory_share).run();
    e.progress().clear();
    const Cell machine{.model = "memory"};
    const double bandwidth = memory_bandwidth();
    if (!e.report().has(machine))
      e.report().write(machine, std::vector<Measurement>{{"", "bandwidth", bandwidth, "B/s"}});
    std::FILE* out = e.options().out == "-" ? stderr : stdout;
    print_table(out, e.report().rows());
    fmt::print(out, "\nOne core moves {:.0f} bytes between memory and registers in a microsecond.", 1e-6 * bandwidth);
    fmt::print(out, "\nMost memory the process held, models and references included: {:.2f} GB\n",
               1e-9 * static_cast<double>(peak_bytes()));
  });
}
