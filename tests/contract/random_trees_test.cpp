// 1000 random trees: the figure of the specification.
//
// "Agree to 1e-9 relative" means, for each of η̇, â, f̂ and each formulation on each tree:
//   max |x − x_ref| <= 1e-9 max |x_ref|
// over all components of all bodies, after rotations are multiplied and moments divided by the model's length L
// (Model::length, the mean distance between joints), so that both parts are in m/s² or N (tests/support/naive.h).
// Where a reference vanishes against the loads it balances (a body at rest, the drive of a massless one), relative to
// those instead (`sizes` there).
// x_ref is the naive reduced system in long double, which shares no code with any formulation; on trees of up to 12
// bodies it is compared with eq. 14 solved densely with full pivoting.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

#include "lib/formulation/formulation.h"
#include "lib/system/evaluator.h"
#include "tests/support/effort.h"
#include "tests/support/naive.h"
#include "tests/support/tolerance.h"

namespace lanc::test {
namespace {

constexpr int trees = 1000;
constexpr int largest_tree = 60;
constexpr double required_on_trees = 1e-9;

/// In how many trees each feature occurs.
class Histogram {
 public:
  void add(const Model& model) {
    std::map<std::string, bool> here;
    std::vector<int> depth(model.bodies()), children(model.bodies(), 0);
    int deepest = 0, widest = 0;
    for (int i = 0; i < model.bodies(); ++i) {
      const Link& link = model.link(i);
      here["joint " + std::string(link.kind.traits().name)] = true;
      if (link.drive >= 0) here["rheonomic joint"] = true;
      if (link.inertia.mass == 0) here["massless body"] = true;
      if (link.inertia.mass == 0 && link.nv > 0) here["massless body with a freedom"] = true;
      depth[i] = link.parent == ground ? 1 : depth[link.parent] + 1;
      deepest = std::max(deepest, depth[i]);
      if (link.parent != ground) widest = std::max(widest, ++children[link.parent]);
    }
    here[deepest <= 5    ? "depth 1-5"
         : deepest <= 15 ? "depth 6-15"
         : deepest <= 30 ? "depth 16-30"
                         : "depth 31-60"] = true;
    here[widest <= 1   ? "branching: none"
         : widest == 2 ? "branching: two children"
         : widest == 3 ? "branching: three children"
                       : "branching: four or more"] = true;
    static constexpr const char* motions[] = {"constant speed", "polynomial", "sine", "spline", "formula"};
    for (const JointSpec& joint : model.spec().joints)
      if (joint.motion) here[std::string("motion ") + motions[joint.motion->index()]] = true;
    if (!model.springs().empty()) here["point spring"] = true;
    if (model.has_armature()) here["armature"] = true;
    if (!model.passive().empty()) here["joint spring, damper or friction"] = true;
    if (!model.wrenches().empty()) here["constant wrench"] = true;
    for (const auto& entry : here) ++count_[entry.first];
  }

  void print_and_check() const {
    for (const auto& entry : count_) {
      std::printf("  %5d  %s\n", entry.second, entry.first.c_str());
      EXPECT_GE(entry.second, 50) << entry.first << " is too rare to be tested";
    }
    EXPECT_EQ(
        std::count_if(count_.begin(), count_.end(), [](const auto& e) { return e.first.rfind("joint ", 0) == 0; }),
        joint_kinds + 1)  // and "joint spring, ..."
        << "a joint kind is missing";
  }

 private:
  std::map<std::string, int> count_;
};

Norms norms_or_loads(const System<long double>& system, const Solution<long double>& reference) {
  const Norms own = norms(system.model, reference), loads = sizes(system, reference);
  const auto pick = [](double x, double load) { return x > 1e-6 * load ? x : load; };
  return {pick(own.vdot, loads.vdot), pick(own.acceleration, loads.acceleration), pick(own.wrench, loads.wrench),
          pick(own.drive, loads.drive)};
}

struct TreeScore {
  int possible = 0, solved = 0;
  Norms worst;
  std::string worst_tree;
};

TEST(RandomTrees, all_formulations_without_objection_agree_on_1000_random_trees_to_1e_9) {
  Histogram histogram;
  std::map<std::string, TreeScore> scores;
  double worst_oracle = 0;
  for (int tree = 0; tree < cases(trees); ++tree) {
    const Case c = random_case(1000 + tree, 1 + tree % largest_tree);
    histogram.add(c.model);
    const System<long double> wide = system_in_long_double(c);
    const Solution<long double> reference = solve_reduced_naively(wide);
    const Norms size = norms_or_loads(wide, reference);
    if (c.model.bodies() <= 12) {
      const Solution<long double> eq14 = solve_eq14_naively(wide);
      worst_oracle = std::max(worst_oracle, relative(difference(c.model, eq14, reference), size).worst());
    }
    Evaluator<double> evaluator(c.model);
    const System<double>& system = evaluator.system(c.state, c.loads);
    for (const FormulationInfo& info : formulations()) {
      TreeScore& score = scores[std::string(info.name)];
      if (!info.create_double || info.objection(c.model)) continue;
      ++score.possible;
      const auto formulation = info.create_double(c.model);
      Solution<double> solution(c.model);
      const Outcome outcome = formulation->solve(system, solution);
      if (!outcome.usable()) {
        std::printf("  %s on %s: %s: %s\n", info.name.data(), c.name.c_str(), to_string(outcome.status).data(),
                    outcome.message.c_str());
        continue;
      }
      ++score.solved;
      const Norms e = relative(difference(c.model, solution, reference), size);
      if (!(e.worst() <= score.worst.worst())) score.worst_tree = c.name;
      score.worst.vdot = std::max(score.worst.vdot, e.vdot);
      score.worst.acceleration = std::max(score.worst.acceleration, e.acceleration);
      score.worst.wrench = std::max(score.worst.wrench, e.wrench);
      score.worst.drive = std::max(score.worst.drive, e.drive);
      EXPECT_TRUE(within_relative(std::string(info.name) + " on " + c.name, e.worst(), required_on_trees, 1));
    }
  }
  if (cases(trees) == trees) {
    std::printf("trees in which each feature occurs, of %d:\n", trees);
    histogram.print_and_check();
  }
  std::printf("the two oracles differ by at most %.1e\n", worst_oracle);
  EXPECT_LT(worst_oracle, 1e-3 * required_on_trees);
  std::printf("%-16s %8s %8s   worst relative error of vdot, acceleration, wrench, drive force\n", "formulation",
              "solved", "possible");
  for (const auto& entry : scores) {
    const TreeScore& s = entry.second;
    std::printf("%-16s %8d %8d   %.1e %.1e %.1e %.1e (%s)\n", entry.first.c_str(), s.solved, s.possible, s.worst.vdot,
                s.worst.acceleration, s.worst.wrench, s.worst.drive, s.worst_tree.c_str());
  }
}

}  // namespace
}  // namespace lanc::test
