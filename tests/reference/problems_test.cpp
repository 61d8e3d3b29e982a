// Every numbered problem of the catalogue is there, and solved to its published accuracy by every family of
// formulations.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>

#include "lib/integrate/stepper.h"
#include "lib/io/mechanism.h"
#include "lib/report/comparison.h"
#include "lib/report/reference_problem.h"
#include "lib/report/sidecar.h"

namespace lanc::test {
namespace {

const std::string data = LANC_SOURCE_DIR "/data";

bool with_sundials() {
  const auto all = integrators();
  return std::any_of(all.begin(), all.end(), [](const auto& info) { return info.name == "erk8"; });
}

/// Every numbered problem that was set, and how many cases it has at least.
TEST(Problems, are_all_modelled_or_checked_by_a_test) {
  const std::map<std::string, int> expected = {
      {"1.1", 1},  // A01 pendulum
      {"1.2", 5},  // A02 N-four-bar, N = 1, 2, 5, 10, 40
      {"1.3", 1},  // A03 Andrews' squeezer
      {"1.4", 2},  // A04 Bricard, rods and prisms
      {"1.5", 1},  // A05 governor
      {"1.7", 1},  // four-bar with a spring
      {"2.1", 1},  // Andrews, Test Set
      {"2.2", 1},  // car axis
      {"2.4", 1},  // slider-crank
      {"4.1", 1},  // Puma 560
      {"4.2", 1},  // RBDL
      {"4.5", 1},  // SymPy
      {"4.6", 7},  // ADAMS: revolute, spherical, universal, prismatic, cylindrical, distance, spring
      {"5", 7},    // linkages
      {"5.2", 2},  // parallel robots
      {"5.3", 1}   // uniqueness of reactions
  };
  std::map<std::string, int> there;
  for (const ReferenceProblem& problem : read_reference_problems(data)) {
    ++there[problem.number];
    for (const std::string& test : problem.tests) {
      bool found = false;
      for (const auto& entry : std::filesystem::recursive_directory_iterator(LANC_SOURCE_DIR "/tests"))
        found = found || entry.path().filename() == test + ".cpp";
      EXPECT_TRUE(found) << problem.name << ": there is no " << test;
    }
  }
  for (const auto& [number, cases] : expected) EXPECT_GE(there[number], cases) << number;
}

TEST(Problems, bring_twenty_points_of_every_published_curve) {
  for (const ReferenceProblem& problem : read_reference_problems(data)) {
    if (problem.model.empty() || problem.end == 0) continue;
    std::set<double> times;
    for (const ReferenceValue& v : problem.values) times.insert(v.t);
    // published at the end of the motion only
    const bool curve = problem.number != "2.1" && problem.number != "2.2";
    EXPECT_GE(times.size(), curve ? 20u : 2u) << problem.name;
    for (const ReferenceValue& v : problem.values) {
      EXPECT_GT(v.tolerance, 0) << problem.name << " " << v.quantity;
      EXPECT_TRUE(v.origin == "published" || v.origin == "recomputed") << problem.name;
    }
  }
}

TEST(Problems, have_no_check_that_is_skipped) {
  std::ifstream file(data + "/reference/skipped.txt");
  ASSERT_TRUE(file) << "data/reference/skipped.txt lists the checks that are skipped, one a line";
  for (std::string line; std::getline(file, line);)
    if (!line.empty() && line[0] != '#') ADD_FAILURE() << "skipped: " << line;
}

class Solved : public ::testing::TestWithParam<std::string> {};

/// One formulation of each family; a family passes where one of its formulations does, or objects with a reason.
TEST_P(Solved, to_its_accuracy_by_every_family) {
  if (!with_sundials()) GTEST_SKIP() << "built without SUNDIALS";
  const auto all = read_reference_problems(data);
  const auto problem =
      std::find_if(all.begin(), all.end(), [](const ReferenceProblem& p) { return p.reference == GetParam(); });
  ASSERT_NE(problem, all.end());
  const Mechanism mechanism = load_mechanism(problem->model);
  if (problem->end == 0) {
    const Comparison c = compare_rest(*problem, mechanism);
    EXPECT_TRUE(c.passed()) << c.outcome.message << " " << c.worst_quantity << " " << c.worst;
    return;
  }
  // the optimised build runs all of it
  const bool sanitized = build_info().sanitized;
  if (sanitized && mechanism.model.nv() > 15) GTEST_SKIP() << "too long under sanitizers";
  const std::map<std::string, std::vector<const char*>> families = {{"recursive", {"recursive"}},
                                                                    {"dense", {"dense"}},
                                                                    {"eq14", {"eq14-klu"}},
                                                                    {"partitioning", {"partitioning"}},
                                                                    {"null space", {"nullspace"}}};
  for (const auto& [family, names] : families)
    for (const char* name : names) {
      if (sanitized && family != "recursive") continue;
      const FormulationInfo* info = find_formulation(name);
      ASSERT_NE(info, nullptr) << name;
      const Way way{info, "erk8", mechanism.model.has_closures() ? "minimal" : "none"};
      const Comparison c = compare(*problem, mechanism, way.options(1e-12, 0));
      EXPECT_TRUE(c.outcome.usable()) << family << ": " << c.outcome.message;
      EXPECT_LE(c.worst, 1) << family << ": " << c.worst_quantity << " at t = " << c.worst_t;
      EXPECT_GT(c.values, 0);
    }
}

std::vector<std::string> with_models() {
  std::vector<std::string> names;
  for (const ReferenceProblem& problem : read_reference_problems(data))
    if (!problem.model.empty()) names.push_back(problem.reference);
  return names;
}

INSTANTIATE_TEST_SUITE_P(Problem, Solved, ::testing::ValuesIn(with_models()), [](const auto& info) {
  std::string name = info.param.substr(0, info.param.find('.'));
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
});

}  // namespace
}  // namespace lanc::test
