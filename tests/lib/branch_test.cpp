// Motion curves of the lecture's two figures (theory, sections 2 and 3): limit points, crossings, changes of s.
#include "lib/closure/branch.h"

#include <gtest/gtest.h>

#include <numbers>

#include "lib/io/four_bars.h"
#include "tests/support/loop_cases.h"

namespace lanc::test {
namespace {

using std::numbers::pi;

/// The double rocker of figure 1 where coupler and rocker are in line (β1 at its minimum).
State<double> figure_1_start(const Model& model) {
  return at_rest(model, {pi / 2 - 2 * std::asin(0.8), pi - std::asin(0.6), std::asin(0.6)});
}

TEST(Branch, the_double_rocker_goes_round_its_oval_through_the_four_extreme_points) {
  const Model model = planar_four_bar(5, 3, 5, 5);
  BranchTracer tracer(model, figure_1_start(model), 2);
  struct Extreme {
    int coordinate;
    double beta1, beta3;
  };
  const Extreme expected[] = {{0, pi / 2 - 2 * std::asin(0.8), std::asin(0.6)},
                              {0, pi / 2 - 2 * std::asin(0.2), std::acos(0.2)},
                              {2, std::asin(0.8), 2 * std::asin(0.8)},
                              {2, std::asin(0.2), 2 * std::asin(0.2)}};
  std::vector<int> met(4, 0);
  tracer.advance(0.01);  // off the first extreme point, which is to be met at the end
  const Eigen::VectorXd start = Eigen::Map<const Eigen::VectorXd>(tracer.here().state.q.data(), 3);
  bool round = false;
  for (int step = 0; step < 2000 && !round; ++step) {
    const double h = 0.02;
    for (const int coordinate : {0, 2})
      if (const auto point = tracer.locate(h, [coordinate](const BranchPoint& p) { return p.tangent[coordinate]; }))
        for (int k = 0; k < 4; ++k)
          if (expected[k].coordinate == coordinate && std::abs(point->state.q[0] - expected[k].beta1) < 0.1) {
            EXPECT_NEAR(point->state.q[0], expected[k].beta1, 1e-9);
            EXPECT_NEAR(point->state.q[2], expected[k].beta3, 1e-9);
            ++met[k];
          }
    ASSERT_TRUE(tracer.advance(h));
    const Eigen::VectorXd here = Eigen::Map<const Eigen::VectorXd>(tracer.here().state.q.data(), 3);
    EXPECT_GT(std::abs(tracer.here().sigma), 0.01) << "rank 2 on the whole oval";
    Eigen::VectorXd way = here - start;
    way[1] = std::remainder(way[1], 2 * pi);
    round = step > 10 && way.norm() < 0.015;
  }
  EXPECT_TRUE(round);
  for (int k = 0; k < 4; ++k) EXPECT_EQ(met[k], 1) << k;
}

TEST(Branch, the_parallelogram_crosses_its_antiparallel_branch_in_both_collinear_configurations) {
  for (const bool hinge : {false, true}) {
    const double a = 1, d = 2;
    const Model model = planar_four_bar(a, d, a, d, hinge);
    const double beta1 = 0.5;
    BranchTracer tracer(model, at_rest(model, {beta1, pi / 2 - beta1, beta1 + pi / 2}), 2);
    if (tracer.here().tangent[0] < 0) tracer = BranchTracer(model, tracer.here().state, 2, -tracer.here().tangent);
    int crossings = 0;
    for (int step = 0; step < 400; ++step) {
      const double h = 0.02;
      if (const auto near = tracer.locate(h, [](const BranchPoint& p) { return p.sigma; })) {
        const auto crossing = locate_singular_point(model, near->state, 2);
        ASSERT_TRUE(crossing);
        ++crossings;
        const bool first = std::abs(std::remainder(crossing->state.q[0] - pi / 2, 2 * pi)) < 0.1;
        EXPECT_NEAR(std::remainder(crossing->state.q[0] - (first ? pi / 2 : -pi / 2), 2 * pi), 0, 1e-9);
        EXPECT_NEAR(std::remainder(crossing->state.q[2] - (first ? pi : 0), 2 * pi), 0, 1e-9);
        EXPECT_EQ(crossing->decomposition.rank, 1);
        ASSERT_EQ(crossing->tangents.size(), 2u);
        const Eigen::Vector3d parallel = Eigen::Vector3d(1, -1, 1).normalized();
        const Eigen::Vector3d anti =
            (first ? Eigen::Vector3d(a - d, a + d, a + d) : Eigen::Vector3d(a + d, a - d, a - d)).normalized();
        for (const Eigen::Vector3d& expected : {parallel, anti}) {
          double best = 1;
          for (const Eigen::VectorXd& tangent : crossing->tangents)
            best = std::min({best, (tangent - expected).norm(), (tangent + expected).norm()});
          EXPECT_LT(best, 1e-9) << "first " << first << " hinge " << hinge;
        }
        // the other branch can be followed from here
        for (const Eigen::VectorXd& tangent : crossing->tangents) {
          BranchTracer other(model, crossing->state, 2, tangent);
          ASSERT_TRUE(other.advance(0.01));
          ASSERT_TRUE(other.advance(0.05));
          EXPECT_GT(other.here().tangent.dot(tangent), 0.9);
        }
      }
      ASSERT_TRUE(tracer.advance(h));
      EXPECT_NEAR(std::remainder(tracer.here().state.q[2] - tracer.here().state.q[0] - pi / 2, 2 * pi), 0, 1e-9)
          << "stays on the parallel branch";
    }
    EXPECT_GE(crossings, 2);
  }
}

}  // namespace
}  // namespace lanc::test
