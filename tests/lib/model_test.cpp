// Every bad specification is refused with a message that names the thing and the mend.
#include "lib/model/model.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/support/random_model.h"

namespace lanc::test {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// Three bodies on revolute joints: "body0" .. "body2", "joint0" .. "joint2".
ModelSpec good() {
  Features plain;
  plain.prescribed = plain.singular_inertias = false;
  plain.only_joint = "revolute";
  ModelSpec spec = random_spec(1, 3, plain);
  for (JointSpec& joint : spec.joints) joint.coordinates.clear(), joint.parent.clear();
  spec.springs.clear(), spec.wrenches.clear();
  return spec;
}

PointSpringSpec spring(const std::string& name, const std::string& a, const std::string& b) {
  PointSpringSpec s;
  s.name = name, s.body_a = a, s.body_b = b;
  return s;
}

struct Fault {
  const char* what;
  void (*make)(ModelSpec&);
  const char* thing;  // both must be in the message
  const char* mend;
};

void set_kind(JointSpec& joint, const char* kind) { joint.kind = *find_joint_kind(kind), joint.axis.reset(); }

const Fault faults[] = {
    {"gravity", [](ModelSpec& s) { s.gravity.x() = nan; }, "gravity", "give three numbers"},
    {"length", [](ModelSpec& s) { s.length = -1; }, "length", "positive number of metres"},
    {"nameless body", [](ModelSpec& s) { s.bodies[1].name.clear(); }, "body", "add name"},
    {"two bodies of one name", [](ModelSpec& s) { s.bodies[1].name = "body0"; }, "'body0'", "rename"},
    {"two joints of one name", [](ModelSpec& s) { s.joints[1].name = "joint0"; }, "'joint0'", "rename"},
    {"two springs of one name",
     [](ModelSpec& s) {
       s.springs = {spring("k", "", "body0"), spring("k", "", "body1")};
     },
     "'k'", "rename"},
    {"mass", [](ModelSpec& s) { s.bodies[1].mass = -1; }, "'body1'", "zero or positive"},
    {"mass NaN", [](ModelSpec& s) { s.bodies[1].mass = nan; }, "'body1': mass", "decimal value"},
    {"mass centre", [](ModelSpec& s) { s.bodies[1].com.z() = nan; }, "'body1': centre of mass", "decimal value"},
    {"inertia NaN", [](ModelSpec& s) { s.bodies[1].inertia(0, 1) = nan; }, "'body1': inertia", "decimal value"},
    {"asymmetric inertia", [](ModelSpec& s) { s.bodies[1].inertia(0, 1) += 0.1; }, "'body1'",
     "tensor about the centre of mass"},
    {"negative inertia", [](ModelSpec& s) { s.bodies[1].inertia = Eigen::Vector3d(1, 1, -0.1).asDiagonal(); },
     "'body1'", "allow_nonphysical_inertia"},
    {"triangle inequality", [](ModelSpec& s) { s.bodies[1].inertia = Eigen::Vector3d(1, 1, 3).asDiagonal(); },
     "triangle", "allow_nonphysical_inertia"},
    {"inertia without mass", [](ModelSpec& s) { s.bodies[1].mass = 0; }, "inertia without mass",
     "allow_nonphysical_inertia"},
    {"nameless joint", [](ModelSpec& s) { s.joints[1].name.clear(); }, "joint", "add name"},
    {"rotation of a frame", [](ModelSpec& s) { s.joints[1].frame.rotation *= 1.1; }, "'joint1'",
     "right-handed unit axes"},
    {"mirrored frame", [](ModelSpec& s) { s.joints[1].frame.rotation.col(0) *= -1; }, "'joint1'",
     "right-handed unit axes"},
    {"position of a frame", [](ModelSpec& s) { s.joints[1].frame.position.x() = nan; }, "'joint1': position",
     "decimal value"},
    {"zero axis", [](ModelSpec& s) { s.joints[1].axis = Eigen::Vector3d::Zero(); }, "'joint1': axis is zero",
     "for example"},
    {"NaN axis", [](ModelSpec& s) { s.joints[1].axis = Eigen::Vector3d(nan, 0, 1); }, "'joint1': axis",
     "decimal value"},
    {"axis of a spherical joint",
     [](ModelSpec& s) { set_kind(s.joints[1], "spherical"), s.joints[1].axis = Eigen::Vector3d::UnitX(); }, "'joint1'",
     "remove it"},
    {"second axis of a hinge", [](ModelSpec& s) { s.joints[1].axis2 = Eigen::Vector3d::UnitX(); }, "'joint1'",
     "remove axis2"},
    {"oblique axes",
     [](ModelSpec& s) { set_kind(s.joints[1], "universal"), s.joints[1].axis2 = Eigen::Vector3d(1, 0, 1); }, "'joint1'",
     "not perpendicular"},
    {"pitch of a hinge", [](ModelSpec& s) { s.joints[1].pitch = 0.1; }, "'joint1'", "make the joint helical"},
    {"motion of a ball joint", [](ModelSpec& s) { set_kind(s.joints[1], "spherical"), s.joints[1].motion = Sine{}; },
     "'joint1'", "one freedom"},
    {"bad motion", [](ModelSpec& s) { s.joints[1].motion = Formula{"2*"}; }, "'joint1'", "a formula is made of"},
    {"number of coordinates", [](ModelSpec& s) { s.joints[1].coordinates.resize(2); }, "'joint1'",
     "2 coordinate entries for 1"},
    {"number of limits", [](ModelSpec& s) { s.joints[1].limits.resize(2); }, "'joint1'", "2 limits for 1"},
    {"empty limit",
     [](ModelSpec& s) {
       s.joints[1].limits = {LimitSpec{1, -1}};
     },
     "'joint1'", "lower must not exceed upper"},
    {"NaN limit",
     [](ModelSpec& s) {
       s.joints[1].limits = {LimitSpec{nan, 1}};
     },
     "'joint1'", "limit"},
    {"armature", [](ModelSpec& s) { s.joints[1].coordinates = {{.armature = -1}}; }, "'joint1'", "zero or positive"},
    {"friction", [](ModelSpec& s) { s.joints[1].coordinates = {{.friction_negative = -1}}; }, "'joint1'", "magnitude"},
    {"friction speed", [](ModelSpec& s) { s.joints[1].coordinates = {{.friction_speed = 0}}; }, "'joint1'",
     "must be positive"},
    {"damping NaN", [](ModelSpec& s) { s.joints[1].coordinates = {{.damping = nan}}; }, "'joint1'", "decimal value"},
    {"spring in a ball joint",
     [](ModelSpec& s) {
       set_kind(s.joints[1], "spherical"), s.joints[1].coordinates = {{.stiffness = 1}, {}, {}};
     },
     "'joint1'", "point spring"},
    {"unknown parent", [](ModelSpec& s) { s.joints[1].parent = "nobody"; }, "'nobody'", "mend the name"},
    {"unknown body", [](ModelSpec& s) { s.joints[1].body = "nobody"; }, "'nobody'", "mend the name"},
    {"two joints for a body", [](ModelSpec& s) { s.joints[1].body = "body0"; }, "'body0'", "one joint per body"},
    {"body without a joint", [](ModelSpec& s) { s.joints.pop_back(); }, "'body2'", "add one that carries it"},
    {"cycle of two", [](ModelSpec& s) { s.joints[1].parent = "body2", s.joints[2].parent = "body1"; }, "cycle",
     "a tree has none"},
    {"cycle of one", [](ModelSpec& s) { s.joints[1].parent = "body1"; }, "'body1'", "a tree has none"},
    {"nameless spring", [](ModelSpec& s) { s.springs = {spring("", "", "body0")}; }, "spring", "add name"},
    {"spring on nothing", [](ModelSpec& s) { s.springs = {spring("k", "", "nobody")}; }, "'nobody'", "mend the name"},
    {"spring on one body", [](ModelSpec& s) { s.springs = {spring("k", "body1", "body1")}; }, "'k'",
     "connect two bodies"},
    {"rest length", [](ModelSpec& s) { s.springs = {spring("k", "", "body1")}, s.springs[0].rest_length = -1; }, "'k'",
     "rest length"},
    {"spring NaN", [](ModelSpec& s) { s.springs = {spring("k", "", "body1")}, s.springs[0].point_b.x() = nan; }, "'k'",
     "decimal value"},
    {"wrench NaN",
     [](ModelSpec& s) {
       s.wrenches = {{"body1", {nan, 0, 0}, {0, 0, 0}, {}}};
     },
     "'body1'", "decimal value"},
    {"wrench on nothing",
     [](ModelSpec& s) {
       s.wrenches = {{"nobody", {0, 0, 0}, {0, 0, 0}, {}}};
     },
     "'nobody'", "mend the name"},
};

TEST(Model, refuses_every_bad_specification_naming_thing_and_mend) {
  ASSERT_NO_THROW(Model::build(good()));
  for (const Fault& fault : faults) {
    ModelSpec spec = good();
    fault.make(spec);
    try {
      Model::build(spec);
      ADD_FAILURE() << fault.what << " was accepted";
    } catch (const InputError& error) {
      const std::string message = error.what();
      EXPECT_NE(message.find(fault.thing), std::string::npos) << fault.what << ": " << message;
      EXPECT_NE(message.find(fault.mend), std::string::npos) << fault.what << ": " << message;
    }
  }
}

TEST(Model, names_file_and_line_where_there_are_any) {
  ModelSpec spec = good();
  spec.bodies[1].mass = -1;
  spec.bodies[1].place = {"arm.toml", 12, 3};
  try {
    Model::build(spec);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_EQ(std::string(error.what()).rfind("arm.toml:12:3: ", 0), 0u) << error.what();
  }
}

TEST(Model, takes_axes_of_any_length) {
  for (const double length : {1e-200, 1e-3, 1e200}) {
    ModelSpec spec = good();
    spec.joints[1].axis = Eigen::Vector3d(1, 2, 3) * length;
    EXPECT_NO_THROW(Model::build(spec));
  }
}

TEST(Model, knows_joint_frames_that_only_rename_the_axes_of_their_predecessor) {
  ModelSpec spec = good();
  for (int i = 0; i < 3; ++i) {
    spec.joints[i].parent = i == 0 ? "" : spec.bodies[i - 1].name;
    spec.joints[i].frame.rotation.setIdentity();
    spec.joints[i].axis2.reset();
  }
  const Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
  for (int first = 0; first < 3; ++first)
    for (int second = 0; second < 3; ++second) {
      spec.joints[0].axis = axes.col(0), spec.joints[1].axis = axes.col(first), spec.joints[2].axis = axes.col(second);
      const Model model = Model::build(spec);
      EXPECT_EQ(model.link(0).turn, FrameTurn::none) << "on the ground there is no product";
      // x of the joint's axes follows its axis z
      EXPECT_EQ(static_cast<int>(model.link(2).turn), (second - first + 3) % 3) << first << second;
    }
  spec.joints[2].axis = -axes.col(1);
  EXPECT_EQ(Model::build(spec).link(2).turn, FrameTurn::other);
  spec.joints[2].axis = Eigen::Vector3d(1, 1e-9, 0);
  EXPECT_EQ(Model::build(spec).link(2).turn, FrameTurn::other);
}

TEST(Model, accepts_nonphysical_inertia_only_when_told) {
  ModelSpec spec = good();
  spec.bodies[1].inertia = Eigen::Vector3d(1, 1, 3).asDiagonal();
  spec.bodies[1].allow_nonphysical_inertia = true;
  EXPECT_NO_THROW(Model::build(spec));
}

TEST(Model, puts_parents_before_children_whatever_the_order) {
  ModelSpec spec = good();
  spec.joints[0].parent = "body2", spec.joints[1].parent = "body0";
  const Model model = Model::build(spec);
  for (int i = 0; i < model.bodies(); ++i) {
    EXPECT_LT(model.link(i).parent, i);
    EXPECT_EQ(model.spec().joints[i].body, model.spec().bodies[i].name);
  }
  EXPECT_EQ(model.spec().bodies[0].name, "body2");
}

TEST(Model, names_velocities_positions_and_drives_by_joint_and_coordinate) {
  ModelSpec spec = good();
  set_kind(spec.joints[0], "planar");
  spec.joints[2].motion = ConstantSpeed{0, 1};
  const Model model = Model::build(spec);
  EXPECT_EQ(model.velocity_names(),
            (std::vector<std::string>{"joint0.x_rate", "joint0.y_rate", "joint0.angle_rate", "joint1.angle_rate"}));
  EXPECT_EQ(model.position_names(), (std::vector<std::string>{"joint0.x", "joint0.y", "joint0.angle", "joint1.angle"}));
  EXPECT_EQ(model.drive_names(), (std::vector<std::string>{"joint2.angle"}));
  EXPECT_EQ(model.find_body("body1"), 1);
  EXPECT_EQ(model.find_body("nobody"), std::nullopt);
}

TEST(Model, length_is_given_or_the_mean_distance_of_joints_or_one) {
  ModelSpec spec = good();
  for (int i = 0; i < 3; ++i) spec.joints[i].frame.position = {0, 0, i == 0 ? 0.0 : 1.0 + i};
  EXPECT_DOUBLE_EQ(Model::build(spec).length(), 2.5);
  spec.length = 7;
  EXPECT_DOUBLE_EQ(Model::build(spec).length(), 7);
  EXPECT_DOUBLE_EQ(Model::build(ModelSpec{}).length(), 1);
}

std::string refusal(const Model& model, const State<double>& state) {
  try {
    checked_state(model, state);
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(State, of_wrong_size_or_not_finite_or_not_normalised_is_refused) {
  ModelSpec spec = good();
  set_kind(spec.joints[1], "spherical");
  const Model model = Model::build(spec);
  const State<double> neutral = neutral_state(model);
  EXPECT_EQ(refusal(model, neutral), "accepted");
  State<double> s = neutral;
  s.q.pop_back();
  EXPECT_NE(refusal(model, s).find("q has 5 numbers, the model needs 6"), std::string::npos);
  s = neutral, s.v.push_back(0);
  EXPECT_NE(refusal(model, s).find("v has 6 numbers, the model needs 5"), std::string::npos);
  s = neutral, s.v[1] = nan;
  EXPECT_NE(refusal(model, s).find("joint1.wx"), std::string::npos);
  s = neutral, s.t = nan;
  EXPECT_NE(refusal(model, s).find("time"), std::string::npos);
  s = neutral, s.q[1] = 1.01;
  EXPECT_NE(refusal(model, s).find("'joint1'"), std::string::npos);
  s = neutral, s.q[1] = 0;
  EXPECT_NE(refusal(model, s).find("normalise"), std::string::npos);
}

TEST(State, is_normalised_exactly_when_it_is_nearly_so) {
  ModelSpec spec = good();
  set_kind(spec.joints[1], "spherical");
  const Model model = Model::build(spec);
  State<double> s = neutral_state(model);
  s.q[1] = 1 + 1e-7;
  EXPECT_EQ(checked_state(model, s).q[1], 1);
}

}  // namespace
}  // namespace lanc::test
