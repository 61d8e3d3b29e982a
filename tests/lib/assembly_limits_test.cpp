// Assembly within the limits of joints: nearest to what is preferred, limits exact, or told what hinders.
#include "lib/closure/assembly_limits.h"

#include <gtest/gtest.h>

#include <numbers>

#include "lib/closure/scaling.h"
#include "lib/io/mechanism.h"
#include "lib/solve/dense.h"
#include "lib/solve/ipopt.h"
#include "lib/system/closure_jacobian.h"
#include "lib/system/evaluator.h"
#include "tests/support/loop_cases.h"
#include "tests/support/random_model.h"

namespace lanc::test {
namespace {

/// Crank 1, coupler 2, rocker 2 and 2.5 m between the pivots, in the x-z plane; positive angles lift the tips.
ModelSpec four_bar(double ground_bar = 2.5) {
  ModelSpec spec;
  spec.name = "four-bar";
  spec.length = 1;
  const auto add = [&](const std::string& name, const std::string& parent, double x, double length) {
    BodySpec body;
    body.name = name;
    body.mass = length;
    body.com = Eigen::Vector3d::UnitX() * length / 2;
    body.inertia = Eigen::Vector3d(0.01, length / 12 + 0.01, length / 12 + 0.01).asDiagonal();
    spec.bodies.push_back(body);
    JointSpec joint;
    joint.name = "j_" + name;
    joint.kind = *find_joint_kind("revolute");
    joint.parent = parent;
    joint.body = name;
    joint.frame.position = {x, 0, 0};
    joint.axis = -Eigen::Vector3d::UnitY();
    spec.joints.push_back(joint);
  };
  add("crank", "", 0, 1);
  add("coupler", "crank", 1, 2);
  add("rocker", "", ground_bar, 2);
  ClosureSpec c;
  c.name = "pin";
  c.kind = *find_closure_kind("revolute");  // five conditions on three angles
  c.body_a = "coupler", c.body_b = "rocker";
  c.frame_a.position = c.frame_b.position = {2, 0, 0};
  c.axis = Eigen::Vector3d::UnitY();
  spec.closures.push_back(c);
  return spec;
}

Model with_limits(ModelSpec spec, int joint, double lower, double upper) {
  spec.joints[joint].limits = {LimitSpec{lower, upper}};
  return Model::build(spec);
}

/// Lagrange's conditions in velocities: the gradient of the distance is a combination of the rows of G and of the
/// coordinates at limits, these with the sign that pushes inwards. What is left of it, and the largest wrong sign.
struct Stationarity {
  double rest = 0, wrong_sign = 0, gradient = 0;
};

Stationarity stationarity(const Model& model, const LimitedAssemblyResult& result,
                          const std::vector<double>& preferred) {
  const ClosureScaling scaling(model);
  const int nv = model.nv();
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(nv);
  std::vector<int> velocity_of(model.nq(), -1);
  for (const Link& link : model.links()) {
    const int w = link.kind.traits().quaternion;
    for (int c = 0; c < link.nv; ++c) {
      double unit[6] = {}, rate[7];
      unit[c] = scaling.column[link.v + c];
      coordinate_rate(link.kind, result.state.q.data() + link.q, unit, rate);
      for (int k = 0; k < link.nq; ++k) {
        const double scale = w < 0 ? scaling.column[link.v + k] : k < w ? model.length() : 0.5;
        gradient[link.v + c] += (result.state.q[link.q + k] - preferred[link.q + k]) / scale * rate[k] / scale;
      }
    }
    for (int k = 0; k < link.nq && w < 0; ++k) velocity_of[link.q + k] = link.v + k;
  }
  Evaluator<double> evaluator(model);
  ClosureJacobian<double> jacobian(model);
  jacobian.evaluate(evaluator.system(result.state));
  const int m = jacobian.rows(), limits = static_cast<int>(result.reached.size());
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(nv, m + limits);
  for (int k = 0; k < m; ++k)
    for (int p = jacobian.starts()[k]; p < jacobian.starts()[k + 1]; ++p) {
      const int c = jacobian.columns()[p];
      A(c, k) = jacobian.values()[p] * scaling.row[k] * scaling.column[c];
    }
  for (int i = 0; i < limits; ++i) A(velocity_of[result.reached[i].coordinate], m + i) = 1;
  const Eigen::VectorXd multiplier = least_squares(A, gradient, 1e-10);
  Stationarity s;
  s.gradient = gradient.norm();
  s.rest = (gradient - A * multiplier).norm();
  for (int i = 0; i < limits; ++i)
    s.wrong_sign = std::max(s.wrong_sign, multiplier[m + i] * (result.reached[i].upper ? 1 : -1));
  return s;
}

class AssemblyWithinLimits : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!has_ipopt()) GTEST_SKIP() << "built without Ipopt";
  }
};

const std::vector<double> elbow_up = {1.2, -0.9, 1.5};  // near to a closed loop

TEST(AssemblyWithoutIpopt, names_the_option_that_is_missing) {
  if (has_ipopt()) GTEST_SKIP() << "built with Ipopt";
  const Model model = Model::build(four_bar());
  try {
    assemble_within_limits(model, at_rest(model, elbow_up));
    FAIL() << "no error";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("-DLANC_WITH_IPOPT=ON"), std::string::npos) << error.what();
  }
}

TEST_F(AssemblyWithinLimits, takes_the_other_branch_where_the_nearest_violates_a_limit) {
  const Model model = with_limits(four_bar(), 2, -3, -0.1);  // the rocker hangs
  const State<double> guess = at_rest(model, elbow_up);
  const AssemblyResult nearest = assemble(model, guess);
  ASSERT_TRUE(nearest.assembled());
  EXPECT_EQ(violated_limits(model, nearest.state.q).size(), 1u);
  const LimitedAssemblyResult result = assemble_within_limits(model, guess);
  ASSERT_TRUE(result.assembled()) << result.message;
  EXPECT_LE(result.state.q[2], -0.1);
  EXPECT_LE(largest_violation_of(model, result.state), 1e-12);
  EXPECT_TRUE(violated_limits(model, result.state.q).empty());
  const Stationarity s = stationarity(model, result, guess.q);
  EXPECT_LE(s.rest, 1e-7 * s.gradient);
  EXPECT_LE(s.wrong_sign, 1e-7);
}

TEST_F(AssemblyWithinLimits, meets_an_active_limit_exactly) {
  const Model model = with_limits(four_bar(), 0, -0.2, 0.7);  // 0.7 is no binary number
  const LimitedAssemblyResult result = assemble_within_limits(model, at_rest(model, elbow_up));
  ASSERT_TRUE(result.assembled()) << result.message;
  EXPECT_EQ(result.state.q[0], 0.7);
  EXPECT_LE(largest_violation_of(model, result.state), 1e-14);
  ASSERT_EQ(result.reached.size(), 1u);
  EXPECT_EQ(result.reached[0].coordinate, 0);
  EXPECT_TRUE(result.reached[0].upper);
  EXPECT_EQ(to_text(model, result.reached), "'j_crank.angle' at its upper limit 0.7 rad");
  const Stationarity s = stationarity(model, result, elbow_up);
  EXPECT_LE(s.rest, 1e-7 * s.gradient);
  EXPECT_LE(s.wrong_sign, 1e-7);
  EXPECT_GT(result.state.q[2], 0) << "on the branch of the guess";
}

/// Least distance of both branches from p, over 100 000 crank angles.
double least_distance(const std::vector<double>& p, double ground_bar) {
  double least = 1e9;
  const auto near = [](double angle, double to) { return std::remainder(angle - to, 2 * std::numbers::pi); };
  for (int k = 0; k < 100000; ++k) {
    const double a = 2 * std::numbers::pi * k / 100000, x = ground_bar - std::cos(a), z = -std::sin(a);
    const double d = std::hypot(x, z), half = std::acos(d / 4), towards = std::atan2(z, x);
    if (!(d <= 4)) continue;
    for (const double side : {1.0, -1.0}) {
      const double coupler = towards + side * half, rocker = towards + std::numbers::pi - side * half;
      least = std::min(least, std::hypot(near(a, p[0]), near(coupler - a, p[1]), near(rocker, p[2])));
    }
  }
  return least;
}

TEST_F(AssemblyWithinLimits, is_as_near_to_preferred_positions_as_can_be) {
  const Model model = Model::build(four_bar());
  Random random(5);
  int nearest_of_all = 0;
  for (int k = 0; k < 20; ++k) {
    const std::vector<double> p = {random.uniform(-2, 2), random.uniform(-2, 2), random.uniform(-2, 2)};
    const LimitedAssemblyResult result = assemble_within_limits(model, at_rest(model, elbow_up), {.preferred = p});
    ASSERT_TRUE(result.assembled()) << result.message;
    EXPECT_LE(largest_violation_of(model, result.state), 1e-14);
    const Stationarity s = stationarity(model, result, p);
    EXPECT_LE(s.rest, 1e-7 * s.gradient);
    EXPECT_GT(s.gradient, 0.1);
    const double least = least_distance(p, 2.5);
    EXPECT_GE(result.distance, least - 1e-6);
    nearest_of_all += result.distance <= least + 1e-6;
  }
  EXPECT_GE(nearest_of_all, 18) << "several starts leave few local minima";
}

TEST_F(AssemblyWithinLimits, reaches_preferred_positions_that_are_closed) {
  const Model model = Model::build(four_bar());
  const std::vector<double> p = assemble(model, at_rest(model, elbow_up)).state.q;
  const LimitedAssemblyResult result = assemble_within_limits(model, at_rest(model, {0, 0, 0}), {.preferred = p});
  ASSERT_TRUE(result.assembled()) << result.message;
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(result.state.q[k], p[k], 1e-14);
  EXPECT_EQ(result.starts, 1);
}

TEST_F(AssemblyWithinLimits, leaves_redundant_loops_where_they_are) {
  for (const char* name : {"four-bar-ladder:4:cut=weld", "four-bar-chain:3", "stewart-gough"}) {
    const std::string file = LANC_SOURCE_DIR "/data/models/linkages/" + std::string(name) + ".toml";
    const Mechanism m = load_mechanism(std::string(name) == "stewart-gough" ? file : name);
    const LimitedAssemblyResult result = assemble_within_limits(m.model, m.state);
    ASSERT_TRUE(result.assembled()) << name << result.message;
    EXPECT_LE(result.moved_angle, 1e-14) << name;
    EXPECT_LE(result.moved_length, 1e-14) << name;
  }
}

TEST_F(AssemblyWithinLimits, closes_redundant_loops_at_a_limit) {
  Mechanism m = load_mechanism("four-bar-ladder:3:cut=weld");
  ModelSpec spec = m.model.spec();
  const double limit = m.state.q[0] + 0.1;
  spec.joints[0].limits = {LimitSpec{limit, limit + 1}};
  const Model model = Model::build(spec);
  const LimitedAssemblyResult result = assemble_within_limits(model, m.state);
  ASSERT_TRUE(result.assembled()) << result.message;
  EXPECT_EQ(result.state.q[0], limit);
  EXPECT_LE(result.violation, 1e-13);
  const Stationarity s = stationarity(model, result, m.state.q);
  EXPECT_LE(s.rest, 1e-6 * s.gradient);
}

TEST_F(AssemblyWithinLimits, moves_a_stewart_platform_as_far_as_its_legs_reach) {
  Mechanism m = load_mechanism(LANC_SOURCE_DIR "/data/models/linkages/stewart-gough.toml");
  ModelSpec spec = m.model.spec();
  for (JointSpec& joint : spec.joints)
    if (joint.name.rfind("slide", 0) == 0) joint.limits = {LimitSpec{-0.1, 0.1}};
  const Model model = Model::build(spec);
  const std::vector<std::string> names = model.position_names();
  std::vector<double> wanted = m.state.q;
  const auto pose = static_cast<int>(std::find(names.begin(), names.end(), "pose.x") - names.begin());
  ASSERT_LT(pose, model.nq());
  const double half = 0.4;  // of the angle by which it is turned
  wanted[pose + 2] += 0.5;
  wanted[pose + 3] = std::cos(half), wanted[pose + 6] = std::sin(half);
  const LimitedAssemblyResult result = assemble_within_limits(model, m.state, {.preferred = wanted});
  ASSERT_TRUE(result.assembled()) << result.message;
  EXPECT_LE(largest_violation_of(model, result.state), 1e-12);
  EXPECT_TRUE(violated_limits(model, result.state.q).empty());
  EXPECT_GE(result.reached.size(), 1u);
  for (const ReachedLimit& limit : result.reached)
    EXPECT_EQ(result.state.q[limit.coordinate], limit.upper ? 0.1 : -0.1);
  double norm = 0;
  for (int k = 3; k < 7; ++k) norm += result.state.q[pose + k] * result.state.q[pose + k];
  EXPECT_NEAR(norm, 1, 1e-14);
  EXPECT_GT(result.state.q[pose + 2], 1.01);
  EXPECT_GT(result.moved_angle, 0.1);
  const Stationarity s = stationarity(model, result, wanted);
  EXPECT_LE(s.rest, 1e-7 * s.gradient);
  EXPECT_LE(s.wrong_sign, 1e-7);
  EXPECT_GT(s.gradient, 0.1);
}

TEST_F(AssemblyWithinLimits, closes_random_mechanisms_within_limits_that_leave_a_way) {
  int reached = 0;
  for (int seed = 1; seed <= 20; ++seed) {
    const std::string name = "random-loops:3:seed=" + std::to_string(seed);
    const Mechanism m = load_mechanism(name);
    Random random(seed);
    ModelSpec spec = m.model.spec();
    State<double> guess = m.state;
    for (int i = 0; i < m.model.bodies(); ++i) {
      const Link& link = m.model.link(i);
      spec.joints[i].limits.assign(spec.joints[i].kind.traits().nq, std::nullopt);
      for (int k = 0; k < link.nq; ++k) {
        const double q = m.state.q[link.q + k];
        if (random.chance(0.5)) spec.joints[i].limits[k] = LimitSpec{q - random.uniform(0, 0.1), q + 0.1};
        guess.q[link.q + k] += random.uniform(-0.3, 0.3);
      }
      if (const int w = link.kind.traits().quaternion; w >= 0 && link.nq > 0) {
        Eigen::Map<Eigen::Vector4d> e(&guess.q[link.q + w]);
        e.normalize();
      }
    }
    const Model model = Model::build(spec);
    const LimitedAssemblyResult result = assemble_within_limits(model, guess, {.compared = 1});
    EXPECT_TRUE(result.assembled()) << name << ": " << result.message;
    EXPECT_TRUE(violated_limits(model, result.state.q).empty()) << name;
    EXPECT_LE(result.violation, 1e-12) << name;
    reached += static_cast<int>(result.reached.size());
  }
  EXPECT_GT(reached, 30);
}

TEST_F(AssemblyWithinLimits, names_the_limits_that_keep_a_loop_open) {
  ModelSpec spec = four_bar();
  spec.joints[0].limits = {LimitSpec{0.9, 1.0}};
  spec.joints[2].limits = {LimitSpec{-0.3, 0.1}};
  const Model model = Model::build(spec);
  const LimitedAssemblyResult result = assemble_within_limits(model, at_rest(model, elbow_up), {.starts = 4});
  EXPECT_EQ(result.status, AssemblyStatus::beyond_limits);
  // the rocker's tip goes away from the coupler's circle
  EXPECT_GT(result.gaps[0].length, 0.1);
  EXPECT_NE(result.message.find("'pin."), std::string::npos) << result.message;
  EXPECT_NE(result.message.find("'j_rocker.angle' at its upper limit 0.1 rad"), std::string::npos) << result.message;
  EXPECT_NE(result.message.find("without limits it closes"), std::string::npos) << result.message;
  EXPECT_NE(result.message.find("beyond its upper limit 0.1 rad"), std::string::npos) << result.message;
  EXPECT_TRUE(violated_limits(model, result.state.q).empty()) << "the state it leaves is within limits";
}

TEST_F(AssemblyWithinLimits, tells_a_loop_that_closes_without_limits_no_more_than_with_them) {
  const Model model = with_limits(four_bar(6), 0, -3, 3);
  const LimitedAssemblyResult result = assemble_within_limits(model, at_rest(model, elbow_up), {.starts = 3});
  EXPECT_EQ(result.status, AssemblyStatus::infeasible);
  EXPECT_NEAR(result.gaps[0].length, 1, 1e-4) << "five metres of bars over six metres";
  EXPECT_NE(result.message.find("nor does it close without limits"), std::string::npos) << result.message;
}

TEST_F(AssemblyWithinLimits, does_not_accept_a_joint_the_wrong_way_round) {
  ModelSpec spec = four_bar();
  spec.closures[0].frame_a.rotation = Eigen::Vector3d(1, -1, -1).asDiagonal();  // the axis points the other way
  const Model model = Model::build(spec);
  const LimitedAssemblyResult result = assemble_within_limits(model, at_rest(model, elbow_up), {.starts = 3});
  EXPECT_EQ(result.status, AssemblyStatus::flipped) << result.message;
  EXPECT_NE(result.message.find("wrong way round"), std::string::npos) << result.message;
}

TEST_F(AssemblyWithinLimits, turns_angles_into_their_limits) {
  const Model model = with_limits(four_bar(), 0, -3, 3);
  std::vector<double> q = assemble(model, at_rest(model, elbow_up)).state.q;
  const double angle = q[0];
  q[0] += 4 * std::numbers::pi;
  const LimitedAssemblyResult result = assemble_within_limits(model, at_rest(model, q));
  ASSERT_TRUE(result.assembled()) << result.message;
  EXPECT_NEAR(result.state.q[0], angle, 1e-14);
}

TEST_F(AssemblyWithinLimits, keeps_limits_of_joints_on_no_loop) {
  const Model model = Model::build([] {
    ModelSpec spec = four_bar();
    spec.closures.clear();
    spec.joints[1].limits = {LimitSpec{0.3, 0.7}};
    return spec;
  }());
  const LimitedAssemblyResult result = assemble_within_limits(model, at_rest(model, {0.1, -0.2, 0.3}));
  ASSERT_TRUE(result.assembled());
  EXPECT_EQ(result.state.q, (std::vector<double>{0.1, 0.3, 0.3}));
}

TEST_F(AssemblyWithinLimits, can_be_interrupted) {
  const Model model = Model::build(four_bar());
  const LimitedAssemblyResult result =
      assemble_within_limits(model, at_rest(model, elbow_up), {.interrupted = [] { return true; }});
  EXPECT_EQ(result.status, AssemblyStatus::interrupted);
}

TEST_F(AssemblyWithinLimits, refuses_preferred_positions_of_another_model) {
  const Model model = Model::build(four_bar());
  EXPECT_THROW(assemble_within_limits(model, at_rest(model, elbow_up), {.preferred = {1, 2}}), InputError);
}

}  // namespace
}  // namespace lanc::test
