// Assembly: loops are closed from a guess, on the branch it is near to, or what hinders is told.
#include "lib/closure/assembly.h"

#include <gtest/gtest.h>

#include <numbers>

#include "lib/closure/rank.h"
#include "lib/closure/retraction.h"
#include "lib/io/mechanism.h"
#include "lib/system/closure_jacobian.h"
#include "lib/system/energy.h"
#include "lib/system/evaluator.h"
#include "lib/system/mass_matrix.h"
#include "tests/support/loop_cases.h"
#include "tests/support/random_model.h"
#include "tests/support/tolerance.h"

namespace lanc::test {
namespace {

/// Planar four-bar in the x-z plane: crank, coupler and rocker of these lengths between pivots `ground_bar` apart, the
/// rocker's tip closed on the coupler's by `closure`.
Model four_bar(double crank, double coupler, double rocker, double ground_bar, std::string_view closure = "revolute") {
  ModelSpec spec;
  spec.name = "four-bar";
  spec.gravity = {0, 0, -9.81};
  const auto add = [&](const std::string& name, const std::string& parent, const Eigen::Vector3d& position,
                       double length) {
    BodySpec body;
    body.name = name;
    body.mass = length;
    body.com = Eigen::Vector3d::UnitX() * length / 2;
    body.inertia =
        Eigen::Vector3d(0.01, length * length * length / 12 + 0.01, length * length * length / 12 + 0.01).asDiagonal();
    spec.bodies.push_back(body);
    JointSpec joint;
    joint.name = "j_" + name;
    joint.kind = *find_joint_kind("revolute");
    joint.parent = parent;
    joint.body = name;
    joint.frame.position = position;
    joint.axis = -Eigen::Vector3d::UnitY();  // positive angles lift the tip
    spec.joints.push_back(joint);
  };
  add("crank", "", {0, 0, 0}, crank);
  add("coupler", "crank", {crank, 0, 0}, coupler);
  add("rocker", "", {ground_bar, 0, 0}, rocker);
  ClosureSpec c;
  c.name = "pin";
  c.kind = *find_closure_kind(closure);
  c.body_a = "coupler", c.body_b = "rocker";
  c.frame_a.position = {coupler, 0, 0}, c.frame_b.position = {rocker, 0, 0};
  if (c.kind.traits().axes != JointAxes::none) c.axis = Eigen::Vector3d::UnitY();
  spec.closures.push_back(c);
  return Model::build(spec);
}

TEST(Assembly, closes_a_four_bar_on_the_branch_the_guess_is_near_to) {
  const Model model = four_bar(1, 2, 2, 2.5);
  for (const double elbow : {1.0, -1.0}) {
    State<double> guess = neutral_state(model);
    guess.q = {1.2, -0.9 + 0.9 * (1 - elbow) / 2 - 0.5 * (1 - elbow), 1.5 * elbow + (1 - elbow) / 2 * 0.2};
    const AssemblyResult result = assemble(model, guess);
    ASSERT_TRUE(result.assembled()) << result.message;
    EXPECT_EQ(result.starts, 1);
    EXPECT_LE(largest_violation_of(model, result.state), 1e-14);
    EXPECT_GT(elbow * std::sin(result.state.q[2]), 0) << "the rocker keeps its side";
    EXPECT_LT(result.moved_angle, 1.2);
    EXPECT_GT(result.moved_angle, 0);
  }
}

TEST(Assembly, leaves_an_assembled_state_where_it_is) {
  for (const char* name : {"four-bar-ladder:7", "four-bar-ladder:3:cut=weld:angle=1.5707963267948966",
                           "four-bar-chain:5:cut=weld", "four-bar-chain:4"}) {
    const Mechanism m = load_mechanism(name);
    const AssemblyResult result = assemble(m.model, m.state);
    ASSERT_TRUE(result.assembled()) << name << result.message;
    EXPECT_LE(result.moved_angle, 1e-14) << name;
    const VelocityResult velocities = consistent_velocities(m.model, m.state);
    EXPECT_TRUE(velocities.consistent) << name << velocities.message;
    EXPECT_LE(velocities.changed, 1e-13) << name;
  }
}

TEST(Assembly, brings_redundant_loops_back_after_they_were_disturbed) {
  Random random(3);
  for (const char* name : {"four-bar-ladder:6", "four-bar-ladder:4:cut=weld", "four-bar-chain:5:cut=weld"}) {
    const Mechanism m = load_mechanism(name);
    State<double> guess = m.state;
    for (double& q : guess.q) q += random.uniform(-0.1, 0.1);
    const AssemblyResult result = assemble(m.model, guess);
    ASSERT_TRUE(result.assembled()) << name << result.message;
    EXPECT_EQ(result.starts, 1) << name;
    EXPECT_LE(largest_violation_of(m.model, result.state), 2e-14) << name;
  }
}

TEST(Assembly, tells_a_loop_that_cannot_close_and_by_how_much) {
  const Model model = four_bar(1, 1, 1, 4);
  const AssemblyResult result = assemble(model, neutral_state(model));
  EXPECT_EQ(result.status, AssemblyStatus::infeasible) << result.message;
  ASSERT_EQ(result.gaps.size(), 1u);
  EXPECT_EQ(result.gaps[0].name, "pin");
  EXPECT_NEAR(result.gaps[0].length, 1, 1e-6) << "three metres of bars over four metres";
  EXPECT_NE(result.message.find("'pin."), std::string::npos) << result.message;
  EXPECT_NE(result.message.find("open by 1 m"), std::string::npos) << result.message;
  EXPECT_NE(result.message.find("cannot be assembled"), std::string::npos) << result.message;
}

TEST(Assembly, tells_a_cylinder_that_is_longer_than_its_boom_can_follow) {
  const Mechanism m = load_mechanism(LANC_SOURCE_DIR "/data/models/closure-distance.toml");
  State<double> state = m.state;
  state.t = 20;
  const AssemblyResult result = assemble(m.model, state);  // at its longest G vanishes
  EXPECT_EQ(result.status, AssemblyStatus::infeasible) << result.message;
  EXPECT_NEAR(result.gaps[0].length, std::sqrt(2.0) + 6 - 2, 1e-9);
}

TEST(Assembly, closes_a_loop_that_is_just_long_enough) {
  const Model model = four_bar(1, 1, 2, 4);  // stretched: the only configuration there is, and a singular one
  State<double> guess = neutral_state(model);
  guess.q = {0.3, -0.2, std::numbers::pi + 0.1};
  const AssemblyResult result = assemble(model, guess);
  ASSERT_TRUE(result.assembled()) << result.message;
  EXPECT_LE(result.violation, 1e-12);
  EXPECT_NEAR(result.state.q[0], 0, 1e-5);
}

/// A bar on a ball joint at the origin, welded to ground at its reference point in some orientation.
Model pinned_bar(std::string_view kind, double pitch = 0) {
  ModelSpec spec;
  BodySpec body;
  body.name = "bar";
  body.mass = 1;
  body.inertia = Eigen::Vector3d(0.1, 0.1, 0.02).asDiagonal();
  spec.bodies.push_back(body);
  JointSpec joint;
  joint.name = "base";
  joint.kind = *find_joint_kind("free");
  joint.body = "bar";
  spec.joints.push_back(joint);
  ClosureSpec c;
  c.name = "end";
  c.kind = *find_closure_kind(kind);
  c.body_b = "bar";
  c.pitch = pitch;
  spec.closures.push_back(c);
  return Model::build(spec);
}

TEST(Assembly, does_not_accept_a_joint_the_wrong_way_round) {
  for (const char* kind : {"fixed", "revolute", "cylindrical", "prismatic", "planar", "equal-orientation"}) {
    const Model model = pinned_bar(kind);
    State<double> guess = neutral_state(model);
    guess.q = {0.1, 0.2, -0.1, 0, 1, 0, 0};  // half a turn about x
    const AssemblyResult result = assemble(model, guess);
    ASSERT_TRUE(result.assembled()) << kind << ": " << result.message;
    EXPECT_EQ(result.starts, 1) << kind;
    Evaluator<double> evaluator(model);
    evaluator.system(result.state);
    EXPECT_NEAR(evaluator.rotation(0).z.z, 1, 1e-12) << kind;
  }
}

TEST(Assembly, does_not_accept_a_screw_half_a_turn_out_of_its_thread) {
  const Model model = pinned_bar("helical", 0.3);
  State<double> guess = neutral_state(model);
  guess.q = {0, 0, 0.3 * std::numbers::pi, 1, 0, 0, 0};  // travelled half a turn, not turned
  const AssemblyResult result = assemble(model, guess);
  ASSERT_TRUE(result.assembled()) << result.message;
  EXPECT_EQ(result.starts, 1);
  const double angle = 2 * std::atan2(result.state.q[6], result.state.q[3]);
  EXPECT_NEAR(std::cos(result.state.q[2] / 0.3 - angle), 1, 1e-12);
}

TEST(Assembly, says_so_when_a_loop_closes_the_wrong_way_round_only) {
  // one hinge about x; the weld demands half a turn about y besides, which a flipped frame would forgive
  ModelSpec spec;
  BodySpec body;
  body.name = "bar";
  body.mass = 1;
  body.inertia = Eigen::Vector3d(0.1, 0.1, 0.02).asDiagonal();
  spec.bodies.push_back(body);
  JointSpec joint;
  joint.name = "base";
  joint.kind = *find_joint_kind("revolute");
  joint.body = "bar";
  joint.axis = Eigen::Vector3d::UnitZ();
  spec.joints.push_back(joint);
  ClosureSpec c;
  c.name = "end";
  c.kind = *find_closure_kind("revolute");
  c.body_b = "bar";
  c.frame_b.rotation = Eigen::Vector3d(1, -1, -1).asDiagonal();
  spec.closures.push_back(c);
  const Model model = Model::build(spec);
  const AssemblyResult result = assemble(model, neutral_state(model));
  EXPECT_EQ(result.status, AssemblyStatus::flipped);
  EXPECT_NE(result.message.find("wrong way round"), std::string::npos) << result.message;
}

TEST(Assembly, closes_loops_through_ball_joints_and_free_bodies) {
  int first_start = 0, cases = 0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    Random random(seed);
    const Model model = pinned_bar(seed % 2 ? "fixed" : "universal");
    State<double> guess = random_state(random, model);
    const AssemblyResult result = assemble(model, guess);
    ASSERT_TRUE(result.assembled()) << seed << ": " << result.message;
    EXPECT_LE(largest_violation_of(model, result.state), 1e-13) << seed;
    const double* e = &result.state.q[3];
    EXPECT_NEAR(e[0] * e[0] + e[1] * e[1] + e[2] * e[2] + e[3] * e[3], 1, 1e-14);
    ++cases, first_start += result.starts == 1;
  }
  EXPECT_GT(first_start, cases / 2);
}

TEST(Assembly, is_the_same_when_it_is_repeated) {
  const Model model = pinned_bar("fixed");
  State<double> guess = neutral_state(model);
  guess.q = {0.1, 0.2, -0.1, 0, 1, 0, 0};
  EXPECT_EQ(assemble(model, guess).state.q, assemble(model, guess).state.q);
}

TEST(Assembly, follows_prescribed_closures_to_the_time_given) {
  ModelSpec spec = four_bar(1, 2, 2, 2.5).spec();
  ClosureSpec cylinder;
  cylinder.name = "cylinder";
  cylinder.kind = *find_closure_kind("distance");
  cylinder.body_a = "";
  cylinder.body_b = "coupler";
  cylinder.frame_a.position = {-1, 0, 0};
  cylinder.frame_b.position = {1, 0, 0};
  cylinder.motion = Polynomial{{2.5, 0.1}};
  spec.closures.push_back(cylinder);
  const Model model = Model::build(spec);
  State<double> state = neutral_state(model);
  state.q = {1.2, -0.9, 1.5};
  for (const double t : {0.0, 1.0, 2.0}) {
    state.t = t;
    const AssemblyResult result = assemble(model, state);
    ASSERT_TRUE(result.assembled()) << t << ": " << result.message;
    state = result.state;
    EXPECT_LE(largest_violation_of(model, state), 1e-13);
    const VelocityResult velocities = consistent_velocities(model, state);
    ASSERT_TRUE(velocities.consistent) << velocities.message;
    EXPECT_GT(velocities.changed, 1e-3) << "the cylinder drives the four-bar";
  }
  state.t = 100;
  EXPECT_EQ(assemble(model, state).status, AssemblyStatus::infeasible) << "a cylinder of 12.5 m";
}

TEST(Assembly, tells_a_motion_that_is_not_defined) {
  ModelSpec spec = four_bar(1, 2, 2, 2.5).spec();
  CouplerSpec drive;
  drive.name = "drive";
  drive.terms = {{"j_crank", 0, 1.0}};
  drive.motion = SplineTable{{0, 1, 2, 3}, {0, 1, 0, 1}};
  spec.couplers.push_back(drive);
  const Model model = Model::build(spec);
  State<double> state = neutral_state(model);
  state.t = 7;
  const AssemblyResult result = assemble(model, state);
  EXPECT_EQ(result.status, AssemblyStatus::not_finite);
  EXPECT_NE(result.message.find("t = 7"), std::string::npos) << result.message;
  EXPECT_NE(result.message.find("not defined"), std::string::npos) << result.message;
}

/// Any other consistent velocities are farther away in kinetic energy.
TEST(ConsistentVelocities, change_least_in_the_kinetic_energy_metric) {
  Random random(11);
  for (const char* name : {"four-bar-ladder:4", "four-bar-chain:3:cut=weld"}) {
    const Mechanism m = load_mechanism(name);
    State<double> state = m.state;
    for (double& v : state.v) v = random.uniform(-1, 1);
    const VelocityResult result = consistent_velocities(m.model, state);
    ASSERT_TRUE(result.consistent) << result.message;
    EXPECT_LE(result.violation, 1e-14);
    Evaluator<double> evaluator(m.model);
    const System<double> system = evaluator.system(result.state);
    const std::vector<double> mass = mass_matrix(system);
    const int nv = m.model.nv();
    Eigen::VectorXd change(nv);
    for (int k = 0; k < nv; ++k) change[k] = result.state.v[k] - state.v[k];
    // M δ must be a combination of the rows of G: orthogonal to every motion G allows, such as the original one
    const Eigen::VectorXd force = Eigen::Map<const Eigen::MatrixXd>(mass.data(), nv, nv) * change;
    for (int trial = 0; trial < 3; ++trial) {
      State<double> other = m.state;
      for (double& v : other.v) v = random.uniform(-1, 1);
      other = consistent_velocities(m.model, other).state;
      const double product = force.dot(Eigen::Map<const Eigen::VectorXd>(other.v.data(), nv));
      EXPECT_TRUE(within(name, product, nv, force.norm() * 10)) << trial;
    }
    EXPECT_GT(force.norm(), 0.1);
  }
}

TEST(ConsistentVelocities, are_found_where_the_mass_matrix_is_singular) {
  ModelSpec spec = four_bar(1, 2, 2, 2.5).spec();
  spec.bodies[1].mass = 0;
  spec.bodies[1].inertia.setZero();
  spec.bodies[2] = spec.bodies[1];
  spec.bodies[2].name = "rocker";
  const Model model = Model::build(spec);
  State<double> state = neutral_state(model);
  state.q = {1.2, -0.9, 1.5};
  state = assemble(model, state).state;
  state.v = {1, 0, 0};
  const VelocityResult result = consistent_velocities(model, state);
  ASSERT_TRUE(result.consistent) << result.message;
  EXPECT_LE(result.violation, 1e-14);
  EXPECT_GT(std::abs(result.state.v[0]), 0.1);
}

TEST(ConsistentVelocities, tell_drives_that_contradict_one_another) {
  ModelSpec spec = four_bar(1, 2, 2, 2.5).spec();
  for (const double rate : {1.0, 2.0}) {
    CouplerSpec drive;
    drive.name = rate == 1 ? "slow" : "fast";
    drive.terms = {{"j_crank", 0, 1.0}};
    drive.offset = 1.2;
    drive.motion = ConstantSpeed{0, rate};
    spec.couplers.push_back(drive);
  }
  const Model model = Model::build(spec);
  State<double> state = neutral_state(model);
  state.q = {1.2, -0.9, 1.5};
  const AssemblyResult assembled = assemble(model, state);
  ASSERT_TRUE(assembled.assembled()) << assembled.message;
  const VelocityResult result = consistent_velocities(model, assembled.state);
  EXPECT_FALSE(result.consistent);
  EXPECT_NEAR(result.state.v[0], 1.5, 1e-9) << "least squares";
  EXPECT_NE(result.message.find("prescribed motion"), std::string::npos) << result.message;
}

}  // namespace
}  // namespace lanc::test
