// URDF: what becomes of its parts, and real robot descriptions where they are at hand.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <clocale>
#include <cstdlib>
#include <filesystem>
#include <locale>

#include "lib/formulation/formulation.h"
#include "lib/io/mechanism.h"
#include "lib/system/evaluator.h"
#include "tests/support/tolerance.h"

namespace lanc {
namespace {

const std::string inertial = R"(<inertial><origin xyz="0.1 0.2 0.3"/><mass value="2"/>
  <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>)";

/// A robot of the links a (root, without inertia) and b on one joint with `inside`.
Mechanism one_joint(const std::string& type, const std::string& inside) {
  return load_urdf_text(fmt::format("<robot name='r'><link name='a'/><link name='b'>{}</link><joint name='j' type='{}'>"
                                    "<parent link='a'/><child link='b'/>{}</joint></robot>",
                                    inertial, type, inside),
                        "r.urdf");
}

const std::string limit = "<limit lower='-1' upper='2' effort='1' velocity='1'/>";

TEST(Urdf, joint_types_become_joint_kinds) {
  const std::pair<const char*, const char*> kinds[] = {{"revolute", "revolute"},   {"continuous", "revolute"},
                                                       {"prismatic", "prismatic"}, {"fixed", "fixed"},
                                                       {"floating", "free"},       {"planar", "planar"}};
  for (const auto& kind : kinds)
    EXPECT_EQ(one_joint(kind.first, limit).model.link(0).kind.traits().name, kind.second) << kind.first;
}

TEST(Urdf, a_joint_keeps_its_frame_axis_limits_damping_and_friction) {
  const Mechanism m = one_joint("revolute", limit + R"(<origin xyz="1 2 3" rpy="0.3 -0.4 1.2"/><axis xyz="0 0.6 0.8"/>
    <dynamics damping="0.5" friction="0.25"/>)");
  const JointSpec& j = m.model.spec().joints[0];
  EXPECT_EQ(j.frame.position, Eigen::Vector3d(1, 2, 3));
  const double cr = cos(0.3), sr = sin(0.3), cp = cos(-0.4), sp = sin(-0.4), cy = cos(1.2), sy = sin(1.2);
  Eigen::Matrix3d expected;
  expected << cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr,  //
      sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr,          //
      -sp, cp * sr, cp * cr;
  EXPECT_TRUE(j.frame.rotation.isApprox(expected, 1e-15)) << j.frame.rotation;
  EXPECT_EQ(*j.axis, Eigen::Vector3d(0, 0.6, 0.8));
  ASSERT_EQ(j.limits.size(), 1u);
  EXPECT_EQ(j.limits[0]->lower, -1);
  EXPECT_EQ(j.limits[0]->upper, 2);
  ASSERT_EQ(j.coordinates.size(), 1u);
  EXPECT_EQ(j.coordinates[0].damping, 0.5);
  EXPECT_EQ(j.coordinates[0].friction_positive, 0.25);
  EXPECT_EQ(j.coordinates[0].friction_negative, 0.25);
}

TEST(Urdf, a_joint_without_an_axis_turns_about_x_and_a_continuous_one_has_no_limits) {
  const Mechanism m = one_joint("continuous", limit);
  EXPECT_EQ(*m.model.spec().joints[0].axis, Eigen::Vector3d(1, 0, 0));
  EXPECT_TRUE(m.model.spec().joints[0].limits.empty());
}

TEST(Urdf, the_inertia_is_turned_from_the_inertial_frame_into_the_body) {
  const Mechanism m = load_urdf_text(R"(<robot name="r"><link name="b"><inertial>
    <origin xyz="0.1 0 0" rpy="0 0 1.5707963267948966"/><mass value="2"/>
    <inertia ixx="1" ixy="0.1" ixz="0" iyy="2" iyz="0" izz="2.5"/></inertial></link></robot>)",
                                     "turned");
  // x of the inertial frame is y of the body, y is −x: the entry xy changes its sign
  Eigen::Matrix3d expected;
  expected << 2, -0.1, 0, -0.1, 1, 0, 0, 0, 2.5;
  EXPECT_TRUE(m.model.spec().bodies[0].inertia.isApprox(expected, 1e-15)) << m.model.spec().bodies[0].inertia;
  EXPECT_EQ(m.model.spec().bodies[0].com, Eigen::Vector3d(0.1, 0, 0));
}

TEST(Urdf, a_root_link_without_inertia_is_ground_and_one_with_inertia_is_welded_to_it) {
  const Mechanism bare = one_joint("continuous", "");
  ASSERT_EQ(bare.model.bodies(), 1);
  EXPECT_EQ(bare.model.link(0).parent, ground);
  const Mechanism heavy =
      load_urdf_text(fmt::format("<robot name='r'><link name='root'>{}</link></robot>", inertial), "heavy");
  ASSERT_EQ(heavy.model.bodies(), 1);
  EXPECT_EQ(heavy.model.nv(), 0);
  EXPECT_EQ(heavy.model.spec().joints[0].name, "root_to_ground");
  EXPECT_EQ(heavy.model.spec().bodies[0].mass, 2);
}

TEST(Urdf, bodies_stand_in_the_order_of_the_file) {
  const Mechanism m = load_urdf_text(R"(<robot name="r"><link name="w"/><link name="z"/><link name="a"/><link name="m"/>
    <joint name="1" type="fixed"><parent link="w"/><child link="m"/></joint>
    <joint name="2" type="fixed"><parent link="w"/><child link="a"/></joint>
    <joint name="3" type="fixed"><parent link="w"/><child link="z"/></joint></robot>)",
                                     "order");
  EXPECT_EQ(m.model.spec().bodies[0].name, "z");
  EXPECT_EQ(m.model.spec().bodies[1].name, "a");
  EXPECT_EQ(m.model.spec().bodies[2].name, "m");
}

TEST(Urdf, the_gravity_urdf_does_not_state_is_that_of_earth_along_minus_z) {
  EXPECT_EQ(one_joint("fixed", "").model.spec().gravity, Eigen::Vector3d(0, 0, -9.81));
}

TEST(Urdf, an_inertia_no_body_can_have_is_accepted_when_the_link_says_so) {
  const Mechanism m = load_urdf_text(R"(<robot name="r"><link name="b"><inertial allow_nonphysical_inertia="true">
    <mass value="2"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="9"/></inertial></link></robot>)",
                                     "odd");
  EXPECT_TRUE(m.model.spec().bodies[0].allow_nonphysical_inertia);
}

TEST(Urdf, names_with_special_characters_survive) {
  const Mechanism m = load_urdf_text(
      "<robot name='r &amp; s'><link name='w'/><link name='Grüße &lt;1&gt; \"2\"'/><joint name=\"it's\" type='fixed'>"
      "<parent link='w'/><child link='Grüße &lt;1&gt; \"2\"'/></joint></robot>",
      "special");
  EXPECT_EQ(m.model.name(), "r & s");
  EXPECT_EQ(m.model.spec().bodies[0].name, "Grüße <1> \"2\"");
  EXPECT_EQ(m.model.spec().joints[0].name, "it's");
}

TEST(Urdf, numbers_do_not_depend_on_the_locale) {
  const char* previous = nullptr;
  for (const char* name : {"de_DE.UTF-8", "de_DE.utf8", "fr_FR.UTF-8"})
    if (!previous) previous = std::setlocale(LC_ALL, name);
  struct Comma : std::numpunct<char> {
    char do_decimal_point() const override { return ','; }
  };
  const std::locale old = std::locale::global(std::locale(std::locale::classic(), new Comma));
  const Mechanism m = one_joint("revolute", limit + "<origin xyz='0.5 1.25 -3e-2'/>");
  const Mechanism t = load_toml_text(
      "gravity=[0.5, 1.25, -3e-2]\n[[body]]\nname='b'\nmass=1\n[[joint]]\nname='j'\ntype='free'\nbody='b'\n", "t");
  std::locale::global(old);
  std::setlocale(LC_ALL, "C");
  EXPECT_EQ(m.model.spec().joints[0].frame.position, Eigen::Vector3d(0.5, 1.25, -3e-2));
  EXPECT_EQ(m.model.spec().bodies[0].com, Eigen::Vector3d(0.1, 0.2, 0.3));
  EXPECT_EQ(t.model.spec().gravity, Eigen::Vector3d(0.5, 1.25, -3e-2));
}

TEST(Urdf, a_chain_of_many_links_does_not_overflow_the_stack) {
  constexpr int n = 300000;  // urdfdom's own destructor overflows at this length
  std::string text = "<robot name='long'><link name='l000000'/>";
  for (int i = 1; i <= n; ++i)
    text += fmt::format(
        "<link name='l{0:06}'/><joint name='{0}' type='fixed'><parent link='l{1:06}'/><child link='l{0:06}'/></joint>",
        i, i - 1);
  EXPECT_EQ(load_urdf_text(text + "</robot>", "long").model.bodies(), n);
}

std::string published(const std::string& file) {
  const char* given = std::getenv("LANC_ROBOTS");
  return std::string(given ? given : LANC_SOURCE_DIR "/../shared/models") + "/" + file;
}

/// Published robots, not ours to copy: in LANC_ROBOTS, or in a folder beside the source tree.
struct Robot {
  const char* file;
  int bodies, nv;
  double mass;
};
class PublishedRobot : public testing::TestWithParam<Robot> {};

TEST_P(PublishedRobot, has_the_bodies_and_the_mass_of_its_file_and_can_be_solved) {
  const std::string path = published(GetParam().file);
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not there; set LANC_ROBOTS to a folder that has it";
  const Mechanism m = load_mechanism(path);
  EXPECT_EQ(m.model.bodies(), GetParam().bodies);
  EXPECT_EQ(m.model.nv(), GetParam().nv);
  double mass = 0;
  for (const BodySpec& body : m.model.spec().bodies) mass += body.mass;
  EXPECT_NEAR(mass, GetParam().mass, 1e-12);
  Evaluator<double> evaluator(m.model);
  Solution<double> solution(m.model);
  const Outcome outcome =
      find_formulation("recursive")->create_double(m.model)->solve(evaluator.system(m.state), solution);
  EXPECT_EQ(to_string(outcome.status), "solved");
}

INSTANTIATE_TEST_SUITE_P(Urdf, PublishedRobot,
                         testing::Values(Robot{"ur5_robot.urdf", 10, 6, 4.0 + 3.7 + 8.393 + 2.275 + 1.219 * 2 + 0.1879},
                                         Robot{"double_pendulum_simple.urdf", 4, 2, 0.6}),
                         [](const auto& info) {
                           return std::string(info.param.file).substr(0, std::string(info.param.file).find('.'));
                         });

TEST(Urdf, the_published_panda_hand_has_a_finger_that_mimics) {
  const std::string path = published("panda.urdf");
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not there; set LANC_ROBOTS to a folder that has it";
  const Mechanism m = load_mechanism(path);
  ASSERT_EQ(m.model.spec().couplers.size(), 1u);
  EXPECT_EQ(m.model.spec().couplers[0].name, "panda_finger_joint2_mimic");
  EXPECT_EQ(m.model.spec().couplers[0].terms.at(1).joint, "panda_finger_joint1");
}

}  // namespace
}  // namespace lanc
