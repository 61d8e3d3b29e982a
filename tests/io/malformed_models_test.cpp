// Bad model files: each is an error that says where, what and how to mend it; never a crash, a hang or another model.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <ctime>
#include <filesystem>
#include <fstream>

#include "lib/io/mechanism.h"

namespace lanc {
namespace {

struct Bad {
  std::string name, text;
  std::string place;                   // "line:column" (URDF: line) the message begins with, behind the file
  std::vector<std::string> fragments;  // what the message must contain
};

const std::string body_b = "[[body]]\nname='b'\nmass=1\n";                       // lines 1 to 3
const std::string joint_j = "[[joint]]\nname='j'\ntype='revolute'\nbody='b'\n";  // lines 4 to 7
const std::string fine = body_b + joint_j;                                       // the next line is 8

std::string with_body(const std::string& lines) { return body_b + lines + joint_j; }  // the next line is 4
std::string repeated(const std::string& piece, std::size_t count) {
  std::string text;
  for (std::size_t k = 0; k < count; ++k) text += piece;
  return text;
}

const Bad bad_toml[] = {
    {"empty_text", "", "1:1", {"no body", "[[body]]"}},
    {"no_body", "name='n'\ngravity=[0,0,-9.81]\n", "1:1", {"no body"}},
    {"not_toml", "name = 'n'\nthis is not toml\n", "2:6", {"not TOML"}},
    {"unclosed_string", "name = 'n\nx=1", "1:10", {"not TOML"}},
    {"duplicate_key", "name='n'\nname='m'\n", "2:6", {"not TOML", "name"}},
    {"urdf_in_a_toml_file", "<?xml version='1.0'?>\n<robot/>\n", "1:1", {"not TOML"}},
    {"bytes_that_are_no_utf8", "name = '\xff\xfe'\n", "1:", {"not TOML", "utf-8"}},
    {"binary_zeros", std::string(1000, '\0'), "1:1", {"not TOML"}},
    {"a_zero_behind_the_model", fine + std::string(1, '\0'), "8:1", {"not TOML"}},
    {"deep_arrays", "x = " + repeated("[", 100000), "1:", {"not TOML"}},
    {"deep_tables", "x = " + repeated("{a=", 100000), "1:", {"not TOML"}},
    {"deep_headers", repeated("[", 100000), "1:", {"not TOML"}},
    {"deep_dotted_key", repeated("a.", 1000000) + "a = 1\n", "1:", {"dotted parts"}},
    {"deep_dotted_header", "[" + repeated("a.", 1000000) + "a]\n", "1:", {"dotted parts"}},
    {"deep_quoted_header", "[" + repeated("'a'.", 1000000) + "a]\n", "1:", {"dotted parts"}},
    {"unknown_key_at_the_top",
     "gravty = [0, 0, 1]\n" + fine,
     "1:1",
     {"unknown key 'gravty'", "did you mean 'gravity'?"}},
    {"unknown_table", "[[bodies]]\nname='b'\n", "1:3", {"unknown key 'bodies'", "body, joint, closure"}},
    {"unknown_key_of_a_body",
     with_body("inertai=[1,1,1]\n"),
     "4:1",
     {"body 'b'", "'inertai'", "did you mean 'inertia'?"}},
    {"unknown_key_of_a_joint", fine + "dampng=1\n", "8:1", {"joint 'j'", "'dampng'", "did you mean 'damping'?"}},
    {"unknown_key_of_a_motion",
     fine + "motion={type='sine', amplitude=1, frequency=1, phse=0}\n",
     "8:",
     {"'phse'", "'phase'"}},
    {"unknown_key_without_a_near_one", with_body("colour='red'\n"), "4:1", {"'colour'", "name, mass, com"}},
    {"unknown_key_of_the_state", fine + "[state]\nu.j=1\n", "9:1", {"state", "'u'", "t, q, v"}},
    {"body_without_name", "[[body]]\nmass=1\n", "1:1", {"a body", "name is missing"}},
    {"empty_name", "[[body]]\nname=''\n", "2:6", {"empty"}},
    {"name_too_long", "[[body]]\nname='" + std::string(1000000, 'x') + "'\n", "2:6", {"longer than 255"}},
    {"name_with_line_end", "[[body]]\nname=\"a\\nb\"\n", "2:6", {"control character"}},
    {"body_called_ground", "[[body]]\nname='ground'\nmass=1\n", "1:1", {"'ground'", "choose another"}},
    {"body_without_mass", "[[body]]\nname='b'\n" + joint_j, "1:1", {"body 'b'", "mass is missing"}},
    {"joint_without_type", body_b + "[[joint]]\nname='j'\nbody='b'\n", "4:1", {"joint 'j'", "type is missing"}},
    {"joint_without_body", body_b + "[[joint]]\nname='j'\ntype='free'\n", "4:1", {"joint 'j'", "body is missing"}},
    {"wrong_type_string", "[[body]]\nname='b'\nmass='1'\n", "3:6", {"body 'b'", "mass must be a number", "a string"}},
    {"wrong_type_flag", with_body("allow_nonphysical_inertia=1\n"), "4:27", {"true or false", "an integer"}},
    {"wrong_type_array", with_body("com=1\n"), "4:5", {"com must be an array of numbers", "an integer"}},
    {"wrong_type_entry", with_body("com=[1,'x',3]\n"), "4:8", {"com must be a number", "a string"}},
    {"wrong_type_table", fine + "motion=3\n", "8:8", {"motion must be a table"}},
    {"wrong_type_list", "body=3\n", "1:6", {"body must be a list of tables", "[[body]]"}},
    {"single_bracket_table", "[body]\nname='b'\n", "1:1", {"[[body]]"}},
    {"a_date_for_a_number", with_body("com=[2020-01-01,0,0]\n"), "4:6", {"a date or time"}},
    {"vector_of_two", with_body("com=[1,2]\n"), "4:5", {"3 numbers", "not 2"}},
    {"nan_mass", "[[body]]\nname='b'\nmass=nan\n", "3:6", {"body 'b'", "mass", "finite"}},
    {"infinite_gravity", "gravity=[0,0,-inf]\n" + fine, "1:14", {"gravity", "finite"}},
    {"huge_number", "[[body]]\nname='b'\nmass=1e999\n", "3:", {"1e999"}},
    {"huge_integer", "[[body]]\nname='b'\nmass=99999999999999999999\n", "3:", {"not TOML"}},
    {"negative_mass", "[[body]]\nname='b'\nmass=-1\n" + joint_j, "1:1", {"body 'b'", "negative mass"}},
    {"negative_inertia",
     with_body("inertia=[-1,1,1]\n"),
     "1:1",
     {"body 'b'", "negative principal", "allow_nonphysical"}},
    {"non_triangle_inertia", with_body("inertia=[1,1,3]\n"), "1:1", {"body 'b'", "triangle"}},
    {"inertia_of_four", with_body("inertia=[1,1,1,0]\n"), "4:9", {"[xx, yy, zz]", "not 4"}},
    {"inertia_without_zz", with_body("inertia={xx=1,yy=1}\n"), "4:9", {"zz is missing"}},
    {"inertia_with_a_word", with_body("inertia={xx=1,yy=1,zz=1,xz='a'}\n"), "4:28", {"inertia", "xz", "number"}},
    {"duplicate_body", body_b + body_b + joint_j, "4:1", {"two bodies", "'b'"}},
    {"duplicate_joint", fine + joint_j, "8:1", {"'j'"}},
    {"unknown_parent", fine + "parent='bb'\n", "4:1", {"joint 'j'", "no body 'bb'"}},
    {"unknown_body_of_a_joint", body_b + "[[joint]]\nname='j'\ntype='free'\nbody='x'\n", "4:1", {"no body 'x'"}},
    {"body_without_joint", body_b, "1:1", {"body 'b'", "no joint"}},
    {"two_joints_to_one_body", fine + "[[joint]]\nname='k'\ntype='fixed'\nbody='b'\n", "8:1", {"'k'", "'b'", "'j'"}},
    {"cycle",
     body_b + "[[body]]\nname='c'\nmass=1\n[[joint]]\nname='j'\ntype='fixed'\nparent='c'\nbody='b'\n"
              "[[joint]]\nname='k'\ntype='fixed'\nparent='b'\nbody='c'\n",
     "7:1",
     {"cycle"}},
    {"cycle_of_one", fine + "parent='b'\n", "4:1", {"cycle"}},
    {"unknown_joint_type",
     body_b + "[[joint]]\nname='j'\ntype='revolut'\nbody='b'\n",
     "6:6",
     {"'revolut'", "did you mean 'revolute'?"}},
    {"joint_type_unlike_any",
     body_b + "[[joint]]\nname='j'\ntype='magic'\nbody='b'\n",
     "6:6",
     {"'magic'", "one of fixed, revolute"}},
    {"zero_axis", fine + "axis=[0,0,0]\n", "4:1", {"joint 'j'", "axis is zero"}},
    {"axis_of_a_joint_that_has_none",
     body_b + "[[joint]]\nname='j'\ntype='free'\nbody='b'\naxis=[1,0,0]\n",
     "4:1",
     {"no axis"}},
    {"oblique_axes",
     body_b + "[[joint]]\nname='j'\ntype='universal'\nbody='b'\naxis=[1,0,0]\naxis2=[1,1,0]\n",
     "4:1",
     {"perpendicular"}},
    {"pitch_of_a_revolute_joint", fine + "pitch=1\n", "4:1", {"no pitch"}},
    {"quaternion_and_rpy", fine + "quaternion=[1,0,0,0]\nrpy=[0,0,0]\n", "9:5", {"keep one"}},
    {"quaternion_of_three", fine + "quaternion=[1,0,0]\n", "8:12", {"4 numbers", "not 3"}},
    {"long_quaternion", fine + "quaternion=[1,1,0,0]\n", "8:12", {"length 1.414", "normalise"}},
    {"zero_quaternion", fine + "quaternion=[0,0,0,0]\n", "8:12", {"length 0", "normalise"}},
    {"number_for_many_freedoms",
     body_b + "[[joint]]\nname='j'\ntype='planar'\nbody='b'\ndamping=1\n",
     "8:9",
     {"array of 3", "x_rate"}},
    {"array_of_wrong_length",
     body_b + "[[joint]]\nname='j'\ntype='cylindrical'\nbody='b'\nstiffness=[1,2,3]\n",
     "8:11",
     {"array of 2", "not 3"}},
    {"damping_of_a_weld", body_b + "[[joint]]\nname='j'\ntype='fixed'\nbody='b'\ndamping=1\n", "8:9", {"no velocity"}},
    {"friction_of_one_direction", fine + "friction={positive=1}\n", "8:10", {"negative is missing"}},
    {"negative_friction", fine + "friction=-1\n", "4:1", {"negative friction"}},
    {"negative_damping", fine + "damping=-0.5\n", "4:1", {"joint 'j'", "negative damping -0.5", "positive value"}},
    {"negative_spring_damping",
     fine + "[[spring]]\nname='s'\nbody_a='b'\ndamping=-2\n",
     "8:1",
     {"spring 's'", "negative damping"}},
    {"friction_speed_zero", fine + "friction_speed=0\n", "4:1", {"friction_speed"}},
    {"negative_armature", fine + "armature=-1\n", "4:1", {"negative armature"}},
    {"spring_of_a_ball_joint",
     body_b + "[[joint]]\nname='j'\ntype='spherical'\nbody='b'\nstiffness=[1,1,1]\n",
     "4:1",
     {"Euler parameters"}},
    {"limits_crossed", fine + "limits=[1,-1]\n", "4:1", {"limit"}},
    {"limits_of_three", fine + "limits=[1,2,3]\n", "8:8", {"[lower, upper]"}},
    {"limits_of_one_of_two",
     body_b + "[[joint]]\nname='j'\ntype='cylindrical'\nbody='b'\nlimits=[0,1]\n",
     "8:9",
     {"limits"}},
    {"motion_without_type", fine + "motion={rate=1}\n", "8:8", {"needs a type", "constant-speed"}},
    {"motion_of_unknown_type", fine + "motion={type='sin'}\n", "8:14", {"needs a type", "did you mean 'sine'?"}},
    {"motion_without_rate", fine + "motion={type='constant-speed'}\n", "8:8", {"rate is missing"}},
    {"motion_of_two_freedoms",
     body_b + "[[joint]]\nname='j'\ntype='cylindrical'\nbody='b'\nmotion={type='constant-speed',rate=1}\n",
     "4:1",
     {"cannot be prescribed"}},
    {"formula_broken",
     fine + "motion={type='expression',formula='2*(t'}\n",
     "4:1",
     {"joint 'j'", "character 5", "parenthesis"}},
    {"formula_of_unknown_name", fine + "motion={type='expression',formula='foo(t)'}\n", "4:1", {"unknown name 'foo'"}},
    {"formula_deep",
     fine + "motion={type='expression',formula='" + std::string(4000, '(') + "'}\n",
     "4:1",
     {"nesting"}},
    {"formula_long", fine + "motion={type='expression',formula='" + repeated("1+", 1000000) + "1'}\n", "4:1", {"4096"}},
    {"spline_of_three", fine + "motion={type='spline',times=[0,1,2],values=[0,1,2]}\n", "4:1", {"four"}},
    {"spline_not_increasing", fine + "motion={type='spline',times=[0,1,1,2],values=[0,1,2,3]}\n", "4:1", {"increase"}},
    {"polynomial_empty", fine + "motion={type='polynomial',coefficients=[]}\n", "4:1", {"coefficient"}},
    {"spring_to_nowhere", fine + "[[spring]]\nname='s'\nbody_a='x'\n", "8:1", {"spring 's'", "no body 'x'"}},
    {"spring_on_one_body", fine + "[[spring]]\nname='s'\nbody_a='b'\nbody_b='b'\n", "8:1", {"same body"}},
    {"wrench_on_ground", fine + "[[wrench]]\nbody='ground'\n", "8:1", {"ground"}},
    {"wrench_on_nothing", fine + "[[wrench]]\nbody='x'\n", "8:1", {"no body 'x'"}},
    {"zero_length", "length=0\n" + fine, "1:1", {"length", "positive"}},
    {"state_of_unknown_joint", fine + "[state]\nq.k=1\n", "9:", {"'k'"}},
    {"wrong_length_of_q", fine + "[state]\nq.j=[1,2]\n", "9:5", {"joint 'j'", "1 numbers (angle)", "not 2"}},
    {"wrong_length_of_v",
     body_b + "[[joint]]\nname='j'\ntype='free'\nbody='b'\n[state]\nv.j=[1,2]\n",
     "9:5",
     {"6 numbers", "wx"}},
    {"q_of_a_prescribed_joint",
     fine + "motion={type='constant-speed',rate=1}\n[state]\nq.j=1\n",
     "10:5",
     {"joint 'j'", "prescribed"}},
    {"euler_parameters_not_normalised",
     body_b + "[[joint]]\nname='j'\ntype='spherical'\nbody='b'\n[state]\nq.j=[1,1,0,0]\n",
     "9:",
     {"'j'", "length", "normalise"}},
    {"nan_in_q", fine + "[state]\nq.j=nan\n", "9:5", {"q of joint 'j'", "finite"}},
    {"q_that_is_no_table", fine + "[state]\nq=[1]\n", "9:3", {"q must be a table"}},
};

const std::string inertia = "<inertia ixx='1' ixy='0' ixz='0' iyy='1' iyz='0' izz='1'/>";
std::string robot(const std::string& inside) {
  return "<robot name='r'>\n<link name='a'/>\n<link name='b'/>\n" + inside + "</robot>";
}
std::string link(const std::string& inside) {
  return "<robot name='r'>\n<link name='a'>\n<inertial>\n" + inside + "\n</inertial>\n</link></robot>";
}
std::string joint(const std::string& type, const std::string& inside) {
  return robot("<joint name='j' type='" + type + "'>\n<parent link='a'/>\n<child link='b'/>\n" + inside +
               "\n</joint>\n");  // inside: line 7
}

const Bad bad_urdf[] = {
    {"empty_text", "", "1", {"well-formed", "empty"}},
    {"no_markup", "hello\n", "1", {}},
    {"broken_xml", "<robot name='r'>\n<link name='a'>\n</robot>", "2", {"well-formed", "mismatched"}},
    {"unclosed", "<robot name='r'>\n<link", "2", {"well-formed"}},
    {"binary_zeros", std::string(1000, '\0'), "1", {"zero byte"}},
    {"a_zero_behind_the_model", robot("") + std::string(1, '\0'), "4", {"zero byte"}},
    {"deep_nesting", "<robot name='r'>" + repeated("<link>", 100000), "1", {"well-formed", "depth"}},
    {"toml_in_a_urdf_file", "name = 'r'\n", "1", {}},
    {"another_root_element", "<sdf/>", "1", {"<sdf>", "<robot>"}},
    {"two_robots", "<robot name='r'><link name='a'/></robot>\n<robot name='s'/>", "2", {"outside"}},
    {"text_behind_the_robot", "<robot name='r'><link name='a'/></robot>\ngarbage", "2", {}},
    {"robot_without_name", "<robot><link name='a'/></robot>", "1", {"no name"}},
    {"no_link", "<robot name='r'>\n</robot>", "1", {"no link"}},
    {"nothing_but_ground", "<robot name='r'><link name='a'/></robot>", "", {"no link with inertia"}},
    {"link_without_name", "<robot name='r'>\n<link/></robot>", "2", {"no name"}},
    {"two_links_of_one_name", robot("<link name='a'/>"), "4", {"two links", "'a'"}},
    {"two_joints_of_one_name",
     robot("<joint name='j' type='fixed'><parent link='a'/><child link='b'/></joint>\n<joint name='j' type='fixed'/>"),
     "5",
     {"two joints", "'j'"}},
    {"misspelt_element_of_the_robot", robot("<jiont name='j'/>"), "4", {"<jiont>", "did you mean 'joint'?"}},
    {"misspelt_element_of_a_link",
     "<robot name='r'>\n<link name='a'>\n<inertal/></link></robot>",
     "3",
     {"<inertal>", "'inertial'"}},
    {"misspelt_element_of_a_joint", joint("fixed", "<orign xyz='1 0 0'/>"), "7", {"<orign>", "'origin'"}},
    {"misspelt_attribute", joint("fixed", "<origin xzy='1 0 0'/>"), "7", {"'xzy'", "'xyz'"}},
    {"unexpanded_xacro", robot("<xacro:include filename='x'/>"), "4", {"xacro"}},
    {"repeated_element", joint("fixed", "<origin xyz='1 0 0'/>\n<origin xyz='2 0 0'/>"), "8", {"second <origin>"}},
    {"repeated_attribute", link("<mass value='1' value='2'/>" + inertia), "4", {"twice"}},
    {"unknown_joint_type", joint("revolut", ""), "4", {"'revolut'", "did you mean 'revolute'?"}},
    {"joint_without_type",
     robot("<joint name='j'><parent link='a'/><child link='b'/></joint>"),
     "4",
     {"type is missing"}},
    {"joint_without_parent",
     robot("<joint name='j' type='fixed'><child link='b'/></joint>"),
     "4",
     {"<parent> is missing"}},
    {"parent_without_link",
     robot("<joint name='j' type='fixed'><parent/><child link='b'/></joint>"),
     "4",
     {"link is missing"}},
    {"unknown_parent",
     robot("<joint name='j' type='fixed'><parent link='x'/><child link='b'/></joint>"),
     "4",
     {"joint 'j'", "no link 'x'"}},
    {"two_roots", robot(""), "3", {"'b'", "'a'", "no joint"}},
    {"two_joints_to_one_link",
     robot("<joint name='j' type='fixed'><parent link='a'/><child link='b'/></joint>\n<joint name='k' "
           "type='fixed'><parent link='a'/><child link='b'/></joint>"),
     "5",
     {"'k'", "'b'", "'j'"}},
    {"cycle_without_a_root",
     robot("<joint name='j' type='fixed'><parent link='a'/><child link='b'/></joint>\n<joint name='k' "
           "type='fixed'><parent link='b'/><child link='a'/></joint>"),
     "4",
     {"cycle"}},
    {"cycle_beside_a_root",
     robot("<link name='w'/><joint name='j' type='fixed'><parent link='a'/><child link='b'/></joint>\n<joint name='k' "
           "type='fixed'><parent link='b'/><child link='a'/></joint>"),
     "5",
     {"cycle"}},
    {"revolute_without_limit", joint("revolute", ""), "4", {"<limit", "continuous"}},
    {"limit_without_effort",
     joint("revolute", "<limit lower='0' upper='1' velocity='1'/>"),
     "7",
     {"effort is missing"}},
    {"limits_crossed",
     joint("revolute", "<limit lower='2' upper='1' effort='1' velocity='1'/>"),
     "4",
     {"joint 'j'", "limit"}},
    {"zero_axis", joint("continuous", "<axis xyz='0 0 0'/>"), "4", {"joint 'j'", "axis is zero"}},
    {"axis_without_xyz", joint("continuous", "<axis/>"), "7", {"xyz is missing"}},
    {"vector_of_two", joint("fixed", "<origin xyz='1 2'/>"), "7", {"3 numbers", "'1 2'"}},
    {"vector_of_four", joint("fixed", "<origin xyz='1 2 3 4'/>"), "7", {"3 numbers"}},
    {"negative_damping_of_a_joint", joint("continuous", "<dynamics damping='-1'/>"), "4", {"negative damping -1"}},
    {"negative_friction_of_a_joint", joint("continuous", "<dynamics friction='-1'/>"), "4", {"negative friction"}},
    {"damping_of_a_planar_joint", joint("planar", "<dynamics damping='1'/>"), "4", {"damping", "planar"}},
    {"nan", link("<mass value='nan'/>" + inertia), "4", {"link 'a'", "'nan'", "finite"}},
    {"infinite", link("<mass value='inf'/>" + inertia), "4", {"'inf'"}},
    {"huge_number", link("<mass value='1e999'/>" + inertia), "4", {"'1e999'"}},
    {"decimal_comma", link("<mass value='1,5'/>" + inertia), "4", {"'1,5'"}},
    {"two_numbers_for_one", link("<mass value='1 5'/>" + inertia), "4", {"1 number", "'1 5'"}},
    {"inertial_without_mass", link(inertia), "3", {"link 'a'", "<mass> is missing"}},
    {"inertia_without_izz",
     link("<mass value='1'/><inertia ixx='1' ixy='0' ixz='0' iyy='1' iyz='0'/>"),
     "4",
     {"izz is missing"}},
    {"negative_mass", link("<mass value='-1'/>" + inertia), "2", {"body 'a'", "negative mass"}},
    {"negative_inertia",
     link("<mass value='1'/><inertia ixx='-1' ixy='0' ixz='0' iyy='1' iyz='0' izz='1'/>"),
     "2",
     {"body 'a'", "negative principal"}},
    {"non_triangle_inertia",
     link("<mass value='1'/><inertia ixx='1' ixy='0' ixz='0' iyy='1' iyz='0' izz='3'/>"),
     "2",
     {"triangle", "allow_nonphysical_inertia"}},
    {"name_that_is_no_utf8", robot("<link name='\xff'/>"), "4", {"UTF-8"}},
};

/// Processor time, so that a busy machine does not count.
double cpu_seconds(std::clock_t start) { return static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC; }

using Load = Mechanism (*)(std::string_view, const std::string&);

void expect_refused(const Bad& bad, Load load) {
  SCOPED_TRACE(bad.name);
  const std::clock_t start = std::clock();
  try {
    load(bad.text, "model");
    ADD_FAILURE() << "accepted";
  } catch (const InputError& error) {
    const std::string message = error.what();
    const std::string place =
        bad.place.empty() ? "model: " : "model:" + bad.place + (bad.place.back() == ':' ? "" : ":");
    EXPECT_EQ(message.substr(0, place.size()), place) << message;
    for (const std::string& fragment : bad.fragments) EXPECT_NE(message.find(fragment), std::string::npos) << message;
    EXPECT_LT(message.size(), 1200u);
  }
  EXPECT_LT(cpu_seconds(start), 10);
}

TEST(MalformedToml, is_refused_with_place_thing_and_mend) {
  for (const Bad& bad : bad_toml) expect_refused(bad, load_toml_text);
}

TEST(MalformedUrdf, is_refused_with_place_thing_and_mend) {
  for (const Bad& bad : bad_urdf) expect_refused(bad, load_urdf_text);
}

/// Fifty megabytes of each kind of garbage, as a file, are refused within seconds.
class Garbage : public testing::TestWithParam<std::pair<const char*, std::string>> {};

TEST_P(Garbage, of_fifty_megabytes_is_refused_quickly) {
  const std::string& piece = GetParam().second;
  for (const char* extension : {".toml", ".urdf"}) {
    const std::string path =
        (std::filesystem::temp_directory_path() / fmt::format("lanc-garbage-{}{}", GetParam().first, extension))
            .string();
    {
      std::ofstream file(path, std::ios::binary);
      for (std::size_t size = 0; size < 50000000; size += piece.size()) file << piece;
    }
    const std::clock_t start = std::clock();
    EXPECT_THROW(load_mechanism(path), InputError) << path;
    EXPECT_LT(cpu_seconds(start), 30) << path;
    std::filesystem::remove(path);
  }
}

std::string noise() {
  std::string text;
  for (unsigned k = 0, x = 1; k < 65536; ++k) x = x * 1664525u + 1013904223u, text += static_cast<char>(x >> 24);
  return text;
}

INSTANTIATE_TEST_SUITE_P(
    Malformed, Garbage,
    testing::Values(std::pair{"noise", noise()}, std::pair{"zeros", std::string(65536, '\0')},
                    std::pair{"letters", std::string(65536, 'a')}, std::pair{"brackets", std::string(65536, '[')},
                    std::pair{"angles", std::string(65536, '<')}, std::pair{"dots", std::string("a.")},
                    std::pair{"quotes", std::string("\"")}, std::pair{"elements", std::string("<a>")},
                    std::pair{"comments", std::string("# comment\n")}, std::pair{"spaces", std::string(65536, '\n')}),
    [](const auto& info) { return std::string(info.param.first); });

TEST(MalformedFile, that_is_missing_a_directory_empty_or_endless_is_refused) {
  for (const auto& load : {load_toml, load_urdf}) {
    const auto message = [&](const std::string& path) -> std::string {
      try {
        load(path);
      } catch (const InputError& error) {
        return error.what();
      }
      return "accepted";
    };
    EXPECT_NE(message("no/such/file").find("no/such/file: cannot be opened (No such file"), std::string::npos);
    EXPECT_NE(message(std::filesystem::temp_directory_path().string()).find("directory"), std::string::npos);
    EXPECT_NE(message("/dev/null").find("empty"), std::string::npos);
    EXPECT_NE(message("/dev/zero").find("larger than 64 MiB"), std::string::npos);
  }
}

}  // namespace
}  // namespace lanc
