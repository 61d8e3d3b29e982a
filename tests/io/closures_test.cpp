// Closed loops in: closures and couplers of the native format, mimic of URDF, and random closed mechanisms.
#include <gtest/gtest.h>

#include <map>

#include "lib/closure/assembly.h"
#include "lib/closure/rank.h"
#include "lib/formulation/formulation.h"
#include "lib/io/mechanism.h"
#include "lib/system/evaluator.h"

namespace lanc {
namespace {

// lines 1 to 16; the next line is 17
const std::string two_arms =
    "[[body]]\nname='a'\nmass=1\ninertia=[1,1,1]\n[[body]]\nname='b'\nmass=1\ninertia=[1,1,1]\n"
    "[[joint]]\nname='ja'\ntype='cylindrical'\nbody='a'\n[[joint]]\nname='jb'\ntype='revolute'\nbody='b'\n";

std::string closure(const std::string& lines) { return two_arms + "[[closure]]\nname='c'\n" + lines; }  // next: 19
std::string coupler(const std::string& lines) { return two_arms + "[[coupler]]\nname='c'\n" + lines; }

struct BadClosure {
  std::string text, place;
  std::vector<std::string> fragments;
};

const BadClosure bad[] = {
    {two_arms + "[[closure]]\ntype='revolute'\nbody_b='b'\n", "17:1", {"a closure", "name is missing"}},
    {closure("body_b='b'\n"), "17:1", {"closure 'c'", "type is missing"}},
    {closure("type='revolut'\nbody_b='b'\n"), "19:6", {"closure 'c'", "'revolut'", "did you mean 'revolute'?"}},
    {closure("type='free'\nbody_b='b'\n"), "19:6", {"unknown closure type 'free'", "point-on-line"}},
    {closure("type='revolute'\nbody_a='a'\nbody_b='a'\n"), "17:1", {"'c'", "connects 'a' to itself"}},
    {closure("type='revolute'\n"), "17:1", {"'c'", "connects 'ground' to itself"}},
    {closure("type='revolute'\nbody_b='x'\n"), "17:1", {"closure 'c'", "no body 'x'"}},
    {closure("type='revolute'\nbody_c='b'\n"), "20:1", {"closure 'c'", "'body_c'", "did you mean 'body_"}},
    {closure("type='distance'\nbody_b='b'\n"), "17:1", {"length must be positive", "point-on-point"}},
    {closure("type='distance'\nbody_b='b'\nlength=-1\n"), "17:1", {"length must be positive"}},
    {closure("type='revolute'\nbody_b='b'\nlength=1\n"), "17:1", {"takes no length"}},
    {closure("type='helical'\nbody_b='b'\n"), "17:1", {"pitch is zero"}},
    {closure("type='revolute'\nbody_b='b'\npitch=1\n"), "17:1", {"has no pitch"}},
    {closure("type='spherical'\nbody_b='b'\naxis=[0,0,1]\n"), "17:1", {"no axis"}},
    {closure("type='revolute'\nbody_b='b'\naxis=[0,0,0]\n"), "17:1", {"axis is zero"}},
    {closure("type='cylindrical'\nbody_b='b'\nmotion={type='constant-speed',rate=1}\n"),
     "17:1",
     {"cannot be prescribed", "one freedom"}},
    {closure("type='revolute'\nbody_b='b'\nrpy_a=[0,0,1]\nquaternion_a=[1,0,0,0]\n"), "21:7", {"keep one"}},
    {closure("type='revolute'\nbody_b='b'\nquaternion_b=[1,1,0,0]\n"), "21:14", {"normalise"}},
    {closure("type='revolute'\nbody_b='b'\n[[closure]]\nname='c'\ntype='fixed'\nbody_b='a'\n"),
     "21:1",
     {"two closures are called 'c'"}},
    {coupler("factors=[1]\n"), "17:1", {"coupler 'c'", "coordinates is missing"}},
    {coupler("coordinates=['jb']\nfactors=[1,2]\n"), "19:13", {"1 coordinates and 2 factors"}},
    {coupler("coordinates=[1]\nfactors=[1]\n"), "19:14", {"named by a string"}},
    {coupler("coordinates=['jx']\nfactors=[1]\n"), "17:1", {"no joint 'jx'"}},
    {coupler("coordinates=['jb.travel']\nfactors=[1]\n"), "19:14", {"joint 'jb'", "'travel'", "it has angle"}},
    {coupler("coordinates=['ja']\nfactors=[1]\n"), "19:14", {"several coordinates", "'ja.angle'"}},
    {coupler("coordinates=['jb']\nfactors=[0]\n"), "17:1", {"factor", "zero"}},
    {coupler("coordinates=[]\nfactors=[]\n"), "17:1", {"couples nothing"}},
    {coupler("coordinates=['jb','jb']\nfactors=[1,2]\n"), "17:1", {"named twice"}},
    {coupler("coordinates=['jb','ja.angle']\nfactors=[1,1e15]\n"), "17:1", {"leave no digits"}},
    {coupler("coordinates=['jb']\nfactors=[1]\n[[closure]]\nname='c'\ntype='fixed'\nbody_b='a'\n"),
     "17:1",
     {"two closures are called 'c'"}},
};

/// A robot of three links, the third on ground by joint 'k', the second by joint 'j', in which `inside` is line 9.
std::string robot(const std::string& type, const std::string& inside) {
  return "<robot name='r'>\n<link name='a'/>\n<link name='b'/>\n<link name='c'/>\n<joint name='k' type='continuous'>"
         "<parent link='a'/><child link='c'/></joint>\n<joint name='j' type='" +
         type + "'>\n<parent link='a'/>\n<child link='b'/>\n" + inside + "\n</joint>\n</robot>";
}

const BadClosure bad_mimics[] = {
    {robot("continuous", "<mimic joint='x'/>"), "9", {"joint 'j'", "mimics 'x'", "no such joint"}},
    {robot("continuous", "<mimic joint='j'/>"), "9", {"joint 'j'", "mimics itself"}},
    {robot("continuous", "<mimic multiplier='2'/>"), "9", {"joint is missing"}},
    {robot("fixed", "<mimic joint='k'/>"), "9", {"joint 'j'", "one freedom", "fixed"}},
    {robot("planar", "<mimic joint='k'/>"), "9", {"joint 'j'", "one freedom", "planar"}},
    {robot("continuous", "<mimic joint='k' multiplier='two'/>"), "9", {"'two'", "finite number"}},
    {robot("continuous", "<mimic joint='k'/><mimic joint='k'/>"), "9", {"a second <mimic>"}},
};

template <class Load, std::size_t count>
void expect_refused(const BadClosure (&list)[count], Load load) {
  for (const BadClosure& b : list) {
    SCOPED_TRACE(b.text);
    try {
      load(b.text, "model");
      ADD_FAILURE() << "accepted";
    } catch (const InputError& error) {
      const std::string message = error.what(), place = "model:" + b.place + ":";
      EXPECT_EQ(message.substr(0, place.size()), place) << message;
      for (const std::string& fragment : b.fragments) EXPECT_NE(message.find(fragment), std::string::npos) << message;
    }
  }
}

TEST(MalformedClosures, are_refused_with_place_thing_and_mend) { expect_refused(bad, load_toml_text); }
TEST(MalformedMimics, are_refused_with_place_thing_and_mend) { expect_refused(bad_mimics, load_urdf_text); }

TEST(Mimics, of_a_constant_hold_the_joint_where_it_is_told) {
  const Mechanism m = load_urdf_text(robot("continuous", "<mimic joint='k' multiplier='0' offset='0.3'/>"), "model");
  ASSERT_EQ(m.model.closures().couplers.size(), 1u);
  EXPECT_EQ(m.model.closures().couplers[0].terms.size(), 1u);
  EXPECT_EQ(m.state.q, (std::vector<double>{0.3, 0}));  // in the order of the links
}

TEST(TomlClosures, of_every_kind_are_read) {
  for (unsigned char k = 0; k < closures::all_closures.size(); ++k) {
    const ClosureTraits& traits = ClosureKind{k}.traits();
    std::string lines = "type='" + std::string(traits.name) + "'\nbody_a='a'\nbody_b='b'\nposition_a=[1,2,3]\n";
    lines += "rpy_b=[0,0,1]\n";
    if (traits.axes != JointAxes::none) lines += "axis=[1,0,0]\n";
    if (traits.axes == JointAxes::two) lines += "axis2=[0,2,0]\n";
    if (traits.has_pitch) lines += "pitch=0.1\n";
    if (traits.has_length) lines += "length=0.7\n";
    const Mechanism m = load_toml_text(closure(lines), "model");
    const ClosureSpec& c = m.model.spec().closures.at(0);
    EXPECT_EQ(c.kind, ClosureKind{k}) << traits.name;
    EXPECT_EQ(m.model.closures().rows(), traits.conditions.count);
    EXPECT_EQ(m.model.closures().row_names[0], "c." + std::string(traits.conditions.rows[0].name));
    EXPECT_EQ(c.frame_a.position, Eigen::Vector3d(1, 2, 3));
    EXPECT_NEAR(c.frame_b.rotation(1, 0), std::sin(1.0), 1e-15);
    EXPECT_EQ(c.length, traits.has_length ? 0.7 : 0);
    if (!traits.can_be_driven()) continue;
    if (traits.has_length) lines.resize(lines.size() - std::string("length=0.7\n").size());
    const Mechanism driven =
        load_toml_text(closure(lines + "motion={type='constant-speed',start=1,rate=1}\n"), "model");
    EXPECT_EQ(driven.model.closures().rows(), traits.has_length ? 1 : 6) << traits.name;
  }
}

TEST(TomlClosures, name_coordinates_of_joints_with_dots_in_their_names) {
  const Mechanism m = load_toml_text(
      "[[body]]\nname='a'\nmass=1\ninertia=[1,1,1]\n[[joint]]\nname='j.angle'\ntype='revolute'\nbody='a'\n"
      "[[coupler]]\nname='c'\ncoordinates=['j.angle']\nfactors=[2]\noffset=1\n",
      "model");
  EXPECT_EQ(m.model.spec().couplers.at(0).terms.at(0).joint, "j.angle");
  EXPECT_EQ(m.model.closures().couplers.at(0).offset, 1);
}

struct Closing {
  ClosureDecision decision;
  double g = 0, rate = 0;
};

Closing closing_of(const Mechanism& m) {
  Evaluator<double> evaluator(m.model);
  const System<double>& system = evaluator.system(m.state);
  ClosureRank<double> rank(m.model);
  Closing result{rank.decide(system)};
  for (const auto& row : system.closure_rows)
    result.g = std::max(result.g, std::abs(row.g)), result.rate = std::max(result.rate, std::abs(row.rate));
  return result;
}

TEST(RandomLoops, come_assembled_with_consistent_velocities) {
  for (int seed = 1; seed <= 40; ++seed) {
    const std::string name = "random-loops:" + std::to_string(1 + seed % 12) + ":seed=" + std::to_string(seed);
    const Mechanism m = load_mechanism(name);
    const Closing v = closing_of(m);
    EXPECT_LE(v.g, 5e-14) << name;  // rounding: of 50 bodies, metres apart
    EXPECT_LE(v.rate, 1e-13) << name;
    EXPECT_LE(v.decision.contradiction, 1e-10) << name;
    EXPECT_FALSE(v.decision.near_singular) << name;
    EXPECT_FALSE(v.decision.varying_rank) << name << ": redundancy holds all along the motion";
    EXPECT_LT(v.decision.rank, m.model.nv()) << name;
    const AssemblyResult again = assemble(m.model, m.state);
    EXPECT_TRUE(again.assembled()) << name << again.message;  // nothing flipped
    EXPECT_LE(again.moved_angle + again.moved_length, 1e-12) << name;
  }
}

TEST(RandomLoops, are_redundant_for_the_reason_asked_for) {
  for (int seed = 1; seed <= 12; ++seed) {
    const auto redundant = [&](const std::string& cause, int loops) {
      const Mechanism m = load_mechanism("random-loops:" + std::to_string(loops) + ":redundant=" + cause +
                                         ":seed=" + std::to_string(seed));
      return closing_of(m).decision.redundant;
    };
    EXPECT_EQ(redundant("none", 5), 0) << seed;
    EXPECT_EQ(redundant("parallel", 1), 3) << seed;
    EXPECT_EQ(redundant("parallel", 3), 3) << seed;
    EXPECT_EQ(redundant("bennett", 1), 3) << seed;
    EXPECT_EQ(redundant("bennett", 3), 3) << seed;
    EXPECT_GE(redundant("duplicate", 2), 1) << seed;
  }
}

TEST(RandomLoops, use_all_kinds_of_closures_and_drive_some) {
  std::map<std::string_view, int> kinds;
  int driven = 0, duplicates = 0;
  for (int seed = 1; seed <= 60; ++seed) {
    const Mechanism m = load_mechanism("random-loops:8:seed=" + std::to_string(seed));
    for (const ClosureSpec& c : m.model.spec().closures) {
      ++kinds[c.kind.traits().name], driven += c.motion.has_value();
      duplicates += c.name.rfind("d_", 0) == 0;
    }
  }
  EXPECT_EQ(kinds.size(), closures::all_closures.size());
  EXPECT_GT(driven, 10);
  EXPECT_GT(duplicates, 2);
  EXPECT_LT(duplicates, 20);
  const Mechanism undriven = load_mechanism("random-loops:8:driven=no");
  for (const ClosureSpec& c : undriven.model.spec().closures) EXPECT_FALSE(c.motion.has_value());
}

TEST(RandomLoops, take_only_the_kinds_they_are_given) {
  const Mechanism m = load_mechanism("random-loops:6:kinds=revolute,spherical:redundant=none:massless=no:driven=no");
  for (const ClosureSpec& c : m.model.spec().closures) {
    const auto joint = c.kind.traits().joint;
    EXPECT_TRUE(!joint || joint->traits().name == "revolute" || joint->traits().name == "spherical");
  }
  EXPECT_EQ(static_cast<int>(m.model.spec().closures.size()), 6);
}

TEST(RandomLoops, are_the_same_when_they_are_repeated) {
  EXPECT_EQ(load_mechanism("random-loops:5:seed=9").state.q, load_mechanism("random-loops:5:seed=9").state.q);
  EXPECT_EQ(load_mechanism("random-loops:5:seed=9").state.v, load_mechanism("random-loops:5:seed=9").state.v);
}

TEST(RandomLoops, that_do_not_fit_are_refused) {
  const auto message = [](const std::string& argument) -> std::string {
    try {
      load_mechanism(argument);
    } catch (const InputError& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_NE(message("random-loops:3:kinds=fixed:redundant=none").find("too few freedoms"), std::string::npos);
  EXPECT_NE(message("random-loops:100000").find("from 1 to 1000"), std::string::npos);
  EXPECT_NE(message("random-loops:3:redundant=bricard").find("redundant=bennett"), std::string::npos);
}

TEST(RandomLoops, are_solved) {
  for (int seed = 1; seed <= 20; ++seed) {
    const Mechanism m = load_mechanism("random-loops:4:seed=" + std::to_string(seed));
    Evaluator<double> evaluator(m.model);
    Solution<double> solution(m.model);
    const auto formulation = find_formulation("composite")->create_double(m.model);
    const Outcome outcome = formulation->solve(evaluator.system(m.state), solution);
    EXPECT_TRUE(outcome.usable()) << seed << ": " << to_string(outcome.status) << " " << outcome.message;
  }
}

}  // namespace
}  // namespace lanc
