// Where do the branches of a parallelogram cross, and what do rank, redundancy and tangents say there?
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "experiments/singularity-implicit/parallelogram.h"
#include "lib/closure/branch_map.h"
#include "lib/closure/explicit.h"
#include "lib/closure/mobility.h"
#include "lib/io/four_bars.h"
#include "lib/model/error.h"
#include "lib/report/experiment.h"
#include "lib/report/table.h"
#include "lib/system/evaluator.h"

namespace {

using namespace lanc;

const double pi = std::acos(-1.0);
constexpr const char* names[] = {"beta1", "beta2", "beta3"};

double degrees(double angle) { return angle * 180 / pi; }
double positive_degrees(double angle) { return std::remainder(degrees(angle) - 180, 360) + 180; }

double largest_turn(const std::vector<double>& q, const Position& position) {
  double largest = 0;
  for (int k = 0; k < 3; ++k) largest = std::max(largest, std::abs(std::remainder(q[k] - position[k], 2 * pi)));
  return largest;
}

std::string direction(Eigen::Vector3d v) {
  for (double& x : v)
    if (std::abs(x) < 5e-7) x = 0;  // no "-0.000000"
  return fmt::format("{:.6f} : {:.6f} : {:.6f}", v[0], v[1], v[2]);
}

class SingularityImplicit {
 public:
  SingularityImplicit(Experiment& experiment, double step)
      : experiment_(experiment),
        step_((step > 0                     ? step
               : experiment.options().quick ? 4
                                            : 1) *
              pi / 180) {}

  void parallelogram(double a, double d, bool hinge) {
    const Model model = planar_four_bar(a, d, a, d, hinge);
    const std::string name = fmt::format("four-bar {0}:{1}:{0}:{1} {2}-cut", a, d, hinge ? "hinge" : "point");
    experiment_.progress().advance(0, name);
    const double beta1 = 0.1;
    const State<double> start{0, {beta1, pi / 2 - beta1, beta1 + pi / 2}, {0, 0, 0}};
    const BranchMap map = map_branches(model, start, 2, step_);
    write_mobility(name, model, "position=regular", "regular", start, 0);
    for (const Branch& branch : map.branches) tell_branch(name, model, branch);
    for (const SingularPoint& crossing : map.crossings) tell_crossing(name, model, a, d, crossing);
    for (const Branch& branch : map.branches) {
      if (name_of(branch) == "antiparallel") values(name, model, a, d, branch);
      for (const SingularPoint& crossing : map.crossings)
        places(name, model, branch, crossing, closed_form(a, d, crossing));
    }
    experiment_.progress().advance(1, name);
  }

  void print() const {
    std::FILE* out = experiment_.options().out == "-" ? stderr : stdout;
    fmt::print(out, "\nBranches, by arc length through all crossings:\n\n{}", branches_.text());
    fmt::print(out, "\nRank of G (σ2 of the scaled G), and what follows from it; errors against the closed form:\n\n{}",
               ranks_.text());
    fmt::print(out, "\nTangents η1 : η2 : η3 where branches cross, by second-order analysis:\n\n{}", tangents_.text());
    if (!values_.empty()) fmt::print(out, "\nOn the antiparallel branch:\n\n{}", values_.text());
  }

 private:
  static std::string name_of(const Branch& branch) {
    std::vector<std::vector<double>> positions;
    for (const BranchPoint& p : branch.points) positions.push_back(p.state.q);
    return branch_name(positions);
  }

  void write(const std::string& name, const Model& model, const std::string& parameters,
             const std::vector<Measurement>& measurements) {
    Cell cell = experiment_.cell(name, model, {}, parameters);
    cell.seed.reset();
    if (!experiment_.report().has(cell)) experiment_.report().write(cell, measurements);
  }

  /// Which of crossings(a, d) this is.
  static std::size_t closed_form(double a, double d, const SingularPoint& found) {
    const std::vector<Crossing> all = crossings(a, d);
    std::size_t best = 0;
    for (std::size_t k = 1; k < all.size(); ++k)
      if (largest_turn(found.state.q, all[k].position) < largest_turn(found.state.q, all[best].position)) best = k;
    return best;
  }

  void tell_branch(const std::string& name, const Model& model, const Branch& branch) {
    Evaluator<double> evaluator(model);
    const std::string label = name_of(branch);
    for (std::size_t i = 0; i < branch.points.size(); ++i) {
      const BranchPoint& point = branch.points[i];
      const ClosureDecomposition svd = decompose_closures(evaluator.system(point.state));
      std::vector<Measurement> rows = {{"", "arc", point.arc, "rad"}};
      for (int k = 0; k < 3; ++k) rows.push_back({"", names[k], point.state.q[k], "rad"});
      for (const int k : {1, 2}) rows.push_back({"", fmt::format("sigma{}", k), svd.sigma_at(k), "1"});
      write(name, model, fmt::format("branch={};point={}", label, i), rows);
    }
    branches_.row({name, label, std::to_string(branch.points.size()), branch.closed ? "all the way round" : "open",
                   fmt::format("{:.6f}", branch.points.back().arc)});
  }

  /// Arc lengths at which a branch goes through a crossing: σ2 has a sign, and changes it there.
  void places(const std::string& name, const Model& model, const Branch& branch, const SingularPoint& crossing,
              std::size_t index) {
    const Eigen::Map<const Position> position(crossing.state.q.data());
    for (std::size_t i = 0; i + 1 < branch.points.size(); ++i) {
      const BranchPoint &left = branch.points[i], &right = branch.points[i + 1];
      if (left.sigma * right.sigma > 0 || largest_turn(left.state.q, position) > 2 * step_) continue;
      const double arc = left.arc + (right.arc - left.arc) * left.sigma / (left.sigma - right.sigma);
      write(name, model, fmt::format("crossing={};branch={}", index + 1, name_of(branch)),
            {{"", "arc", arc, "rad"}, {"", "sigma2", crossing.decomposition.sigma_at(2), "1"}});
    }
  }

  void write_mobility(const std::string& name, const Model& model, const std::string& parameters,
                      const std::string& where, const State<double>& state, double error) {
    const Mobility m = analyse_mobility(model, state);
    const ClosureDecomposition svd = decompose_closures(Evaluator<double>(model).system(state));
    std::vector<Measurement> rows;
    for (int k = 0; k < 3; ++k) rows.push_back({"", names[k], state.q[k], "rad"});
    rows.insert(rows.end(), {{"", "error", error, "rad"},
                             {"", "rank", double(m.rank), "1"},
                             {"", "generic_rank", double(m.generic_rank), "1"},
                             {"", "redundant", double(m.redundant()), "1"},
                             {"", "mobility", double(m.mobility), "1"},
                             {"", "finite_mobility", double(m.finite_mobility), "1"},
                             {"", "sigma2", svd.sigma_at(2), "1"}});
    const std::string verdict(to_string(m.verdict));
    write(name, model, parameters + ";verdict=" + verdict, rows);
    ranks_.row({name, where, verdict, fmt::format("{:.9f}", degrees(state.q[0])),
                fmt::format("{:.9f}", positive_degrees(state.q[2])), fmt::format("{:.0e}", error),
                fmt::format("{:.0e}", svd.sigma_at(2)), std::to_string(m.closure_rows), std::to_string(m.rank),
                std::to_string(m.redundant()), std::to_string(m.mobility)});
  }

  void tell_crossing(const std::string& name, const Model& model, double a, double d, const SingularPoint& found) {
    const std::size_t index = closed_form(a, d, found), number = index + 1;
    const Crossing exact = crossings(a, d)[index];
    State<double> state = found.state;
    for (double& angle : state.q) angle = std::remainder(angle, 2 * pi);
    write_mobility(name, model, fmt::format("crossing={}", number), fmt::format("crossing {}", number), state,
                   largest_turn(state.q, exact.position));
    for (const auto& [branch, closed_form] : exact.tangents) {
      Eigen::Vector3d tangent = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
      double error = std::numeric_limits<double>::infinity();
      for (const Eigen::VectorXd& t : found.tangents)
        for (const double sign : {1.0, -1.0})
          if ((sign * t - closed_form).norm() < error) tangent = sign * t, error = (tangent - closed_form).norm();
      std::vector<Measurement> rows;
      for (int k = 0; k < 3; ++k) rows.push_back({"", fmt::format("eta{}", k + 1), tangent[k], "1"});
      for (int k = 0; k < 3; ++k) rows.push_back({"", fmt::format("eta{}_exact", k + 1), closed_form[k], "1"});
      rows.push_back({"", "error", error, "1"});
      write(name, model, fmt::format("crossing={};tangent={}", number, branch), rows);
      tangents_.row({name, std::to_string(number), branch, direction(tangent), direction(closed_form),
                     fmt::format("{:.0e}", error)});
    }
  }

  /// β3 for given β1, by Newton from the nearest point of the branch.
  void values(const std::string& name, const Model& model, double a, double d, const Branch& branch) {
    for (const double asked : {0.0, 50.0, 100.0, 150.0}) {
      const double beta1 = asked * pi / 180;
      const auto gap = [&](const BranchPoint& p) { return std::abs(std::remainder(p.state.q[0] - beta1, 2 * pi)); };
      const auto nearest = std::min_element(branch.points.begin(), branch.points.end(),
                                            [&](const auto& x, const auto& y) { return gap(x) < gap(y); });
      State<double> guess = nearest->state;
      guess.q[0] = beta1;
      ExplicitConditions split;
      split.independent = {0}, split.dependent = {1, 2};
      const auto solved = solve_dependent(model, guess, split);
      if (!solved) continue;
      const double exact = antiparallel_beta3(a, d, beta1);
      const double error = std::abs(std::remainder(solved->q[2] - exact, 2 * pi));
      write(name, model, fmt::format("branch=antiparallel;beta1={}", asked),
            {{"", "beta3", solved->q[2], "rad"}, {"", "beta3_exact", exact, "rad"}, {"", "error", error, "rad"}});
      values_.row({name, fmt::format("{:.0f}", asked), fmt::format("{:.9f}", positive_degrees(solved->q[2])),
                   fmt::format("{:.2f}", positive_degrees(exact)), fmt::format("{:.0e}", error)});
    }
  }

  Experiment& experiment_;
  double step_;
  TextTable branches_{{"mechanism", "branch", "points", "came", "length [rad]"}, 2};
  TextTable ranks_{
      {"mechanism", "where", "verdict", "β1 [°]", "β3 [°]", "error", "σ2", "rows", "rank", "redundant", "mobility"}, 3};
  TextTable tangents_{{"mechanism", "crossing", "branch", "found", "closed form", "error"}, 3};
  TextTable values_{{"mechanism", "β1 [°]", "β3 [°]", "closed form", "error [rad]"}};
};

}  // namespace

int main(int argc, char** argv) {
  Experiment experiment(
      {.name = "singularity-implicit",
       .question =
           "Where do the branches of a parallelogram cross, and what do rank, redundancy and tangents say there?",
       .repetitions = 1,
       .quick_repetitions = 1,
       .models = [](bool) { return std::vector<std::string>{"planar four-bar"}; }});
  double crank = 1, ground = 2, step = 0;
  constexpr Range lengths = {1e-3, 1e3};
  experiment.option("--crank", crank, lengths, "length of crank and rocker, m");
  experiment.option("--ground", ground, lengths, "of coupler and ground, m");
  experiment.option("--step", step, {0, 10}, "of arc length, degrees; 0: 1, or 4 with --quick");
  return experiment.run(argc, argv, [&](Experiment& e) {
    if (!e.options().models.empty()) throw InputError("the mechanism is a parallelogram; --crank and --ground give it");
    e.progress().start(crank == ground ? 2 : 3);
    SingularityImplicit singularity(e, step);
    for (const bool hinge : {false, true}) singularity.parallelogram(crank, ground, hinge);
    if (crank != ground) singularity.parallelogram(crank, crank, false);  // the rhombus
    e.progress().clear();
    singularity.print();
  });
}
