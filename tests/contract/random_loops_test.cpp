// 500 random closed mechanisms: the figure of the specification.
//
// Agreement as on trees (random_trees_test.cpp): largest difference of η̇ and â relative to the largest of the
// reference or of what it balances, in m/s²; of f̂ and λ in the components that no self-stress changes. The reference
// is a singular value decomposition in long double that shares nothing with lib/closure.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

#include "lib/closure/mobility.h"
#include "lib/formulation/formulation.h"
#include "lib/io/mechanism.h"
#include "lib/system/evaluator.h"
#include "tests/support/closed_reference.h"
#include "tests/support/effort.h"
#include "tests/support/tolerance.h"

namespace lanc::test {
namespace {

constexpr int random_loops = 500, most_loops = 12;
constexpr double required_on_loops = 1e-8, largest_condition = 1e6;

struct LoopScore {
  int possible = 0, solved = 0;
  double vdot = 0, acceleration = 0, reaction = 0;
  std::string worst;
};

TEST(RandomLoops, all_formulations_agree_on_500_random_closed_mechanisms_to_1e_8) {
  const char* causes[] = {"any", "parallel", "bennett", "none", "any", "duplicate", "any"};
  std::map<std::string, int> histogram;
  std::map<std::string, LoopScore> scores;
  int rejected = 0, duplicates = 0;
  for (int accepted = 0, seed = 1; accepted < cases(random_loops); ++seed) {
    ASSERT_LT(rejected, random_loops) << "too many are ill-conditioned";
    const int loops = 1 + seed % most_loops;
    const std::string name =
        "random-loops:" + std::to_string(loops) + ":seed=" + std::to_string(seed) + ":redundant=" + causes[seed % 7];
    const Mechanism m = load_mechanism(name);
    Evaluator<long double> wide_evaluator(m.model);
    const System<long double>& wide = wide_evaluator.system(cast<long double>(m.state));
    const ClosedReference reference = solve_closed_naively(wide);
    if (!(reference.schur_condition < largest_condition)) {
      ++rejected;
      continue;
    }
    ++accepted;
    std::map<std::string, bool> here;
    for (const JointSpec& joint : m.model.spec().joints) {
      here["joint " + std::string(joint.kind.traits().name)] = true;
      if (joint.motion) here["rheonomic joint"] = true;
    }
    for (const ClosureSpec& closure : m.model.spec().closures) {
      here["cut " + std::string(closure.kind.traits().name)] = true;
      if (closure.motion) here["rheonomic loop"] = true;
      if (closure.name.rfind("d_", 0) == 0) here["cause duplicated rows"] = true;
    }
    if (here["cause duplicated rows"]) ++duplicates;
    if (std::string(causes[seed % 7]) == "parallel") here["cause parallel axes"] = true;
    if (std::string(causes[seed % 7]) == "bennett") here["cause Bennett"] = true;
    for (const auto& [what, is] : here) histogram[what] += is;

    const Mobility mobility = analyse_mobility(m.model, m.state);
    EXPECT_EQ(mobility.rank, reference.rank) << name;
    EXPECT_EQ(mobility.unique, reference.unique) << name;
    const Norms size = sizes(wide, reference.solution);
    Evaluator<double> evaluator(m.model);
    const System<double>& system = evaluator.system(m.state);
    for (const FormulationInfo& info : formulations()) {
      LoopScore& score = scores[std::string(info.name)];
      if (!info.create_double || info.objection(m.model)) continue;
      ++score.possible;
      Solution<double> solution(m.model);
      const Outcome outcome = info.create_double(m.model)->solve(system, solution);
      const Status expected = reference.rank < m.model.closures().rows() ? Status::redundant : Status::solved;
      if (outcome.status != expected) {
        std::printf("  %s on %s: %s: %s\n", info.name.data(), name.c_str(), to_string(outcome.status).data(),
                    outcome.message.c_str());
        EXPECT_FALSE(outcome.usable()) << info.name << " on " << name << ": " << to_string(outcome.status);
        continue;
      }
      ++score.solved;
      const Norms e = relative(difference(m.model, solution, reference.solution), size);
      const double reaction = reaction_error(reference, solution, m.model) / size.wrench;
      if (std::max({e.vdot, e.acceleration, reaction}) > std::max({score.vdot, score.acceleration, score.reaction}))
        score.worst = name;
      score.vdot = std::max(score.vdot, e.vdot), score.acceleration = std::max(score.acceleration, e.acceleration);
      score.reaction = std::max(score.reaction, reaction);
      EXPECT_TRUE(within_relative(std::string(info.name) + " on " + name, std::max(e.vdot, e.acceleration),
                                  required_on_loops, 1));
      EXPECT_TRUE(
          within_relative(std::string(info.name) + " on " + name + ": reactions", reaction, required_on_loops, 1));
    }
  }
  std::printf("%d mechanisms, %d rejected for their condition; each feature occurs in\n", cases(random_loops),
              rejected);
  for (const auto& [what, count] : histogram) {
    std::printf("  %5d  %s\n", count, what.c_str());
    EXPECT_GE(count, cases(30)) << what << " is too rare to be tested";
  }
  EXPECT_LE(5 * duplicates, random_loops) << "too many duplicates";
  std::printf("%-16s %8s %8s   worst relative error of vdot, acceleration, unique reactions\n", "formulation", "solved",
              "possible");
  for (const auto& [name, s] : scores)
    std::printf("%-16s %8d %8d   %.1e %.1e %.1e (%s)\n", name.c_str(), s.solved, s.possible, s.vdot, s.acceleration,
                s.reaction, s.worst.c_str());
}

}  // namespace
}  // namespace lanc::test
