#include "lib/system/energy.h"

#include <gtest/gtest.h>

#include "tests/support/random_model.h"

namespace lanc::test {
namespace {

/// A box on a revolute joint about z, its mass centre at (0.5, 0, 0).
ModelSpec pendulum() {
  ModelSpec spec;
  spec.gravity = {0, -10, 0};
  BodySpec body;
  body.name = "rod";
  body.mass = 2;
  body.com = {0.5, 0, 0};
  body.inertia = Eigen::Vector3d(0.1, 0.2, 0.25).asDiagonal();
  JointSpec joint;
  joint.name = "hinge", joint.body = "rod";
  joint.kind = *find_joint_kind("revolute");
  spec.bodies = {body}, spec.joints = {joint};
  return spec;
}

Energy<double> energy_of(const ModelSpec& spec, const State<double>& state) {
  Evaluator<double> evaluator(Model::build(spec));
  return energy(evaluator, state);
}

TEST(Energy, of_a_pendulum_is_that_of_the_textbook) {
  const double q = 0.7, v = 3;
  const Energy<double> e = energy_of(pendulum(), {0, {q}, {v}});
  EXPECT_NEAR(e.kinetic, 0.5 * (0.25 + 2 * 0.25) * v * v, 1e-14);
  EXPECT_NEAR(e.potential, 2 * 10 * 0.5 * std::sin(q), 1e-14);
  EXPECT_EQ(e.total(), e.kinetic + e.potential);
}

TEST(Energy, counts_joint_springs_rotors_and_point_springs) {
  ModelSpec spec = pendulum();
  spec.joints[0].coordinates = {{.stiffness = 4, .rest = 0.2, .armature = 0.3}};
  PointSpringSpec spring;
  spring.name = "spring", spring.body_b = "rod";
  spring.point_a = {0, 2, 0}, spring.point_b = {1, 0, 0};
  spring.stiffness = 5, spring.rest_length = 1;
  const State<double> state{0, {0.7}, {3}};
  const Energy<double> without = energy_of(spec, state);
  spec.springs = {spring};
  const Energy<double> with = energy_of(spec, state);
  const double length = std::hypot(std::cos(0.7), std::sin(0.7) - 2);
  EXPECT_NEAR(with.potential - without.potential, 0.5 * 5 * (length - 1) * (length - 1), 1e-13);
  const Energy<double> plain = energy_of(pendulum(), state);
  EXPECT_NEAR(without.potential - plain.potential, 0.5 * 4 * 0.25, 1e-14);
  EXPECT_NEAR(without.kinetic - plain.kinetic, 0.5 * 0.3 * 9, 1e-14);
}

TEST(Energy, of_a_prescribed_joint_contains_its_rotor_and_its_spring) {
  ModelSpec spec = pendulum();
  spec.joints[0].motion = ConstantSpeed{0.7, 3};
  const Energy<double> plain = energy_of(spec, {0, {}, {}});
  EXPECT_NEAR(plain.kinetic, 0.5 * (0.25 + 2 * 0.25) * 9, 1e-14);
  spec.joints[0].coordinates = {{.stiffness = 4, .rest = 0.2, .armature = 0.3}};
  const Energy<double> e = energy_of(spec, {0, {}, {}});
  EXPECT_NEAR(e.kinetic - plain.kinetic, 0.5 * 0.3 * 9, 1e-14);
  EXPECT_NEAR(e.potential - plain.potential, 0.5 * 4 * 0.25, 1e-14);
}

TEST(Energy, is_the_same_on_every_scalar) {
  const Case c = random_case(5, 20);
  Evaluator<double> plain(c.model);
  Evaluator<long double> wide(c.model);
  Evaluator<Count> counting(c.model);
  const Energy<double> e = energy(plain, c.state);
  EXPECT_NEAR(e.total(), static_cast<double>(energy(wide, cast<long double>(c.state)).total()), 1e-10);
  EXPECT_NEAR(e.total(), energy(counting, cast<Count>(c.state)).total().value(), 1e-10);
}

}  // namespace
}  // namespace lanc::test
