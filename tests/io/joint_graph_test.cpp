// Models given as a graph of joints: where loops are cut, and that no choice of the cut changes the mechanism.
#include "lib/io/joint_graph.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <map>

#include "lib/closure/assembly.h"
#include "lib/closure/mobility.h"
#include "lib/spatial/eigen.h"
#include "lib/system/evaluator.h"
#include "tests/support/body_motion.h"
#include "tests/support/random_model.h"

namespace lanc {
namespace {

using Eigen::Matrix3d, Eigen::Vector3d;
using test::expect_same_motion, test::inverse, test::motion_of_bodies, test::WorldMotion, test::Random;
using test::operator*;

/// A graph written down in the world, where all coordinates are zero; own axes of the bodies and orientations of the
/// joints' frames are arbitrary.
class Draft {
 public:
  explicit Draft(std::uint64_t seed) : random_(seed) { graph.model.gravity = {1, -3, -9}; }

  void body(const std::string& name, double mass, const Vector3d& com) {
    const Placement own{random_.rotation(), random_.vector(1)};
    BodySpec body = test::random_body(random_, name);
    body.mass = mass;
    body.com = (inverse(own) * Placement{Matrix3d::Identity(), com}).position;
    graph.model.bodies.push_back(body);
    own_[name] = own;
  }
  JointSpec& joint(const std::string& name, std::string_view kind, const std::string& a, const std::string& b,
                   const Vector3d& at, const std::vector<Vector3d>& axes = {}) {
    const Placement frame{random_.rotation(), at};
    GraphJointSpec g;
    g.joint.name = name, g.joint.kind = *find_joint_kind(kind);
    g.joint.parent = a, g.joint.body = b;
    g.joint.frame = inverse(own_[a]) * frame;
    g.frame_b = inverse(own_[b]) * frame;
    if (!axes.empty()) g.joint.axis = frame.rotation.transpose() * axes[0];
    if (axes.size() > 1) g.joint.axis2 = frame.rotation.transpose() * axes[1];
    graph.joints.push_back(g);
    return graph.joints.back().joint;
  }
  void spring(const std::string& a, const std::string& b, const Vector3d& from, const Vector3d& to) {
    const auto in = [&](const std::string& name, const Vector3d& point) {
      return (inverse(own_[name]) * Placement{Matrix3d::Identity(), point}).position;
    };
    graph.model.springs.push_back({"spring", a, b, in(a, from), in(b, to), 40, 3, 0.4, {}});
  }

  GraphSpec graph;

 private:
  Random random_;
  std::map<std::string, Placement> own_;  // ground's: the world
};

/// Joints in the order first, second, third, closing; the first body is the crank.
Draft four_bar(std::string_view last = "revolute") {
  Draft d(3);
  d.body("crank", 1, {0.2, 0.5, 0.1}), d.body("coupler", 2, {1.3, 1.2, 0}), d.body("rocker", 1.5, {2, 0.8, -0.1});
  const Vector3d z = Vector3d::UnitZ();
  d.joint("shaft", "revolute", "", "crank", {0, 0, 0}, {z});
  d.joint("crank_pin", "revolute", "crank", "coupler", {0.5, 1, 0}, {z});
  if (last == "revolute")
    d.joint("rocker_pin", "revolute", "coupler", "rocker", {2.2, 1.5, 0}, {z});
  else
    d.joint("rocker_pin", last, "coupler", "rocker", {2.2, 1.5, 0});
  d.joint("pivot", "revolute", "", "rocker", {2, 0, 0}, {z});
  d.spring("coupler", "", {1.3, 1.4, 0.2}, {1, 3, 0});
  return d;
}

Draft bennett() {
  Draft d(5);
  d.body("crank", 1, {-0.2, 0.4, 0}), d.body("coupler", 1, {-0.6, 0.2, 0.3}), d.body("rocker", 1, {-1, -0.2, 0.2});
  d.joint("shaft", "revolute", "", "crank", {0, 0, 0}, {Vector3d::UnitZ()});
  d.joint("second", "revolute", "coupler", "crank", {-0.4161468365471424, 0.9092974268256817, 0},
          {{0.4546487134128408, 0.20807341827357118, 0.8660254037844387}});
  d.joint("third", "revolute", "coupler", "rocker", {-0.7725396613562141, -0.4538453887271163, 0.5146122995337371},
          {{-0.3430748663558248, 0.40893415974904296, 0.8456195888608997}});
  d.joint("fourth", "revolute", "", "rocker", {-1.5, 0, 0}, {{0, 0.75, 0.6614378277661477}});
  d.spring("coupler", "", {-0.5, 0.2, 0.2}, {1, 0, 2});
  return d;
}

Draft slider_crank() {
  Draft d(7);
  d.body("crank", 1, {0, 0.25, 0.1}), d.body("rod", 2, {0.6, 0.3, 0}), d.body("slider", 3, {1.2, 0.1, 0});
  const Vector3d z = Vector3d::UnitZ();
  d.joint("shaft", "revolute", "crank", "", {0, 0, 0}, {z});
  d.joint("crank_pin", "revolute", "crank", "rod", {0, 0.5, 0}, {z});
  d.joint("wrist_pin", "revolute", "slider", "rod", {1.2, 0, 0}, {z});
  d.joint("slide", "prismatic", "", "slider", {1, 0, 0}, {Vector3d::UnitX()});
  d.spring("slider", "", {1.3, 0, 0}, {3, 0.5, 0});
  return d;
}

Draft spatial_slider_crank() {
  Draft d(9);
  d.body("crank", 1, {0, 0.25, 0}), d.body("rod", 1, {0.75, 0.3, 0.2}), d.body("slider", 1, {1.5, 0.1, 0.5});
  d.joint("shaft", "revolute", "", "crank", {0, 0, 0}, {Vector3d::UnitZ()});
  d.joint("ball", "spherical", "crank", "rod", {0, 0.5, 0});
  d.joint("cardan", "universal", "slider", "rod", {1.5, 0.1, 0.4}, {Vector3d::UnitZ(), Vector3d::UnitX()});
  d.joint("slide", "prismatic", "slider", "", {1.5, 0.1, 0.4}, {Vector3d::UnitX()});
  d.spring("rod", "crank", {0.7, 0.4, 0.3}, {0.1, 0.1, 1});
  return d;
}

GraphSpec with_cut(GraphSpec graph, const std::string& name, bool cut) {
  for (GraphJointSpec& g : graph.joints)
    if (g.joint.name == name) g.cut = cut;
  return graph;
}

/// At zero coordinates, where the graph is assembled: the crank turns with 2 rad/s.
State<double> turning(const Model& model) {
  State<double> state = neutral_state(model);
  const int crank = *model.find_body("crank");
  const auto turn = [&] {
    Evaluator<double> evaluator(model);
    evaluator.system(state);
    return to_eigen(evaluator.angular_velocity(crank)).z();
  };
  for (std::size_t k = 0; k < state.v.size(); ++k) state.v[k] = 1 + 0.3 * static_cast<double>(k % 3);
  const VelocityResult consistent = consistent_velocities(model, state);
  EXPECT_TRUE(consistent.consistent) << consistent.message;
  state = consistent.state;
  const double now = turn();
  EXPECT_GT(std::abs(now), 1e-3);
  for (double& v : state.v) v *= 2 / now;
  return state;
}

TEST(JointGraph, any_choice_of_the_cut_gives_the_same_verdict_and_the_same_accelerations) {
  struct Expected {
    const char* name;
    Draft draft;
    int absolute_rows, absolute_rank, mobility;
    Verdict verdict;
  };
  const Expected linkages[] = {{"four-bar", four_bar(), 20, 17, 1, Verdict::overconstrained},
                               {"four-bar with a ball", four_bar("spherical"), 18, 17, 1, Verdict::overconstrained},
                               {"Bennett", bennett(), 20, 17, 1, Verdict::overconstrained},
                               {"slider-crank", slider_crank(), 20, 17, 1, Verdict::overconstrained},
                               {"spatial slider-crank", spatial_slider_crank(), 17, 17, 1, Verdict::regular}};
  for (const Expected& expected : linkages) {
    std::map<std::string, WorldMotion> reference;
    for (const GraphJointSpec& g : expected.draft.graph.joints) {
      SCOPED_TRACE(std::string(expected.name) + " cut at " + g.joint.name);
      const CutGraph cut = cut_loops(with_cut(expected.draft.graph, g.joint.name, true));
      ASSERT_EQ(cut.record.cuts.size(), 1u);
      EXPECT_EQ(cut.record.cuts[0].joint, g.joint.name);
      EXPECT_EQ(cut.record.cuts[0].loop.size(), 4u);
      const Model model = Model::build(cut.model);
      const Mobility m = analyse_mobility(model, neutral_state(model));
      EXPECT_LT(m.position_violation, 1e-14);
      EXPECT_EQ(m.absolute_rows, expected.absolute_rows);
      EXPECT_EQ(m.absolute_rank, expected.absolute_rank);
      EXPECT_EQ(m.redundant(), expected.absolute_rows - expected.absolute_rank);
      EXPECT_EQ(m.mobility, expected.mobility);
      EXPECT_EQ(m.finite_mobility, expected.mobility);
      EXPECT_EQ(to_string(m.verdict), to_string(expected.verdict));
      const auto found = motion_of_bodies(model, turning(model));
      if (reference.empty())
        reference = found;
      else
        expect_same_motion(reference, found, 1e-9);
    }
  }
}

TEST(JointGraph, a_loop_is_cut_where_the_fewest_conditions_arise) {
  const CutGraph cut = cut_loops(four_bar("spherical").graph);
  ASSERT_EQ(cut.record.cuts.size(), 1u);
  const LoopCut& c = cut.record.cuts[0];
  EXPECT_EQ(c.joint, "rocker_pin");
  EXPECT_EQ(c.conditions, 3);
  EXPECT_FALSE(c.demanded);
  EXPECT_EQ(c.loop, (std::vector<std::string>{"rocker_pin", "pivot", "shaft", "crank_pin"}));
  EXPECT_EQ(to_text(c), "loop (rocker_pin, pivot, shaft, crank_pin) is cut at 'rocker_pin' (spherical, 3 conditions)");
  ASSERT_EQ(cut.model.closures.size(), 1u);
  EXPECT_EQ(cut.model.closures[0].name, "rocker_pin");
  EXPECT_EQ(cut.model.joints.size(), 3u);
  EXPECT_EQ(cut_loops(spatial_slider_crank().graph).record.cuts.at(0).joint, "ball");
}

TEST(JointGraph, of_joints_with_equally_many_conditions_the_last_in_the_list_is_cut) {
  GraphSpec graph = four_bar().graph;
  EXPECT_EQ(cut_loops(graph).record.cuts.at(0).joint, "pivot");
  std::reverse(graph.joints.begin(), graph.joints.end());
  EXPECT_EQ(cut_loops(graph).record.cuts.at(0).joint, "shaft");
}

TEST(JointGraph, what_the_user_says_about_cuts_wins) {
  const GraphSpec graph = four_bar("spherical").graph;
  EXPECT_EQ(cut_loops(with_cut(graph, "rocker_pin", false)).record.cuts.at(0).joint, "pivot");
  const CutGraph demanded = cut_loops(with_cut(graph, "shaft", true));
  EXPECT_EQ(demanded.record.cuts.at(0).joint, "shaft");
  EXPECT_TRUE(demanded.record.cuts.at(0).demanded);
  EXPECT_NE(to_text(demanded.record.cuts[0]).find("(revolute, 5 conditions, as the model says)"), std::string::npos);
}

TEST(JointGraph, a_joint_with_a_spring_or_limits_or_a_coupler_stays_in_the_tree) {
  GraphSpec graph = four_bar("spherical").graph;
  JointSpec& ball = graph.joints[2].joint;
  ball.coordinates.resize(3);
  EXPECT_EQ(cut_loops(graph).record.cuts.at(0).joint, "rocker_pin") << "nothing but zeros";
  for (CoordinateSpec& c : ball.coordinates) c.damping = 0.1;
  EXPECT_EQ(cut_loops(graph).record.cuts.at(0).joint, "pivot");
  graph.joints[3].joint.limits.push_back(LimitSpec{-1, 1});
  EXPECT_EQ(cut_loops(graph).record.cuts.at(0).joint, "crank_pin");
  graph.model.couplers.push_back({"gear", {{"crank_pin", 0, 1.0}}, 0, ConstantSpeed{0, 1}, {}});
  EXPECT_EQ(cut_loops(graph).record.cuts.at(0).joint, "shaft");
}

TEST(JointGraph, a_driven_joint_has_six_conditions_and_keeps_its_motion_where_it_is_cut) {
  Draft draft = slider_crank();
  draft.graph.joints.back().joint.motion = Sine{0, 0.1, 3, 0};
  const CutGraph cut = cut_loops(draft.graph);
  EXPECT_EQ(cut.record.cuts.at(0).joint, "wrist_pin") << "the slide comes later, but has more conditions";
  const CutGraph demanded = cut_loops(with_cut(draft.graph, "slide", true));
  EXPECT_EQ(demanded.record.cuts.at(0).conditions, 6);
  const Model a = Model::build(cut.model), b = Model::build(demanded.model);
  EXPECT_EQ(a.drives(), 1);
  EXPECT_EQ(b.closures().rows(), 6);
  const auto moving = [](const Model& model) {
    const VelocityResult v = consistent_velocities(model, neutral_state(model));
    EXPECT_TRUE(v.consistent) << v.message;
    return v.state;
  };
  expect_same_motion(motion_of_bodies(a, moving(a)), motion_of_bodies(b, moving(b)), 1e-9);
}

TEST(JointGraph, a_free_joint_that_is_cut_vanishes) {
  Draft draft = four_bar();
  draft.joint("tether", "free", "", "coupler", {0, 0, 1});
  const CutGraph cut = cut_loops(draft.graph);
  ASSERT_EQ(cut.record.cuts.size(), 2u);
  EXPECT_EQ(cut.record.cuts[1].joint, "tether");
  EXPECT_EQ(cut.record.cuts[1].conditions, 0);
  EXPECT_EQ(cut.model.closures.size(), 1u);
}

TEST(JointGraph, random_graphs_are_cut_at_fewest_conditions_and_move_the_same_cut_elsewhere) {
  Random random(11);
  for (int trial = 0; trial < 50; ++trial) {
    Draft draft(trial);
    const int bodies = 2 + random.below(12), more = random.below(12);
    const auto name = [](int i) { return i < 0 ? std::string() : "b" + std::to_string(i); };
    for (int i = 0; i < bodies; ++i) draft.body(name(i), 1, random.vector(1));
    for (int j = 0; j < bodies + more; ++j) {
      const int b = j < bodies ? j : random.below(bodies), a = j < bodies ? random.below(j + 1) - 1 : b - 1;
      const auto kind = static_cast<unsigned char>(random.below(joint_kinds - 1));
      const bool forth = random.chance(0.5);
      JointSpec& joint = draft.joint("j" + std::to_string(j), JointKind{kind}.traits().name, name(forth ? a : b),
                                     name(forth ? b : a), random.vector(1));
      if (joint.kind.traits().has_pitch) joint.pitch = 0.1;
    }
    std::map<std::string, int> conditions;
    for (const GraphJointSpec& g : draft.graph.joints) conditions[g.joint.name] = 6 - g.joint.kind.traits().nv;
    const CutGraph cut = cut_loops(draft.graph);
    EXPECT_EQ(static_cast<int>(cut.record.cuts.size()), more);
    EXPECT_EQ(static_cast<int>(cut.model.joints.size()), bodies);
    for (const LoopCut& c : cut.record.cuts)
      for (const std::string& other : c.loop) EXPECT_LE(c.conditions, conditions[other]) << trial << c.joint << other;
    const Model model = Model::build(cut.model);
    EXPECT_EQ(model.bodies(), bodies);
    if (more == 0) continue;
    const std::vector<std::string>& loop = cut.record.cuts[random.below(more)].loop;
    const std::string& other = loop[random.below(static_cast<int>(loop.size()))];
    const Model elsewhere = Model::build(cut_loops(with_cut(draft.graph, other, true)).model);
    SCOPED_TRACE(std::to_string(trial) + ", also cut at " + other);
    expect_same_motion(motion_of_bodies(model, neutral_state(model)),
                       motion_of_bodies(elsewhere, neutral_state(elsewhere)), 1e-9);
  }
}

TEST(JointGraph, many_long_loops_are_cut_in_little_time) {
  Draft draft(1);
  const int bodies = 5000;
  for (int i = 0; i < bodies; ++i) {
    const std::string name = "b" + std::to_string(i), last = i == 0 ? "" : "b" + std::to_string(i - 1);
    draft.body(name, 1, {0, 0, 0});
    draft.joint("j" + name, "revolute", i % 2 == 0 ? last : name, i % 2 == 0 ? name : last, {0, 0, 0});
    if (i > 0) draft.joint("k" + name, "spherical", "", name, {0, 0, 0});
  }
  const std::clock_t start = std::clock();
  const CutGraph cut = cut_loops(draft.graph);
  EXPECT_LT(static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC, 10);
  EXPECT_EQ(cut.record.cuts.size(), static_cast<std::size_t>(bodies - 1));
  EXPECT_LE(cut.record.cuts.back().loop.size(), 60u);
  EXPECT_LT(to_text(cut.record.cuts.back()).size(), 200u);
}

}  // namespace
}  // namespace lanc
