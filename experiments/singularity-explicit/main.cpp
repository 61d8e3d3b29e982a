// How far does one independent coordinate go, and does changing it in time go all the way round?
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "experiments/singularity-explicit/four_bar_geometry.h"
#include "lib/closure/branch_map.h"
#include "lib/closure/explicit_walk.h"
#include "lib/io/four_bars.h"
#include "lib/model/error.h"
#include "lib/report/experiment.h"
#include "lib/report/table.h"
#include "lib/system/evaluator.h"

namespace {

using namespace lanc;

const double pi = std::acos(-1.0);
constexpr FourBarLengths of_the_lecture = {5, 3, 5, 5};
constexpr const char* names[] = {"beta1", "beta2", "beta3"};

double degrees(double angle) { return angle * 180 / pi; }

struct Options {
  FourBarLengths lengths = of_the_lecture;
  double step = 0;  // °
  double leave = 20, gain = 4;
};

/// What the slide prints for an extreme point of its four-bar, in degrees.
struct Printed {
  int coordinate;
  const char* in_line;
  double beta1, beta3;
};
constexpr Printed printed[] = {{0, "coupler+rocker", -16.26, 36.87},
                               {0, "coupler-rocker", 66.92, 78.47},
                               {2, "crank+coupler", 53.13, std::numeric_limits<double>::quiet_NaN()},
                               {2, "crank-coupler", 11.53, 23.08}};

class SingularityExplicit {
 public:
  SingularityExplicit(Experiment& experiment, const Options& options)
      : experiment_(experiment),
        options_(options),
        step_((options.step > 0             ? options.step
               : experiment.options().quick ? 2
                                            : 0.5) *
              pi / 180),
        model_(planar_four_bar(options.lengths.a, options.lengths.b, options.lengths.c, options.lengths.d)),
        start_(some_closed_position(options.lengths)),
        out_(experiment.options().out == "-" ? stderr : stdout) {
    const FourBarLengths& l = options.lengths;
    name_ = fmt::format("planar four-bar {}:{}:{}:{}", l.a, l.b, l.c, l.d);
  }

  void run() {
    const BranchTracer tracer(model_, start_, 2);
    curve(tracer);
    fmt::print(out_, "\nWalks in the independent coordinate, β^d by Newton (eq. 19):\n\n");
    for (const std::vector<int>& candidates : {std::vector<int>{0, 2}, {}, {0}, {2}})
      walk(candidates, tracer.here().tangent);
    fmt::print(out_, "{}", summary_.text());
    fmt::print(out_, "\nChanges of the independent coordinate (left above a condition of {}):\n\n{}", options_.leave,
               changes_.empty() ? "  none\n" : changes_.text());
  }

 private:
  void write(const std::string& parameters, const std::vector<Measurement>& measurements) {
    Cell cell = experiment_.cell(name_, model_, {}, parameters);
    cell.seed.reset();
    if (!experiment_.report().has(cell)) experiment_.report().write(cell, measurements);
  }

  static std::vector<Measurement> position(double arc, const std::vector<double>& q) {
    std::vector<Measurement> rows = {{"", "arc", arc, "rad"}};
    for (int k = 0; k < 3; ++k) rows.push_back({"", names[k], q[k], "rad"});
    return rows;
  }

  /// Of G^d for a choice that is kept whatever it is.
  double condition(const State<double>& state, int independent) {
    ExplicitClosures closures(model_, {.candidates = {}, .leave = std::numeric_limits<double>::infinity()});
    closures.choose({independent});
    Evaluator<double> evaluator(model_);
    ClosureRank<double> rank(model_);
    const System<double>& system = evaluator.system(state);
    return closures.at(system, rank.decide(system)).condition;
  }

  /// All admissible positions by arc length, and the extreme points of β1 and β3 on the way.
  void curve(const BranchTracer& tracer) {
    std::vector<std::pair<int, BranchPoint>> extremes;
    const Branch branch = follow_round(tracer, step_, 100000, [&](const BranchTracer& here, double h) {
      for (const int k : {0, 2})
        if (auto found = here.locate(h, [k](const BranchPoint& p) { return p.tangent[k]; }))
          extremes.emplace_back(k, *std::move(found));
    });
    Evaluator<double> evaluator(model_);
    double smallest = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < branch.points.size(); ++i) {
      const BranchPoint& point = branch.points[i];
      const ClosureDecomposition svd = decompose_closures(evaluator.system(point.state));
      smallest = std::min(smallest, svd.sigma_at(2));
      const std::string parameters = fmt::format("curve=motion;point={}", i);
      auto rows = position(point.arc, point.state.q);
      for (const int k : {1, 2}) rows.push_back({"", fmt::format("sigma{}", k), svd.sigma_at(k), "1"});
      write(parameters, rows);
      for (int k = 0; k < 3; ++k)
        write(fmt::format("{};independent={}", parameters, names[k]),
              {{"", "condition", condition(point.state, k), "1"}});
    }
    fmt::print(out_, "\n{}: {} points by arc length, {}, {:.6f} rad long.\n", name_, branch.points.size(),
               branch.closed ? "all the way round" : "not closed", branch.points.back().arc);
    fmt::print(out_, "Rank of G: {} (smallest σ2 {:.4f}).\n",
               smallest > clear_singular_value ? "2 everywhere" : "drops", smallest);
    fmt::print(out_, "Extreme points of β1 and β3, where that one fails as independent coordinate:\n\n");
    table_of(extremes);
  }

  void table_of(const std::vector<std::pair<int, BranchPoint>>& extremes) {
    const bool lecture = options_.lengths.a == of_the_lecture.a && options_.lengths.b == of_the_lecture.b &&
                         options_.lengths.c == of_the_lecture.c && options_.lengths.d == of_the_lecture.d;
    TextTable table({"fails", "links in line", "β1 [°]", "β3 [°]", "slide β1", "slide β3", "error [rad]",
                     "cond, q = β1", "q = β2", "q = β3"},
                    2);
    for (const auto& [k, point] : extremes) {
      const std::vector<double>& q = point.state.q;
      const auto exact = nearest_extreme(options_.lengths, k, q[0], q[2]);
      if (!exact) continue;
      const double error = std::max(std::abs(std::remainder(q[0] - exact->beta1, 2 * pi)),
                                    std::abs(std::remainder(q[2] - exact->beta3, 2 * pi)));
      const std::string parameters = fmt::format("extreme={};in_line={}", names[k], exact->in_line);
      auto rows = position(point.arc, q);
      rows.insert(rows.end(), {{"", "beta1_exact", exact->beta1, "rad"},
                               {"", "beta3_exact", exact->beta3, "rad"},
                               {"", "error", error, "rad"}});
      std::string slide[2] = {"-", "-"};
      for (const Printed& p : printed)
        if (lecture && p.coordinate == k && p.in_line == exact->in_line) {
          slide[0] = fmt::format("{:.2f}", p.beta1);
          if (std::isfinite(p.beta3)) slide[1] = fmt::format("{:.2f}", p.beta3);
          rows.push_back({"", "beta1_printed", p.beta1 * pi / 180, "rad"});
          if (std::isfinite(p.beta3)) rows.push_back({"", "beta3_printed", p.beta3 * pi / 180, "rad"});
        }
      write(parameters, rows);
      std::vector<std::string> line = {fmt::format("β{}", k + 1),
                                       exact->in_line,
                                       fmt::format("{:.9f}", degrees(std::remainder(q[0], 2 * pi))),
                                       fmt::format("{:.9f}", degrees(std::remainder(q[2], 2 * pi))),
                                       slide[0],
                                       slide[1],
                                       fmt::format("{:.1e}", error)};
      for (int j = 0; j < 3; ++j) {
        const double value = condition(point.state, j);
        line.push_back(fmt::format("{:.3g}", value));
        write(fmt::format("{};independent={}", parameters, names[j]),
              {{"", "arc", point.arc, "rad"}, {"", "condition", value, "1"}});
      }
      table.row(line);
    }
    fmt::print(out_, "{}", table.text());
  }

  /// A walk from the start until it comes round, or no choice carries on.
  void walk(const std::vector<int>& candidates, const Eigen::VectorXd& towards) {
    std::string label;
    for (const int k : candidates) label += (label.empty() ? "" : "+") + std::string(names[k]);
    if (label.empty()) label = "all";
    ExplicitWalk walk(model_, start_, {.candidates = candidates, .leave = options_.leave, .gain = options_.gain},
                      towards);
    const auto tell = [&](int point) {
      auto rows = position(walk.arc(), walk.here().q);
      rows.push_back({"", "condition", walk.conditions().condition, "1"});
      write(fmt::format("walk={};point={};independent={}", label, point, names[walk.independent()]), rows);
    };
    const Eigen::VectorXd direction = walk.tangent();
    const auto from_start = [&] {
      Eigen::VectorXd way(3);
      for (int k = 0; k < 3; ++k) way[k] = std::remainder(walk.here().q[k] - start_.q[k], 2 * pi);
      return way;
    };
    constexpr int most = 100000;
    const std::string first = names[walk.independent()];
    double worst = walk.conditions().condition, last = 0;
    bool round = false, goes_on = true;
    int point = 0;
    tell(point);
    while (!round && goes_on && point < most) {
      // near a limit point steps become ever smaller; below 1e-9 rad the walk has come to its end
      const double before = walk.arc();
      goes_on = walk.advance(step_) && walk.arc() - before > 1e-9;
      if (!goes_on) break;
      tell(++point);
      worst = std::max(worst, walk.conditions().condition);
      const Eigen::VectorXd way = from_start();
      const double ahead = way.dot(direction);
      round = point > 3 && way.norm() < 2 * step_ && last < 0 && ahead >= 0;
      last = way.norm() < 2 * step_ ? ahead : 0;
    }
    const std::string status(to_string(round ? Status::solved : Status::singular));
    write("walk=" + label, {{"", "arc", walk.arc(), "rad", status},
                            {"", "steps", double(point), "1", status},
                            {"", "changes", double(walk.changes().size()), "1", status},
                            {"", "worst_condition", worst, "1", status}});
    summary_.row({label, first, round ? "round" : fmt::format("ends at a limit point of {}", names[walk.independent()]),
                  std::to_string(point), fmt::format("{:.4f}", walk.arc()),
                  fmt::format("{:.4f}", degrees(walk.here().q[0])), fmt::format("{:.4f}", degrees(walk.here().q[2])),
                  std::to_string(walk.changes().size()), fmt::format("{:.3g}", worst)});
    log(label, walk);
  }

  void log(const std::string& label, const ExplicitWalk& walk) {
    for (std::size_t i = 0; i < walk.changes().size(); ++i) {
      const auto& [arc, state, change] = walk.changes()[i];
      const char *before = names[change.before[0]], *after = names[change.after[0]];
      auto rows = position(arc, state.q);
      rows.push_back({"", "condition_before", change.condition_before, "1"});
      rows.push_back({"", "condition_after", change.condition_after, "1"});
      write(fmt::format("walk={};change={};before={};after={}", label, i + 1, before, after), rows);
      changes_.row({label, fmt::format("{:.4f}", arc), fmt::format("{:.4f}", degrees(state.q[0])),
                    fmt::format("{:.4f}", degrees(state.q[2])), before, after,
                    fmt::format("{:.3g}", change.condition_before), fmt::format("{:.3g}", change.condition_after)});
    }
  }

  Experiment& experiment_;
  Options options_;
  double step_;
  Model model_;
  State<double> start_;
  std::FILE* out_;
  std::string name_;
  TextTable summary_{
      {"candidates", "starts with", "result", "steps", "arc [rad]", "β1 [°]", "β3 [°]", "changes", "worst condition"},
      3};
  TextTable changes_{{"candidates", "arc [rad]", "β1 [°]", "β3 [°]", "from", "to", "condition before", "after"}};
};

}  // namespace

int main(int argc, char** argv) {
  Experiment experiment(
      {.name = "singularity-explicit",
       .question = "How far does one independent coordinate go, and does changing it in time go all the way round?",
       .repetitions = 1,
       .quick_repetitions = 1,
       .models = [](bool) { return std::vector<std::string>{"planar four-bar"}; }});
  Options options;
  constexpr Range lengths = {1e-3, 1e3};
  experiment.option("--crank", options.lengths.a, lengths, "length of the crank (β1), m");
  experiment.option("--coupler", options.lengths.b, lengths, "of the coupler (β2, on the crank), m");
  experiment.option("--rocker", options.lengths.c, lengths, "of the rocker (β3), m");
  experiment.option("--ground", options.lengths.d, lengths, "between the pivots of crank and rocker, m");
  experiment.option("--step", options.step, {0, 10}, "of arc length, degrees; 0: 0.5, or 2 with --quick");
  experiment.option("--leave", options.leave, {1, 1e12}, "condition of G^d above which a choice is left");
  experiment.option("--gain", options.gain, {1, 1e6}, "factor by which the new choice must be better");
  return experiment.run(argc, argv, [&](Experiment& e) {
    if (!e.options().models.empty())
      throw InputError("the mechanism is a planar four-bar; --crank, --coupler, --rocker and --ground give it");
    SingularityExplicit(e, options).run();
  });
}
