// Mechanisms whose equations of motion stand in textbooks, for every formulation.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "lib/formulation/formulation.h"
#include "lib/system/evaluator.h"
#include "tests/support/tolerance.h"

namespace lanc::test {
namespace {

using Eigen::Vector3d;
constexpr double g = 9.81;

BodySpec body(const std::string& name, double mass, const Vector3d& com, const Vector3d& inertia) {
  BodySpec b;
  b.name = name, b.mass = mass, b.com = com;
  b.inertia = inertia.asDiagonal();
  return b;
}

JointSpec joint(const char* kind, const std::string& parent, const std::string& child,
                std::optional<Vector3d> axis = {}) {
  JointSpec j;
  j.name = "joint of " + child, j.parent = parent, j.body = child;
  j.kind = *find_joint_kind(kind);
  j.axis = axis;
  return j;
}

ModelSpec mechanism(std::vector<BodySpec> bodies, std::vector<JointSpec> joints, const Vector3d& gravity = {0, -g, 0}) {
  ModelSpec spec;
  spec.gravity = gravity;
  spec.bodies = std::move(bodies), spec.joints = std::move(joints);
  return spec;
}

/// check(solution) for every formulation that solves it; at least one must.
template <class Check>
void for_each_solution(const ModelSpec& spec, const State<double>& state, Check check) {
  const Model model = Model::build(spec);
  Evaluator<double> evaluator(model);
  const System<double>& system = evaluator.system(checked_state(model, state));
  int solved = 0;
  for (const FormulationInfo& info : formulations()) {
    if (!info.create_double || info.objection(model)) continue;
    Solution<double> solution(model);
    if (!info.create_double(model)->solve(system, solution).usable()) continue;
    SCOPED_TRACE(info.name);
    check(solution);
    ++solved;
  }
  EXPECT_GE(solved, 1);
}

void expect(const char* what, double actual, double expected) {
  EXPECT_TRUE(within(what, actual - expected, 1, 1 + std::abs(expected)));
}

TEST(ClosedForm, simple_pendulum_and_the_force_in_its_hinge) {
  const double m = 2, l = 0.7, q = 0.4, v = 3;  // q from the horizontal
  const ModelSpec spec =
      mechanism({body("mass", m, {l, 0, 0}, {0, 0, 0})}, {joint("revolute", "", "mass", Vector3d(0, 0, 1))});
  for_each_solution(spec, {0, {q}, {v}}, [&](const Solution<double>& s) {
    const double a = -g * std::cos(q) / l;
    expect("angular acceleration", s.vdot[0], a);
    // force of the hinge: mass times acceleration minus weight
    expect("hinge, x", s.wrench[0].force.x, m * l * (-a * std::sin(q) - v * v * std::cos(q)));
    expect("hinge, y", s.wrench[0].force.y, m * l * (a * std::cos(q) - v * v * std::sin(q)) + m * g);
    expect("hinge, moment about its axis", s.wrench[0].moment.z, 0);
    expect("acceleration of the body", s.acceleration[0].angular.z, a);
  });
}

TEST(ClosedForm, physical_pendulum_on_a_cart) {
  const double M = 3, m = 2, l = 0.5, I = 0.2, q = 0.4, v = 1.3;  // q from the downward vertical
  ModelSpec spec = mechanism(
      {body("cart", M, {0, 0, 0}, {1, 1, 1}), body("rod", m, {0, -l, 0}, {I, 0.1, I})},
      {joint("prismatic", "", "cart", Vector3d(1, 0, 0)), joint("revolute", "cart", "rod", Vector3d(0, 0, 1))});
  for_each_solution(spec, {0, {0.3, q}, {0.7, v}}, [&](const Solution<double>& s) {
    Eigen::Matrix2d A;
    A << M + m, m * l * std::cos(q), m * l * std::cos(q), I + m * l * l;
    const Eigen::Vector2d b(m * l * v * v * std::sin(q), -m * g * l * std::sin(q));
    const Eigen::Vector2d expected = A.ldlt().solve(b);
    expect("cart", s.vdot[0], expected[0]);
    expect("pendulum", s.vdot[1], expected[1]);
  });
}

TEST(ClosedForm, free_rigid_body_obeys_eulers_equations) {
  const Vector3d I(0.3, 0.5, 0.6), w(1, -2, 3), u(0.4, 0.5, 0.6);
  const ModelSpec spec = mechanism({body("body", 2, {0, 0, 0}, I)}, {joint("free", "", "body")});
  const Vector3d Iw = I.cwiseProduct(w);
  const Vector3d expected = (-w.cross(Iw)).cwiseQuotient(I);
  const State<double> state{0, {1, 2, 3, 0.5, 0.5, 0.5, 0.5}, {w.x(), w.y(), w.z(), u.x(), u.y(), u.z()}};
  for_each_solution(spec, state, [&](const Solution<double>& s) {
    for (int k = 0; k < 3; ++k) expect("angular acceleration in body axes", s.vdot[k], expected[k]);
    expect("falls", s.acceleration[0].linear.y, -g);
    expect("does not drift", s.acceleration[0].linear.x, 0);
    // v̇ in body axes: gravity turned into them minus ω × u; this Q takes (x, y, z) of the body to (y, z, x)
    const Vector3d gravity_in_body(-g, 0, 0);
    const Vector3d rate = gravity_in_body - w.cross(u);
    for (int k = 0; k < 3; ++k) expect("linear acceleration in body axes", s.vdot[3 + k], rate[k]);
    expect("no joint, no wrench", s.wrench[0].force.y, 0);
  });
}

TEST(ClosedForm, nut_on_a_vertical_screw) {
  const double m = 2, J = 0.3, pitch = 0.05;
  JointSpec screw = joint("helical", "", "nut", Vector3d(0, 1, 0));
  screw.pitch = pitch;
  const ModelSpec spec = mechanism({body("nut", m, {0, 0, 0}, {J, J, J})}, {screw});
  for_each_solution(spec, {0, {1}, {2}}, [&](const Solution<double>& s) {
    expect("acceleration", s.vdot[0], -m * g * pitch / (J + m * pitch * pitch));
  });
}

TEST(ClosedForm, bead_on_a_rod_that_turns_at_constant_speed) {
  const double m = 2, speed = 3, x = 0.4, v = 0.9;
  ModelSpec spec =
      mechanism({body("rod", 1, {0, 0, 0}, {0.1, 0.1, 0.1}), body("bead", m, {0, 0, 0}, {0, 0, 0})},
                {joint("revolute", "", "rod", Vector3d(0, 0, 1)), joint("prismatic", "rod", "bead", Vector3d(1, 0, 0))},
                {0, 0, 0});
  spec.joints[0].motion = ConstantSpeed{0.2, speed};
  for_each_solution(spec, {0, {x}, {v}}, [&](const Solution<double>& s) {
    expect("centrifugal acceleration", s.vdot[0], speed * speed * x);
    expect("torque of the drive against Coriolis", s.drive_force[0], 2 * m * speed * v * x);
  });
}

TEST(ClosedForm, driven_lift_carries_weight_and_inertia) {
  const double m = 2, a = 1.5;
  ModelSpec spec =
      mechanism({body("cabin", m, {0.3, 0, 0}, {1, 1, 1})}, {joint("prismatic", "", "cabin", Vector3d(0, 1, 0))});
  spec.joints[0].motion = Polynomial{{0, 0, a / 2}};
  spec.joints[0].coordinates = {{.stiffness = 10, .damping = 4, .armature = 0.5}};
  for_each_solution(spec, {2, {}, {}}, [&](const Solution<double>& s) {
    const double position = a / 2 * 4, speed = a * 2;
    expect("drive force", s.drive_force[0], m * (g + a) + 0.5 * a + 10 * position + 4 * speed);
    expect("guide moment", s.wrench[0].moment.z, 0.3 * m * (g + a));
  });
}

TEST(ClosedForm, rotor_inertia_adds_to_the_pendulum_and_not_to_the_joint_wrench) {
  const double m = 2, l = 0.7, A = 0.4;
  ModelSpec spec =
      mechanism({body("mass", m, {l, 0, 0}, {0, 0, 0})}, {joint("revolute", "", "mass", Vector3d(0, 0, 1))});
  spec.joints[0].coordinates = {{.armature = A}};
  for_each_solution(spec, {0, {0}, {0}}, [&](const Solution<double>& s) {
    const double a = -m * g * l / (m * l * l + A);
    expect("acceleration", s.vdot[0], a);
    expect("the joint passes on the rotor's reaction", s.wrench[0].moment.z, -A * a);
  });
}

TEST(ClosedForm, spherical_pendulum_in_steady_precession) {
  const double m = 2, l = 0.7, angle = 0.6;  // cone about −y
  const double w = std::sqrt(g / (l * std::cos(angle)));
  const ModelSpec spec =
      mechanism({body("mass", m, l * Vector3d(std::sin(angle), -std::cos(angle), 0), {0.1, 0.1, 0.1})},
                {joint("spherical", "", "mass")});
  // with I = i·1, spinning about y at w: the moment of the weight keeps the momentum's perpendicular part turning
  for_each_solution(spec, {0, {1, 0, 0, 0}, {0, w, 0}}, [&](const Solution<double>& s) {
    for (int k = 0; k < 3; ++k) expect("angular acceleration", s.vdot[k], 0);
    expect("centripetal force", s.wrench[0].force.x, -m * w * w * l * std::sin(angle));
    expect("weight", s.wrench[0].force.y, m * g);
  });
}

}  // namespace
}  // namespace lanc::test
