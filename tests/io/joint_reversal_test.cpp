// Joints seen from their other body: the same joint in other coordinates.
#include "lib/io/joint_reversal.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>

#include "lib/io/joint_graph.h"
#include "lib/spatial/eigen.h"
#include "lib/system/evaluator.h"
#include "tests/support/body_motion.h"
#include "tests/support/random_model.h"

namespace lanc {
namespace {

using Eigen::Vector3d;
using test::inverse;
using test::Random;
using test::operator*;

int link_on(const Model& model, const std::string& joint) {
  for (int i = 0; i < model.bodies(); ++i)
    if (model.spec().joints[i].name == joint) return i;
  ADD_FAILURE() << "no joint " << joint << " in the tree";
  return 0;
}

/// Body a floats, a joint of every kind leads to body b; or body b floats, so that the joint is reversed.
struct Pair {
  GraphSpec graph;
  Placement own_b;  // in axes of the joint's frame
};

Pair pair_on(JointKind kind, bool b_floats, bool driven) {
  Random random(40 + kind.index);
  Pair pair;
  for (const char* name : {"a", "b"}) pair.graph.model.bodies.push_back(test::random_body(random, name));
  GraphJointSpec hold, g;
  hold.joint.name = "hold", hold.joint.kind = *find_joint_kind("free");
  hold.joint.body = b_floats ? "b" : "a";
  g.joint = test::random_joint(random, kind, "j");
  g.joint.parent = "a", g.joint.body = "b";
  g.joint.motion.reset(), g.joint.coordinates.clear(), g.joint.limits.clear();
  g.frame_b = {random.rotation(), random.vector(0.3)};
  const JointTraits& traits = kind.traits();
  if (driven)
    g.joint.motion = Sine{0.2, 0.7, 2, 0.4};
  else
    g.joint.coordinates.resize(traits.nv);
  const bool spherical = traits.name == "spherical";
  for (int k = 0; k < static_cast<int>(g.joint.coordinates.size()); ++k) {
    CoordinateSpec& c = g.joint.coordinates[k];
    if (traits.name == "free" || (traits.name == "planar" && k < 2)) continue;
    c.damping = spherical ? 0.3 : 0.3 + k, c.armature = spherical ? 0.2 : 0.2 + k;
    if (spherical) continue;
    c.stiffness = 5 + k, c.rest = 0.3, c.friction_positive = 0.4, c.friction_negative = 0.7 + k, c.torque = 1.1 - k;
    c.friction_speed = 0.5;
  }
  pair.graph.joints = {g, hold};
  pair.graph.model.gravity = {1, 2, 3};
  pair.own_b = inverse(g.frame_b);
  return pair;
}

void set(const Model& model, const std::string& joint, State<double>& state, const std::vector<double>& q,
         const std::vector<double>& v) {
  const Link& link = model.link(link_on(model, joint));
  ASSERT_EQ(link.nq, static_cast<int>(q.size()));
  ASSERT_EQ(link.nv, static_cast<int>(v.size()));
  std::copy(q.begin(), q.end(), state.q.begin() + link.q);
  std::copy(v.begin(), v.end(), state.v.begin() + link.v);
}

/// Position and Euler parameters, and the twist in own axes, of body b, whose own axes are `own` in the tree's.
void pose_of_b(const Model& model, const State<double>& state, const Placement& own, std::vector<double>& q,
               std::vector<double>& v) {
  Evaluator<double> evaluator(model);
  evaluator.system(state);
  const int b = *model.find_body("b");
  const Placement body{to_eigen(evaluator.body_rotation(b)), to_eigen(evaluator.positions()[b])};
  const Placement pose = body * own;
  const Eigen::Quaterniond e(pose.rotation);
  const Vector3d omega = to_eigen(evaluator.twists()[b].angular);
  const Vector3d velocity = to_eigen(evaluator.twists()[b].linear) + omega.cross(pose.position - body.position);
  const Vector3d w = pose.rotation.transpose() * omega, u = pose.rotation.transpose() * velocity;
  q = {pose.position.x(), pose.position.y(), pose.position.z(), e.w(), e.x(), e.y(), e.z()};
  v = {w.x(), w.y(), w.z(), u.x(), u.y(), u.z()};
}

void expect_reversal_is_exact(JointKind kind, bool driven) {
  SCOPED_TRACE(std::string(kind.traits().name) + (driven ? ", driven" : ""));
  const Pair pair = pair_on(kind, false, driven);
  const CutGraph forward = cut_loops(pair.graph), backward = cut_loops(pair_on(kind, true, driven).graph);
  EXPECT_TRUE(forward.record.reversed.empty());
  EXPECT_EQ(backward.record.reversed.empty(), !reversal_changes_coordinates(kind));
  const Model a = Model::build(forward.model), b = Model::build(backward.model);
  Random random(7 + kind.index);
  State<double> state_a = test::random_state(random, a), state_b = neutral_state(b);
  state_a.t = state_b.t = 0.3;
  std::vector<double> q, v;
  pose_of_b(a, state_a, pair.own_b, q, v);
  set(b, "hold", state_b, q, v);
  const Link& j = a.link(link_on(a, "j"));
  set(b, "j", state_b, {state_a.q.begin() + j.q, state_a.q.begin() + j.q + j.nq},
      {state_a.v.begin() + j.v, state_a.v.begin() + j.v + j.nv});
  state_b = with_reversed_joints(b, backward.record, state_b);
  test::expect_same_motion(test::motion_of_bodies(a, state_a), test::motion_of_bodies(b, state_b), 1e-11);
  const State<double> twice =
      with_reversed_joints(b, backward.record, with_reversed_joints(b, backward.record, state_b));
  for (std::size_t k = 0; k < twice.q.size(); ++k) EXPECT_NEAR(twice.q[k], state_b.q[k], 1e-14);
  for (std::size_t k = 0; k < twice.v.size(); ++k) EXPECT_NEAR(twice.v[k], state_b.v[k], 1e-14);
}

TEST(JointReversal, a_joint_that_is_reversed_moves_its_bodies_as_before) {
  for (unsigned char k = 0; k < joint_kinds; ++k) {
    expect_reversal_is_exact(JointKind{k}, false);
    if (JointKind{k}.traits().nv == 1) expect_reversal_is_exact(JointKind{k}, true);
  }
}

TEST(JointReversal, limits_and_couplers_follow_the_coordinates_of_reversed_joints) {
  Random random(1);
  JointSpec cardan = test::random_joint(random, *find_joint_kind("universal"), "j");
  cardan.coordinates.clear();
  cardan.limits = {LimitSpec{1, 2}, std::nullopt};
  const JointSpec back = reversed(cardan, {});
  EXPECT_FALSE(back.limits[0].has_value());
  EXPECT_EQ(back.limits[1]->upper, 2);
  JointSpec ball = test::random_joint(random, *find_joint_kind("spherical"), "j");
  ball.coordinates.clear();
  ball.limits = {LimitSpec{0, 1}, LimitSpec{-1, 2}, std::nullopt, std::nullopt};
  const JointSpec ball_back = reversed(ball, {});
  EXPECT_EQ(ball_back.limits[0]->lower, 0);
  EXPECT_EQ(ball_back.limits[1]->lower, -2);
  EXPECT_EQ(ball_back.limits[1]->upper, 1);

  GraphSpec graph = pair_on(*find_joint_kind("universal"), true, false).graph;
  graph.model.couplers.push_back({"gear", {{"j", 0, 1.0}}, 0, ConstantSpeed{0, 1}, {}});
  EXPECT_EQ(cut_loops(graph).model.couplers[0].terms[0].coordinate, 1);
}

}  // namespace
}  // namespace lanc
