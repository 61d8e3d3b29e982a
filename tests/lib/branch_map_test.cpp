// Branches followed all the way round, and all that cross one another.
#include "lib/closure/branch_map.h"

#include <gtest/gtest.h>

#include <numbers>

#include "lib/io/four_bars.h"
#include "tests/support/loop_cases.h"

namespace lanc::test {
namespace {

using std::numbers::pi;

TEST(BranchMap, the_double_rocker_has_one_closed_branch) {
  const Model model = planar_four_bar(5, 3, 5, 5);
  const State<double> start = at_rest({std::asin(0.8), 0, 2 * std::asin(0.8)});  // crank and coupler in line
  const BranchMap map = map_branches(model, start, 2, 0.05);
  ASSERT_EQ(map.branches.size(), 1U);
  EXPECT_TRUE(map.branches[0].closed);
  EXPECT_TRUE(map.crossings.empty());
  const std::vector<BranchPoint>& points = map.branches[0].points;
  for (const int k : {0, 2}) EXPECT_NEAR(points.front().state.q[k], points.back().state.q[k], 1e-12);
  EXPECT_NEAR(std::abs(points.back().state.q[1] - points.front().state.q[1]), 2 * pi, 1e-12)
      << "the coupler turns once against the crank";
  // the same curve, however long the steps are
  const double arc = follow_round(BranchTracer(model, start, 2), 0.02).points.back().arc;
  EXPECT_NEAR(points.back().arc, arc, 0.01 * arc);
}

TEST(BranchMap, parallelogram_and_rhombus_are_explored_through_all_their_crossings) {
  for (const bool hinge : {false, true}) {
    struct Case {
      double ground;
      std::size_t branches, crossings;
    };
    for (const Case& c : {Case{2, 2, 2}, Case{0.6, 2, 2}, Case{1, 3, 3}}) {
      const Model model = planar_four_bar(1, c.ground, 1, c.ground, hinge);
      const BranchMap map = map_branches(model, at_rest({0.1, pi / 2 - 0.1, pi / 2 + 0.1}), 2, 0.05);
      EXPECT_EQ(map.branches.size(), c.branches) << c.ground;
      EXPECT_EQ(map.crossings.size(), c.crossings) << c.ground;
      for (const Branch& branch : map.branches) EXPECT_TRUE(branch.closed) << c.ground;
      for (const SingularPoint& crossing : map.crossings) EXPECT_EQ(crossing.decomposition.rank, 1);
    }
  }
}

TEST(BranchMap, what_cannot_be_done_in_the_steps_allowed_stays_open) {
  const Model model = planar_four_bar(5, 3, 5, 5);
  const State<double> start = at_rest({std::asin(0.8), 0, 2 * std::asin(0.8)});
  const Branch branch = follow_round(BranchTracer(model, start, 2), 0.02, 30);
  EXPECT_FALSE(branch.closed);
  EXPECT_EQ(branch.points.size(), 31U);
}

}  // namespace
}  // namespace lanc::test
