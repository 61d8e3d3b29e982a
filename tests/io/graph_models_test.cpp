// Graphs of joints in the native format: what a file says is what the model gets, and bad files are refused.
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "lib/closure/mobility.h"
#include "lib/io/mechanism.h"
#include "lib/system/evaluator.h"
#include "tests/support/body_motion.h"

namespace lanc {
namespace {

const std::string head =  // lines 1 to 6; the next line is 7
    "[[body]]\nname='a'\nmass=1\n[[body]]\nname='b'\nmass=1\n";
std::string joint(const std::string& name, const std::string& type, const std::string& lines) {
  return "[[joint]]\nname='" + name + "'\ntype='" + type + "'\n" + lines;  // three lines and those given
}
const std::string ja = joint("ja", "revolute", "body_b='a'\n");                     // 4 lines
const std::string jb = joint("jb", "revolute", "body_b='b'\n");                     // 4 lines
const std::string jab = joint("jab", "spherical", "body_a='a'\nbody_b='b'\n");      // 5 lines
const std::string triangle = head + ja + jb + jab;                                  // the next line is 20
const std::string tree_joint = "[[joint]]\nname='t'\ntype='revolute'\nbody='b'\n";  // 4 lines

struct BadGraph {
  std::string text, place;
  std::vector<std::string> fragments;
};

const BadGraph bad_graphs[] = {
    {head + ja + tree_joint, "11:1", {"joint 'ja'", "joint 't'", "body_a and body_b", "same way"}},
    {head + tree_joint + ja, "11:1", {"joint 't'", "joint 'ja'", "same way"}},
    {head + joint("j", "revolute", "body_a='a'\nparent='b'\n"), "11:1", {"joint 'j'", "'parent'"}},
    {head + joint("j", "revolute", "body_a='a'\nposition=[0,0,1]\n"), "11:1", {"'position'", "'position_"}},
    {head + joint("j", "revolute", "body_a='a'\ncut=1\n"), "11:5", {"cut must be true or false"}},
    {head + joint("j", "revolut", "body_a='a'\n"), "9:6", {"'revolut'", "did you mean 'revolute'?"}},
    {head + joint("j", "revolute", "body_a='a'\nbody_b='a'\n"), "7:1", {"joint 'j'", "connects 'a' to itself"}},
    {head + joint("j", "revolute", "body_a='ground'\n"), "7:1", {"joint 'j'", "connects ground to itself"}},
    {head + joint("j", "revolute", "body_a='x'\n"), "7:1", {"joint 'j'", "no body 'x'"}},
    {head + ja + ja, "11:1", {"two joints are called 'ja'"}},
    {triangle + "[[body]]\nname='a'\nmass=1\n", "20:1", {"two bodies", "'a'"}},
    {triangle + "[[closure]]\nname='jab'\ntype='fixed'\nbody_b='a'\n", "20:1", {"two closures are called 'jab'"}},
    {triangle + "[[closure]]\nname='c'\ntype='fixed'\nbody_b='x'\n", "20:1", {"closure 'c'", "no body 'x'"}},
    {triangle + "[[spring]]\nname='s'\nbody_b='x'\n", "20:1", {"spring 's'", "no body 'x'"}},
    {triangle + "[[wrench]]\nbody='x'\n", "20:1", {"wrench", "no body 'x'"}},
    {head + ja, "4:1", {"body 'b'", "not connected to ground", "free"}},
    {head + jab, "1:1", {"body 'a'", "not connected to ground", "a, b"}},
    {head + ja + joint("jab", "revolute", "body_a='a'\nbody_b='b'\ncut=true\n"),
     "11:1",
     {"joint 'jab'", "it is cut", "(b)", "remove cut = true"}},
    {head + joint("k", "fixed", "body_b='a'\ncut=true\n") + jab, "7:1", {"joint 'k'", "(a, b)", "bodies"}},
    {triangle + joint("k", "fixed", "body_b='b'\ncut=false\n") + joint("l", "fixed", "body_b='b'\ncut=false\n"),
     "25:1",
     {"joint 'l'", "the loop (l, k)", "cut = false"}},
    {triangle + joint("k", "fixed", "body_b='b'\ncut=false\n") + joint("l", "revolute", "body_b='b'\ndamping=1\n"),
     "25:1",
     {"joint 'l'", "the loop (l, k)", "'l' has damping", "cut = false"}},
    {head + ja + jb + joint("k", "revolute", "body_a='b'\nbody_b='a'\ncut=true\nlimits=[-1,1]\n"),
     "15:1",
     {"joint 'k'", "it has limits", "cut = true at another"}},
    {head + ja + jb + joint("k", "revolute", "body_a='b'\nbody_b='a'\ncut=true\narmature=1\n"),
     "15:1",
     {"joint 'k'", "an armature"}},
    {head + ja + jb + joint("k", "revolute", "body_a='b'\nbody_b='a'\ncut=true\n") +
         "[[coupler]]\nname='c'\ncoordinates=['k']\nfactors=[1]\n",
     "15:1",
     {"joint 'k'", "a coupler"}},
    {triangle + "[state]\nq.jab=[1,0,0,0]\n", "21:7", {"joint 'jab'", "its loop is cut there", "cut = false"}},
    {triangle + "[state]\nv.jax=1\n", "21:3", {"'jax'", "did you mean 'ja'?"}},
    {head + ja + joint("k", "planar", "body_a='b'\nbody_b='a'\ndamping=[0,1,0]\n"),
     "11:1",
     {"joint 'k'", "'b' hangs on 'a'", "x or y", "exchange body_a and body_b"}},
    {head + ja + joint("k", "planar", "body_a='b'\nbody_b='a'\nlimits=[[0,1],[],[]]\n"), "11:1", {"a limit of x or y"}},
    {head + ja + joint("k", "spherical", "body_a='b'\nbody_b='a'\ndamping=[1,1,2]\n"), "11:1", {"differ between axes"}},
    {head + ja + joint("k", "spherical", "body_a='b'\nbody_b='a'\ntorque=[1,1,1]\n"), "11:1", {"torque"}},
    {head + joint("k", "free", "body_a='b'\ndamping=[1,1,1,0,0,0]\n") + jab, "7:1", {"'b' hangs on ground"}},
    {head + ja + joint("k", "planar", "body_a='b'\nbody_b='a'\n") +
         "[[coupler]]\nname='c'\ncoordinates=['k.x']\nfactors=[1]\n",
     "16:1",
     {"coupler 'c'", "joint 'k'", "exchange"}},
    {head + ja + joint("jb", "revolute", "body_b='b'\nposition_b=[0,0,1]\n") + "[[wrench]]\nbody='b'\nforce=[0,0,1]\n",
     "16:1",
     {"wrench on 'b'", "origin", "joint 'jb'"}},
    {head + ja + jb + joint("k", "revolute", "body_a='b'\naxis=[0,0,0]\n"), "15:1", {"joint 'k'", "axis is zero"}},
    {head + ja + jb + joint("k", "revolute", "body_a='b'\nquaternion_b=[1,1,0,0]\n"), "19:14", {"normalise"}},
};

TEST(MalformedGraphs, are_refused_with_place_thing_and_mend) {
  for (const BadGraph& b : bad_graphs) {
    SCOPED_TRACE(b.text);
    try {
      load_toml_text(b.text, "model");
      ADD_FAILURE() << "accepted";
    } catch (const InputError& error) {
      const std::string message = error.what(), place = "model:" + b.place + ":";
      EXPECT_EQ(message.substr(0, place.size()), place) << message;
      for (const std::string& fragment : b.fragments) EXPECT_NE(message.find(fragment), std::string::npos) << message;
      EXPECT_LT(message.size(), 600u) << message;
    }
  }
}

TEST(TomlGraphs, tell_where_they_are_cut) {
  const Mechanism m = load_toml_text(triangle, "model");
  ASSERT_EQ(m.graph.cuts.size(), 1u);
  EXPECT_EQ(to_text(m.graph.cuts[0]), "loop (jab, jb, ja) is cut at 'jab' (spherical, 3 conditions)");
  EXPECT_EQ(m.model.closures().row_names, (std::vector<std::string>{"jab.x", "jab.y", "jab.z"}));
  const Mechanism other =
      load_toml_text(head + ja + jb + joint("jab", "spherical", "body_a='a'\nbody_b='b'\ncut=false\n"), "model");
  EXPECT_EQ(other.graph.cuts.at(0).joint, "jb");
  EXPECT_TRUE(load_mechanism("four-bar-ladder:2").graph.cuts.empty());
}

TEST(TomlGraphs, give_bodies_axes_of_their_own) {
  const std::string file = LANC_SOURCE_DIR "/data/models/linkages/four-bar-graph.toml";
  const Mechanism m = load_mechanism(file);
  ASSERT_EQ(m.graph.cuts.size(), 1u);
  EXPECT_EQ(m.graph.cuts[0].joint, "ball");
  Evaluator<double> evaluator(m.model);
  for (const auto& row : evaluator.system(m.state).closure_rows) {
    EXPECT_NEAR(row.g, 0, 1e-15);
    EXPECT_NEAR(row.rate, 0, 1e-15);
  }
  const Mobility mobility = analyse_mobility(m.model, m.state);
  EXPECT_EQ(mobility.redundant(), 1);
  EXPECT_EQ(mobility.mobility, 1);
  EXPECT_EQ(to_string(mobility.verdict), "overconstrained");
  const auto motion = test::motion_of_bodies(m.model, m.state);
  EXPECT_NEAR((motion.at("rocker").com - Eigen::Vector3d(2 - 0.375, 0.5, 0)).norm(), 0, 1e-15);
  EXPECT_NEAR((motion.at("coupler").velocity - Eigen::Vector3d(-1, -0.375, 0)).norm(), 0, 1e-15);
}

TEST(TomlGraphs, are_cut_by_the_user_to_the_same_motion) {
  std::ifstream file(LANC_SOURCE_DIR "/data/models/linkages/four-bar-graph.toml");
  std::stringstream whole;
  whole << file.rdbuf();
  std::string text = whole.str();
  const Mechanism m = load_toml_text(text, "model");
  text.insert(text.find("name = \"pivot\""), "cut = true\n");
  text.replace(text.find("v.pivot = 1"), 11,
               "q.ball = [0.4472135954999579, 0, 0, 0.8944271909999159]\nv.ball = [0, 0, 1.6]");
  const Mechanism cut = load_toml_text(text, "model");
  EXPECT_EQ(cut.graph.cuts.at(0).joint, "pivot");
  EXPECT_TRUE(cut.graph.cuts.at(0).demanded);
  test::expect_same_motion(test::motion_of_bodies(m.model, m.state), test::motion_of_bodies(cut.model, cut.state),
                           1e-13);
}

TEST(TomlGraphs, the_gate_of_the_readme_swings) {
  std::ifstream file(LANC_SOURCE_DIR "/data/models/README.md");
  std::string text, line;
  while (std::getline(file, line) && line != "name = \"gate\"") {
  }
  for (; line != "```" && file; std::getline(file, line)) text += line + "\n";
  const Mechanism m = load_toml_text(text, "readme.toml");
  ASSERT_EQ(m.graph.cuts.size(), 1u);
  EXPECT_EQ(m.graph.cuts[0].joint, "lower");
  Evaluator<double> evaluator(m.model);
  for (const auto& row : evaluator.system(m.state).closure_rows) EXPECT_NEAR(row.g, 0, 1e-15);
  const Eigen::Vector3d expected(0.5 * std::cos(0.5), 0.5 * std::sin(0.5), 0.6);
  EXPECT_NEAR((test::motion_of_bodies(m.model, m.state).at("gate").com - expected).norm(), 0, 1e-15);
}

}  // namespace
}  // namespace lanc
