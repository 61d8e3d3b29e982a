// Least distance under conditions and bounds: what lib/solve/ipopt.h promises of Ipopt.
#include "lib/solve/ipopt.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

namespace lanc::test {
namespace {

constexpr double unbounded = std::numeric_limits<double>::infinity();
using Vector = std::vector<double>;

/// The point of the unit circle that is nearest to (a, b).
LeastDistanceProblem circle(double a, double b) {
  LeastDistanceProblem problem;
  problem.target = {a, b};
  problem.weight = {1, 1};
  problem.lower = {-unbounded, -unbounded};
  problem.upper = {unbounded, unbounded};
  problem.conditions = 1;
  problem.residual = [](const Vector& x, Vector& g) { return g[0] = x[0] * x[0] + x[1] * x[1] - 1, true; };
  problem.rows = {0, 0};
  problem.columns = {0, 1};
  problem.jacobian = [](const Vector& x, Vector& J) { return J = {2 * x[0], 2 * x[1]}, true; };
  problem.curvature = [](const Vector&, const Vector& multiplier, Vector& H) {
    return H = {2 * multiplier[0], 0, 2 * multiplier[0]}, true;
  };
  problem.curved = 2;
  return problem;
}

class Ipopt : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!has_ipopt()) GTEST_SKIP() << "built without Ipopt";
  }
};

TEST_F(Ipopt, finds_the_nearest_point_with_and_without_second_derivatives) {
  for (const bool exact : {true, false}) {
    LeastDistanceProblem problem = circle(3, 4);
    if (!exact) problem.curvature = nullptr;
    const LeastDistanceResult result = solve_least_distance(problem, {1, 0.1});
    EXPECT_EQ(result.status, LeastDistanceStatus::solved);
    EXPECT_NEAR(result.x[0], 0.6, 1e-9);
    EXPECT_NEAR(result.x[1], 0.8, 1e-9);
    EXPECT_NEAR(result.multiplier[0], 2, 1e-8) << "x − target + 2 λ x = 0";
    EXPECT_GT(result.steps, 0);
  }
}

TEST_F(Ipopt, keeps_bounds_and_tells_how_hard_they_are_pushed) {
  LeastDistanceProblem problem = circle(3, 4);
  problem.upper[1] = 0.5;
  const LeastDistanceResult result = solve_least_distance(problem, {0.1, 0});
  EXPECT_EQ(result.status, LeastDistanceStatus::solved);
  EXPECT_LE(result.x[1], 0.5);
  EXPECT_NEAR(result.x[1], 0.5, 1e-9);
  EXPECT_NEAR(result.x[0], std::sqrt(0.75), 1e-9);
  const double multiplier = (3 / std::sqrt(0.75) - 1) / 2;
  EXPECT_NEAR(result.upper_force[1], 3.5 - multiplier, 1e-7);
  EXPECT_NEAR(result.lower_force[1], 0, 1e-9);
}

TEST_F(Ipopt, weighs_the_unknowns) {
  LeastDistanceProblem problem;
  problem.target = {1, 1};
  problem.weight = {1, 3};
  problem.lower = {-unbounded, -unbounded};
  problem.upper = {unbounded, unbounded};
  problem.conditions = 1;
  problem.residual = [](const Vector& x, Vector& g) { return g[0] = x[0] + x[1], true; };
  problem.rows = {0, 0};
  problem.columns = {0, 1};
  problem.jacobian = [](const Vector&, Vector& J) { return J = {1, 1}, true; };
  problem.curvature = [](const Vector&, const Vector&, Vector&) { return true; };  // curved = 0
  const LeastDistanceResult result = solve_least_distance(problem, {5, 5});
  EXPECT_EQ(result.status, LeastDistanceStatus::solved);
  EXPECT_NEAR(result.x[0], -0.5, 1e-9);
  EXPECT_NEAR(result.x[1], 0.5, 1e-9);
}

TEST_F(Ipopt, says_so_when_there_is_no_such_point) {
  LeastDistanceProblem problem = circle(3, 4);
  problem.lower = {2, 2};
  const LeastDistanceResult result = solve_least_distance(problem, {3, 3});
  EXPECT_EQ(result.status, LeastDistanceStatus::infeasible);
  EXPECT_GE(result.x[0], 2);
}

TEST_F(Ipopt, can_be_interrupted) {
  LeastDistanceProblem problem = circle(3, 4);
  int asked = 0;
  problem.interrupted = [&] { return ++asked == 2; };
  EXPECT_EQ(solve_least_distance(problem, {1, 0.1}).status, LeastDistanceStatus::interrupted);
  EXPECT_EQ(asked, 2);
}

TEST_F(Ipopt, stops_after_the_steps_it_was_given) {
  EXPECT_EQ(solve_least_distance(circle(3, 4), {1, 0.1}, 1).status, LeastDistanceStatus::too_many_steps);
}

TEST_F(Ipopt, tells_functions_without_a_value) {
  LeastDistanceProblem problem = circle(3, 4);
  problem.residual = [](const Vector&, Vector&) { return false; };
  const LeastDistanceResult result = solve_least_distance(problem, {1, 0.1});
  EXPECT_EQ(result.status, LeastDistanceStatus::not_finite);
  EXPECT_EQ(result.x.size(), 2u);
}

TEST_F(Ipopt, lets_exceptions_of_functions_through) {
  LeastDistanceProblem problem = circle(3, 4);
  problem.residual = [](const Vector&, Vector&) -> bool { throw std::runtime_error("mine"); };
  EXPECT_THROW(solve_least_distance(problem, {1, 0.1}), std::runtime_error);
}

TEST_F(Ipopt, prints_nothing) {
  ::testing::internal::CaptureStdout();
  ::testing::internal::CaptureStderr();
  solve_least_distance(circle(3, 4), {1, 0.1});
  EXPECT_EQ(::testing::internal::GetCapturedStdout(), "");
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
}

}  // namespace
}  // namespace lanc::test
