// The native format: what a file says is what the model gets.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <ctime>
#include <fstream>
#include <sstream>

#include "lib/io/mechanism.h"

namespace lanc {
namespace {

/// Two specifications say the same, places aside.
void expect_same(const ModelSpec& a, const ModelSpec& b) {
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.gravity, b.gravity);
  EXPECT_EQ(a.length, b.length);
  ASSERT_EQ(a.bodies.size(), b.bodies.size());
  for (std::size_t i = 0; i < a.bodies.size(); ++i) {
    const BodySpec &x = a.bodies[i], &y = b.bodies[i];
    EXPECT_EQ(std::tie(x.name, x.mass, x.allow_nonphysical_inertia),
              std::tie(y.name, y.mass, y.allow_nonphysical_inertia));
    EXPECT_EQ(x.com, y.com) << x.name;
    EXPECT_EQ(x.inertia, y.inertia) << x.name;
  }
  ASSERT_EQ(a.joints.size(), b.joints.size());
  for (std::size_t i = 0; i < a.joints.size(); ++i) {
    const JointSpec &x = a.joints[i], &y = b.joints[i];
    EXPECT_EQ(std::tie(x.name, x.kind, x.parent, x.body, x.pitch), std::tie(y.name, y.kind, y.parent, y.body, y.pitch));
    EXPECT_TRUE(x.frame.rotation.isApprox(y.frame.rotation, 1e-15)) << x.name << "\n" << x.frame.rotation;
    EXPECT_EQ(x.frame.position, y.frame.position) << x.name;
    EXPECT_EQ(x.axis, y.axis) << x.name;
    EXPECT_EQ(x.axis2, y.axis2) << x.name;
    ASSERT_EQ(x.coordinates.size(), y.coordinates.size()) << x.name;
    for (std::size_t k = 0; k < x.coordinates.size(); ++k) {
      const CoordinateSpec &c = x.coordinates[k], &d = y.coordinates[k];
      EXPECT_EQ(std::tie(c.stiffness, c.rest, c.damping, c.friction_positive, c.friction_negative, c.friction_speed,
                         c.torque, c.armature),
                std::tie(d.stiffness, d.rest, d.damping, d.friction_positive, d.friction_negative, d.friction_speed,
                         d.torque, d.armature))
          << x.name << " " << k;
    }
    ASSERT_EQ(x.limits.size(), y.limits.size()) << x.name;
    for (std::size_t k = 0; k < x.limits.size(); ++k) {
      ASSERT_EQ(x.limits[k].has_value(), y.limits[k].has_value());
      if (!x.limits[k]) continue;
      EXPECT_EQ(std::tie(x.limits[k]->lower, x.limits[k]->upper), std::tie(y.limits[k]->lower, y.limits[k]->upper));
    }
    ASSERT_EQ(x.motion.has_value(), y.motion.has_value()) << x.name;
    if (!x.motion) continue;
    ASSERT_EQ(x.motion->index(), y.motion->index()) << x.name;
    for (const double t : {0.0, 0.3, 0.9}) {
      const MotionSample s = PrescribedMotion::create(*x.motion)->at(t), r = PrescribedMotion::create(*y.motion)->at(t);
      EXPECT_EQ(std::tie(s.position, s.velocity, s.acceleration), std::tie(r.position, r.velocity, r.acceleration));
    }
  }
  ASSERT_EQ(a.springs.size(), b.springs.size());
  for (std::size_t i = 0; i < a.springs.size(); ++i) {
    const PointSpringSpec &x = a.springs[i], &y = b.springs[i];
    EXPECT_EQ(std::tie(x.name, x.body_a, x.body_b, x.stiffness, x.damping, x.rest_length),
              std::tie(y.name, y.body_a, y.body_b, y.stiffness, y.damping, y.rest_length));
    EXPECT_EQ(x.point_a, y.point_a);
    EXPECT_EQ(x.point_b, y.point_b);
  }
  ASSERT_EQ(a.wrenches.size(), b.wrenches.size());
  for (std::size_t i = 0; i < a.wrenches.size(); ++i) {
    EXPECT_EQ(a.wrenches[i].body, b.wrenches[i].body);
    EXPECT_EQ(a.wrenches[i].moment, b.wrenches[i].moment);
    EXPECT_EQ(a.wrenches[i].force, b.wrenches[i].force);
  }
}

BodySpec body(std::string name, double mass, Eigen::Vector3d com, Eigen::Vector3d inertia) {
  BodySpec b;
  b.name = std::move(name), b.mass = mass, b.com = com, b.inertia = inertia.asDiagonal();
  return b;
}

JointSpec joint(std::string name, std::string_view kind, std::string parent, std::string body) {
  JointSpec j;
  j.name = std::move(name), j.kind = *find_joint_kind(kind), j.parent = std::move(parent), j.body = std::move(body);
  return j;
}

/// The blocks between ```toml and ``` of the page users read.
std::vector<std::string> blocks_of_the_readme() {
  std::ifstream file(LANC_SOURCE_DIR "/data/models/README.md");
  std::vector<std::string> blocks;
  bool inside = false;
  for (std::string line; std::getline(file, line);) {
    if (line == "```toml")
      inside = true, blocks.emplace_back();
    else if (line == "```")
      inside = false;
    else if (inside)
      blocks.back() += line + "\n";
  }
  return blocks;
}

TEST(Toml, the_worked_example_of_the_readme_is_the_double_pendulum_it_describes) {
  ASSERT_FALSE(blocks_of_the_readme().empty());
  const Mechanism m = load_toml_text(blocks_of_the_readme()[0], "readme.toml");

  ModelSpec spec;
  spec.name = "driven double pendulum";
  spec.gravity = {0, 0, -9.81};
  spec.bodies = {body("upper", 1.5, {0, 0, -0.5}, {0.13, 0.13, 0.002}),
                 body("lower", 1.0, {0, 0, -0.4}, {0.05, 0.05, 0.001})};
  spec.bodies[1].inertia(0, 2) = spec.bodies[1].inertia(2, 0) = 0.0005;
  spec.joints = {joint("shoulder", "revolute", "", "upper"), joint("elbow", "revolute", "upper", "lower")};
  for (JointSpec& j : spec.joints) j.axis = Eigen::Vector3d(0, 1, 0);
  spec.joints[0].motion = Sine{0, 0.4, 3, 0};
  spec.joints[1].frame.position = {0, 0, -1};
  spec.joints[1].coordinates.resize(1);
  spec.joints[1].coordinates[0].damping = 0.05;
  spec.joints[1].coordinates[0].friction_positive = spec.joints[1].coordinates[0].friction_negative = 0.01;
  PointSpringSpec band;
  band.name = "band", band.body_b = "lower", band.point_a = {0.5, 0, -1}, band.point_b = {0, 0, -0.8};
  band.stiffness = 20, band.damping = 0.1, band.rest_length = 0.6;
  spec.springs = {band};
  expect_same(m.model.spec(), spec);
  EXPECT_EQ(m.state.t, 0.2);
  EXPECT_EQ(m.state.q, std::vector<double>{-0.3});
  EXPECT_EQ(m.state.v, std::vector<double>{1.0});
}

TEST(Toml, every_motion_of_the_readme_loads) {
  const auto blocks = blocks_of_the_readme();
  ASSERT_GE(blocks.size(), 2u);
  std::istringstream lines(blocks[1]);
  std::size_t index = 0;
  for (std::string line; std::getline(lines, line); ++index) {
    const Mechanism m = load_toml_text(
        "[[body]]\nname='b'\nmass=1\n[[joint]]\nname='j'\ntype='prismatic'\nbody='b'\n" + line + "\n", "m");
    EXPECT_EQ(m.model.spec().joints[0].motion->index(), index) << line;
  }
  EXPECT_EQ(index, std::variant_size_v<MotionSpec>);
}

TEST(Toml, every_key_reaches_the_specification) {
  const Mechanism m = load_toml_text(R"(
name = "all"
gravity = [1, 2, 3]
length = 0.7
[[joint]]    # before its body, child before parent: order is free
name = "table"
type = "planar"
parent = "b1"
body = "b2"
position = [1, 2.5, 3]
quaternion = [0.5, 0.5, 0.5, 0.5]
axis = [0, 0, 3]
axis2 = [0, 2, 0]
stiffness = [1, 2, 3]
rest = [4, 5, 6]
damping = [7, 8, 9]
friction = [0.1, { positive = 0.2, negative = 0.3 }, 0]
friction_speed = [0.01, 0.02, 0.03]
torque = [10, 11, 12]
armature = [13, 14, 15]
limits = [[-1, 1], [], [0, 2]]
[[joint]]
name = "screw"
type = "helical"
body = "b1"
rpy = [0, 0, 1.5707963267948966]
pitch = -0.1
damping = [2]
limits = [-1, 1e3]
motion = { type = "spline", times = [0, 1, 2, 3], values = [0, 1, 0, 1] }
[[body]]
name = "b1"
mass = 1
com = [1, 2, 3]
inertia = { xx = 2, yy = 3, zz = 4, xy = 0.1, xz = 0.2, yz = 0.3 }
[[body]]
name = "b2"
mass = 0
inertia = [-1, 5, 1]
allow_nonphysical_inertia = true
[[spring]]
name = "s"
body_a = "b1"
body_b = "ground"
point_a = [1, 0, 0]
point_b = [0, 1, 0]
stiffness = 1
damping = 2
rest_length = 3
[[wrench]]
body = "b2"
moment = [1, 2, 3]
force = [4, 5, 6]
)",
                                     "all.toml");
  ModelSpec spec;
  spec.name = "all", spec.gravity = {1, 2, 3}, spec.length = 0.7;
  spec.bodies = {body("b1", 1, {1, 2, 3}, {2, 3, 4}), body("b2", 0, {0, 0, 0}, {-1, 5, 1})};
  Eigen::Matrix3d& I = spec.bodies[0].inertia;
  I(0, 1) = I(1, 0) = 0.1, I(0, 2) = I(2, 0) = 0.2, I(1, 2) = I(2, 1) = 0.3;
  spec.bodies[1].allow_nonphysical_inertia = true;
  spec.joints = {joint("screw", "helical", "", "b1"), joint("table", "planar", "b1", "b2")};
  JointSpec &screw = spec.joints[0], &table = spec.joints[1];
  screw.frame.rotation << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  screw.pitch = -0.1;
  screw.coordinates.resize(1);
  screw.coordinates[0].damping = 2;
  screw.limits = {LimitSpec{-1, 1e3}};
  screw.motion = SplineTable{{0, 1, 2, 3}, {0, 1, 0, 1}};
  table.frame.position = {1, 2.5, 3};
  table.frame.rotation << 0, 0, 1, 1, 0, 0, 0, 1, 0;
  table.axis = Eigen::Vector3d(0, 0, 3), table.axis2 = Eigen::Vector3d(0, 2, 0);
  table.coordinates = {
      {1, 4, 7, 0.1, 0.1, 0.01, 10, 13}, {2, 5, 8, 0.2, 0.3, 0.02, 11, 14}, {3, 6, 9, 0, 0, 0.03, 12, 15}};
  table.limits = {LimitSpec{-1, 1}, std::nullopt, LimitSpec{0, 2}};
  PointSpringSpec spring;
  spring.name = "s", spring.body_a = "b1", spring.point_a = {1, 0, 0}, spring.point_b = {0, 1, 0};
  spring.stiffness = 1, spring.damping = 2, spring.rest_length = 3;
  spec.springs = {spring};
  spec.wrenches = {{"b2", {1, 2, 3}, {4, 5, 6}}};
  expect_same(m.model.spec(), spec);
}

TEST(Toml, roll_pitch_and_yaw_turn_about_fixed_axes_in_this_order) {
  const Mechanism m = load_toml_text(
      "[[body]]\nname='b'\nmass=1\n[[joint]]\nname='j'\ntype='fixed'\nbody='b'\nrpy=[0.3, -0.4, 1.2]\n", "rpy");
  const Eigen::Matrix3d R = m.model.spec().joints[0].frame.rotation;
  const double cr = cos(0.3), sr = sin(0.3), cp = cos(-0.4), sp = sin(-0.4), cy = cos(1.2), sy = sin(1.2);
  Eigen::Matrix3d expected;
  expected << cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr,  //
      sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr,          //
      -sp, cp * sr, cp * cr;
  EXPECT_TRUE(R.isApprox(expected, 1e-15)) << R;
}

TEST(Toml, a_byte_order_mark_and_windows_line_ends_change_nothing) {
  const std::string text = "name = \"n\"\n[[body]]\nname='b'\nmass=1\n[[joint]]\nname='j'\ntype='free'\nbody='b'\n";
  std::string windows = "\xEF\xBB\xBF";
  for (const char c : text) windows += c == '\n' ? std::string("\r\n") : std::string(1, c);
  expect_same(load_toml_text(windows, "w").model.spec(), load_toml_text(text, "u").model.spec());
}

TEST(Toml, a_quaternion_in_the_state_is_normalised_exactly) {
  const Mechanism m = load_toml_text(
      "[[body]]\nname='b'\nmass=1\n[[joint]]\nname='j'\ntype='spherical'\nbody='b'\n"
      "[state]\nq.j=[0.7071068, 0.7071068, 0, 0]\n",
      "ball");
  EXPECT_DOUBLE_EQ(m.state.q[0], std::sqrt(0.5));
}

TEST(Toml, a_model_without_a_name_is_called_like_its_file) {
  EXPECT_EQ(load_toml_text("[[body]]\nname='b'\nmass=1\n[[joint]]\nname='j'\ntype='free'\nbody='b'\n", "some/arm.toml")
                .model.name(),
            "arm");
}

TEST(Toml, a_chain_of_many_bodies_loads_in_time_linear_in_their_number) {
  constexpr int n = 20000;
  std::string text;
  for (int i = 0; i < n; ++i)
    text += fmt::format(
        "[[body]]\nname = 'b{0}'\nmass = 1.25\ncom = [0.1, 0.2, 0.3]\ninertia = [0.1, 0.1, 0.1]\n"
        "[[joint]]\nname = 'j{0}'\ntype = 'revolute'\nparent = '{1}'\nbody = 'b{0}'\nposition = [0.1, 0, 0]\n",
        i, i == 0 ? "ground" : fmt::format("b{}", i - 1));
  text += "[state.q]\n";
  for (int i = 0; i < n; ++i) text += fmt::format("j{} = 0.5\n", i);
  const std::clock_t start = std::clock();
  const Mechanism m = load_toml_text(text, "chain");
  const double seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  std::printf("%.1f MB, %d bodies, %.2f s\n", text.size() / 1e6, n, seconds);
  EXPECT_EQ(m.model.nv(), n);
  EXPECT_EQ(m.state.q[n - 1], 0.5);
  EXPECT_LT(seconds, 30);  // a quadratic reader takes minutes
}

}  // namespace
}  // namespace lanc
