// The Puma 560 of the literature, with and without friction, to the digits printed (data/reference/puma560.csv).
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "lib/formulation/formulation.h"
#include "lib/spatial/eigen.h"
#include "lib/system/equations.h"
#include "lib/system/evaluator.h"
#include "tests/support/reference_data.h"
#include "tests/support/tolerance.h"

namespace lanc::test {
namespace {

using Numbers = std::vector<double>;
constexpr int n = 6;

class Puma560 : public ::testing::Test {
 protected:
  ReferenceData data_ = read_reference("puma560.csv");

  /// Standard Denavit-Hartenberg: joint i turns about z of frame i−1; frame i lies at (a, 0, d), turned by α about x.
  /// Our body axes are those of joint i, that is frame i−1 turned by q_i.
  Model model(bool friction, bool gravity = true) const {
    ModelSpec spec;
    spec.name = "puma560";
    spec.gravity = {0, 0, gravity ? -data_.at("gravity")[0].value : 0};
    Placement next;  // frame of the next joint in the body before
    for (int i = 1; i <= n; ++i) {
      const Numbers p = values(data_.at("link" + std::to_string(i)));
      Placement link;
      link.position = {p[1], 0, p[0]};
      link.rotation = Eigen::AngleAxisd(p[2] * std::numbers::pi / 2, Eigen::Vector3d::UnitX()).toRotationMatrix();
      BodySpec body;
      body.name = "link" + std::to_string(i);
      body.mass = p[3];
      body.com = link.position + link.rotation * Eigen::Vector3d(p[4], p[5], p[6]);
      const Eigen::Matrix3d I = Eigen::Vector3d(p[7], p[8], p[9]).asDiagonal();
      const Eigen::Matrix3d turned = link.rotation * I * link.rotation.transpose();
      body.inertia = (turned + turned.transpose()) / 2;
      body.allow_nonphysical_inertia = i == 1 || i == 3;  // only what enters the equations was identified
      JointSpec joint;
      joint.name = "joint" + std::to_string(i);
      joint.kind = *find_joint_kind("revolute");
      joint.body = body.name;
      if (i > 1) joint.parent = "link" + std::to_string(i - 1);
      joint.frame = next;
      const double G = p[11];
      CoordinateSpec c;
      c.armature = G * G * p[10];
      if (friction) {
        c.damping = G * G * p[12];
        c.friction_positive = std::abs(G) * p[13];
        c.friction_negative = std::abs(G) * -p[14];
        c.friction_speed = 1e-9;  // the published friction jumps at rest
      }
      joint.coordinates = {c};
      spec.bodies.push_back(body);
      spec.joints.push_back(joint);
      next = link;
    }
    return Model::build(spec);
  }

  static Numbers all(double x) { return Numbers(n, x); }
  static Numbers qn() { return {0, std::numbers::pi / 4, std::numbers::pi, 0, std::numbers::pi / 4, 0}; }

  static Numbers torque(const Model& model, const Numbers& v, const Numbers& vdot, bool tip = false) {
    Evaluator<double> evaluator(model);
    const State<double> state{0, qn(), v};
    Loads<double> loads;
    if (tip) {
      evaluator.system(state);
      const Vec3<double> pressed = evaluator.body_rotation(n - 1) * Vec3<double>{1, 2, 3};
      loads.wrenches = {{n - 1, {-pressed, -pressed}}};
    }
    Solution<double> solution(model);
    solution.vdot = vdot;
    Numbers tau;
    inverse_dynamics(evaluator.system(state, loads), solution, tau);
    return tau;
  }

  /// Tables print four decimals and drop zeros at the end: a shorter number is one that ends in zeros.
  static constexpr double half_unit_of_tables = 0.5e-4 * 1.0001;

  void expect_printed(const Numbers& actual, const std::string& name) const {
    const auto& printed = data_.at(name);
    ASSERT_EQ(actual.size(), printed.size());
    for (std::size_t k = 0; k < actual.size(); ++k)
      EXPECT_TRUE(within_relative(name + "[" + std::to_string(k) + "]", actual[k] - printed[k].value, 1,
                                  std::min(printed[k].half_unit, half_unit_of_tables)));
  }
};

TEST_F(Puma560, inverse_dynamics_with_friction_is_the_published_one) {
  const Model robot = model(true), floating = model(true, false);
  expect_printed(torque(robot, all(0), all(0)), "rne_v0_a0");
  expect_printed(torque(robot, all(0), all(1)), "rne_v0_a1");
  expect_printed(torque(robot, all(1), all(1)), "rne_v1_a1");
  expect_printed(torque(robot, all(1), all(0)), "rne_v1_a0");
  expect_printed(torque(floating, all(1), all(1)), "rne_v1_a1_without_gravity");
  expect_printed(torque(robot, all(0), all(0), true), "rne_v0_a0_with_tip_wrench");
}

TEST_F(Puma560, mass_matrix_and_inertial_torque_are_the_published_ones) {
  const Model robot = model(false, false);
  for (int row = 0; row < n; ++row) {
    Numbers unit = all(0);
    unit[row] = 1;
    expect_printed(torque(robot, all(0), unit), "mass_matrix_row" + std::to_string(row + 1));
  }
  expect_printed(torque(robot, all(0), {1, 2, 3, 1, 2, 3}), "itorque");
}

TEST_F(Puma560, coriolis_matrix_is_the_published_one) {
  // h(v) = C(v) v is quadratic and C its polar form: C(v) e = (h(v + e) − h(v − e)) / 4
  const Model robot = model(false, false);
  std::vector<Numbers> C(n, all(0));
  for (int column = 0; column < n; ++column) {
    Numbers ahead = {1, 2, 3, 1, 2, 3}, behind = ahead;
    ahead[column] += 1, behind[column] -= 1;
    const Numbers a = torque(robot, ahead, all(0)), b = torque(robot, behind, all(0));
    for (int row = 0; row < n; ++row) C[row][column] = (a[row] - b[row]) / 4;
  }
  for (int row = 0; row < n; ++row) expect_printed(C[row], "coriolis_row" + std::to_string(row + 1));
}

TEST_F(Puma560, accelerations_of_every_formulation_are_the_published_ones) {
  int solved = 0;
  for (const bool friction : {true, false}) {
    const Model robot = model(friction);
    Evaluator<double> evaluator(robot);
    const System<double>& system =
        evaluator.system({0, qn(), values(data_.at("accel_v"))}, {values(data_.at("accel_tau")), {}});
    for (const FormulationInfo& info : formulations()) {
      if (!info.create_double || info.objection(robot)) continue;
      Solution<double> solution(robot);
      if (!info.create_double(robot)->solve(system, solution).usable()) continue;
      SCOPED_TRACE(info.name);
      expect_printed(solution.vdot, friction ? "accel_with_friction" : "accel_without_friction");
      ++solved;
    }
  }
  EXPECT_GE(solved, 2);
}

TEST_F(Puma560, is_refused_as_nonphysical_unless_told) {
  ModelSpec spec = model(false).spec();
  for (BodySpec& body : spec.bodies) body.allow_nonphysical_inertia = false;
  EXPECT_THROW(Model::build(spec), InputError);
}

}  // namespace
}  // namespace lanc::test
