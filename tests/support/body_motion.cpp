#include "tests/support/body_motion.h"

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include <algorithm>

#include "lib/formulation/formulation.h"
#include "lib/spatial/eigen.h"
#include "lib/system/evaluator.h"
#include "tests/support/tolerance.h"

namespace lanc::test {

using Eigen::Vector3d;

std::map<std::string, WorldMotion> motion_of_bodies(const Model& model, const State<double>& state) {
  Evaluator<double> evaluator(model);
  const System<double>& system = evaluator.system(state);
  Solution<double> solution(model);
  const Outcome outcome = find_formulation("dense")->create_double(model)->solve(system, solution);
  EXPECT_TRUE(outcome.has_answer()) << to_string(outcome.status) << " " << outcome.message;
  std::map<std::string, WorldMotion> result;
  for (int i = 0; i < model.bodies(); ++i) {
    const BodySpec& body = model.spec().bodies[i];
    const Vector3d r = to_eigen(evaluator.body_rotation(i)) * body.com;
    const Vector3d omega = to_eigen(evaluator.angular_velocity(i)), alpha = to_eigen(solution.acceleration[i].angular);
    result[body.name] = {
        to_eigen(evaluator.positions()[i]) + r, to_eigen(evaluator.twists()[i].linear) + omega.cross(r),
        to_eigen(solution.acceleration[i].linear) + alpha.cross(r) + omega.cross(omega.cross(r)), omega, alpha};
  }
  return result;
}

void expect_same_motion(const std::map<std::string, WorldMotion>& a, const std::map<std::string, WorldMotion>& b,
                        double relative) {
  ASSERT_EQ(a.size(), b.size());
  double velocity = 1, acceleration = 1;
  for (const auto& [name, s] : a) {
    velocity = std::max({velocity, s.velocity.norm(), s.omega.norm()});
    acceleration = std::max({acceleration, s.acceleration.norm(), s.alpha.norm()});
  }
  for (const auto& [name, s] : a) {
    const WorldMotion& t = b.at(name);
    EXPECT_TRUE(within_relative(name + ": centre of mass", (s.com - t.com).norm(), relative, 1));
    EXPECT_TRUE(within_relative(name + ": velocity", (s.velocity - t.velocity).norm(), relative, velocity));
    EXPECT_TRUE(within_relative(name + ": angular velocity", (s.omega - t.omega).norm(), relative, velocity));
    EXPECT_TRUE(
        within_relative(name + ": acceleration", (s.acceleration - t.acceleration).norm(), relative, acceleration));
    EXPECT_TRUE(within_relative(name + ": angular acceleration", (s.alpha - t.alpha).norm(), relative, acceleration));
  }
}

Placement operator*(const Placement& outer, const Placement& inner) {
  return {outer.rotation * inner.rotation, outer.rotation * inner.position + outer.position};
}

Placement inverse(const Placement& p) { return {p.rotation.transpose(), -(p.rotation.transpose() * p.position)}; }

}  // namespace lanc::test
