#include "lib/io/generators.h"

#include <gtest/gtest.h>

#include <bit>
#include <map>

#include "lib/formulation/formulation.h"
#include "lib/model/error.h"
#include "lib/system/equations.h"
#include "lib/system/evaluator.h"

using namespace lanc;

namespace {

Mechanism make(const std::string& argument) { return generate(argument).value(); }

/// FNV-1a over the bits of numbers and the letters of names.
class Hash {
 public:
  void add(double x) {
    const auto bits = std::bit_cast<std::uint64_t>(x);
    for (int k = 0; k < 64; k += 8) byte(static_cast<unsigned char>(bits >> k));
  }
  void add(const std::string& text) {
    for (const char c : text) byte(static_cast<unsigned char>(c));
    byte(0);
  }
  template <class Derived>
  void add(const Eigen::DenseBase<Derived>& m) {
    for (int r = 0; r < m.rows(); ++r)
      for (int c = 0; c < m.cols(); ++c) add(m(r, c));
  }
  void add(const std::vector<double>& values) {
    for (const double x : values) add(x);
  }
  void add(const CoordinateSpec& c) {
    for (const double x : {c.stiffness, c.rest, c.damping, c.friction_positive, c.friction_negative, c.friction_speed,
                           c.torque, c.armature})
      add(x);
  }
  void add(const MotionSpec& motion) {
    std::visit(
        [this]<class M>(const M& m) {
          if constexpr (std::is_same_v<M, ConstantSpeed>)
            add(m.start), add(m.rate);
          else if constexpr (std::is_same_v<M, Polynomial>)
            add(m.coefficients);
          else if constexpr (std::is_same_v<M, Sine>)
            add(m.offset), add(m.amplitude), add(m.frequency), add(m.phase);
          else if constexpr (std::is_same_v<M, SplineTable>)
            add(m.times), add(m.values);
          else
            add(m.text);
        },
        motion);
  }
  std::uint64_t value() const { return value_; }

 private:
  void byte(unsigned char b) { value_ = (value_ ^ b) * 0x100000001b3u; }
  std::uint64_t value_ = 0xcbf29ce484222325u;
};

std::uint64_t hash(const Mechanism& mechanism) {
  Hash h;
  const ModelSpec& spec = mechanism.model.spec();
  h.add(spec.name);
  h.add(spec.gravity);
  for (const BodySpec& b : spec.bodies) h.add(b.name), h.add(b.mass), h.add(b.com), h.add(b.inertia);
  for (const JointSpec& j : spec.joints) {
    h.add(j.name), h.add(std::string(j.kind.traits().name)), h.add(j.parent), h.add(j.body);
    h.add(j.frame.rotation), h.add(j.frame.position), h.add(j.pitch);
    if (j.axis) h.add(*j.axis);
    if (j.axis2) h.add(*j.axis2);
    for (const CoordinateSpec& c : j.coordinates) h.add(c);
    if (j.motion) h.add(*j.motion);
  }
  for (const PointSpringSpec& s : spec.springs) {
    h.add(s.name), h.add(s.body_a), h.add(s.body_b), h.add(s.point_a), h.add(s.point_b);
    h.add(s.stiffness), h.add(s.damping), h.add(s.rest_length);
  }
  for (const WrenchSpec& w : spec.wrenches) h.add(w.body), h.add(w.moment), h.add(w.force);
  h.add(mechanism.state.t), h.add(mechanism.state.q), h.add(mechanism.state.v);
  return h.value();
}

std::string message_of(const std::string& argument) {
  try {
    generate(argument);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

}  // namespace

TEST(Generators, ChainIsTheOneThePeersWereMeasuredOn) {
  const Mechanism chain = make("chain:5");
  const ModelSpec& spec = chain.model.spec();
  ASSERT_EQ(spec.bodies.size(), 5u);
  EXPECT_EQ(spec.gravity, Eigen::Vector3d(0, 0, -9.81));
  EXPECT_EQ(spec.joints[3].axis.value(), Eigen::Vector3d::UnitX());
  EXPECT_EQ(spec.joints[3].parent, "b3");
  EXPECT_EQ(spec.joints[4].frame.position, Eigen::Vector3d(0, 0, 0.2));
  EXPECT_EQ(spec.bodies[2].com, Eigen::Vector3d(0.01, -0.02, 0.1));
  EXPECT_EQ(spec.bodies[2].inertia(0, 2), -1e-4);
  EXPECT_EQ(chain.model.nv(), 5);
}

TEST(Generators, NumbersAreEqualOnEveryMachine) {
  const Mechanism chain = make("chain:3");
  // computed apart, by Python integers
  EXPECT_EQ(chain.state.q, (std::vector<double>{0x1.10a2dec890258p-3, 0x1.e24e8bbbecc94p-1, -0x1.c89564e5dfca0p-4}));
  EXPECT_EQ(hash(chain), 5170674603665289881u);
  EXPECT_EQ(hash(make("chain:9:joint=mixed:seed=5")), 5795803023020817538u);
  EXPECT_EQ(hash(make("tree:20:branching=3:joint=free")), 873707075934078331u);
  EXPECT_EQ(hash(make("star:6:joint=spherical:gravity=1.62")), 4937587723959393731u);
  EXPECT_EQ(hash(make("random:40:seed=7")), 6658376851213686797u);
  EXPECT_EQ(hash(make("random:60:seed=18446744073709551615")), 12529062418953354941u);
}

TEST(Generators, TreeIsCompleteAndStarHasAHub) {
  const Mechanism tree = make("tree:13:branching=3");
  for (int i = 1; i < 13; ++i) EXPECT_EQ(tree.model.link(i).parent, (i - 1) / 3);
  const Mechanism star = make("star:4");
  EXPECT_EQ(star.model.link(0).parent, ground);
  for (int i = 1; i < 4; ++i) EXPECT_EQ(star.model.link(i).parent, 0);
}

TEST(Generators, EveryJointKindMakesAChainWithAValidState) {
  for (unsigned char k = 0; k < joint_kinds; ++k) {
    const std::string name(JointKind{k}.traits().name);
    const Mechanism chain = make("chain:4:joint=" + name);
    EXPECT_EQ(chain.model.nv(), 4 * JointKind{k}.traits().nv) << name;
    EXPECT_NO_THROW(checked_state(chain.model, chain.state)) << name;
  }
  EXPECT_EQ(make("chain:9:joint=mixed").model.link(8).kind, *find_joint_kind("revolute"));
}

TEST(Generators, SeedChangesTheStateOfAChainAndAllOfARandomTree) {
  EXPECT_EQ(hash(make("random:12")), hash(make("random:12")));
  EXPECT_NE(make("chain:3").state.q, make("chain:3:seed=2").state.q);
  EXPECT_EQ(make("chain:3").state.q, make("chain:3:seed=1").state.q);
  EXPECT_NE(make("random:12").model.spec().bodies[0].mass, make("random:12:seed=2").model.spec().bodies[0].mass);
}

TEST(Generators, RandomTreesHaveASolution) {
  for (int seed = 0; seed < 1000; ++seed) {
    const Mechanism tree = make("random:" + std::to_string(1 + seed % 60) + ":seed=" + std::to_string(seed));
    Evaluator<double> evaluator(tree.model);
    const System<double>& system = evaluator.system(tree.state);
    Solution<double> solution(tree.model);
    const Outcome outcome = find_formulation("recursive")->create_double(tree.model)->solve(system, solution);
    EXPECT_EQ(outcome.status, Status::solved) << seed << ": " << outcome.message;
    EXPECT_LT(backward_error(system, solution).componentwise, 1e-10) << seed;
  }
}

TEST(Generators, RandomTreesCoverEverythingATreeCanHave) {
  std::map<std::string, int> trees;  // number of trees that have it
  for (int seed = 0; seed < 1000; ++seed) {
    const Mechanism tree = make("random:" + std::to_string(1 + seed % 60) + ":seed=" + std::to_string(seed));
    std::map<std::string, bool> has;
    std::vector<int> children(tree.model.bodies(), 0), depth(tree.model.bodies(), 1);
    for (int i = 0; i < tree.model.bodies(); ++i) {
      const Link& link = tree.model.link(i);
      const JointSpec& joint = tree.model.spec().joints[i];
      has["joint " + std::string(link.kind.traits().name)] = true;
      if (link.inertia.mass == 0) has["massless body"] = true;
      if (link.inertia.mass == 0 && !link.leaf && link.nv > 0) has["massless body that moves and carries"] = true;
      if (link.inertia.mass > 0 && tree.model.spec().bodies[i].inertia.isZero()) has["point mass"] = true;
      if (joint.motion) has["motion " + std::to_string(joint.motion->index())] = true;
      for (const CoordinateSpec& c : joint.coordinates) {
        if (c.stiffness != 0) has["joint spring"] = true;
        if (c.damping != 0) has["damper"] = true;
        if (c.friction_positive != 0) has["friction"] = true;
        if (c.armature != 0) has["armature"] = true;
      }
      if (link.parent == ground) continue;
      if (++children[link.parent] > 1) has["branching"] = true;
      if ((depth[i] = depth[link.parent] + 1) > 15) has["depth > 15"] = true;
    }
    if (!tree.model.springs().empty()) has["point spring"] = true;
    if (!tree.model.wrenches().empty()) has["applied wrench"] = true;
    if (!tree.model.has_singular_inertia()) has["full inertia everywhere"] = true;
    for (const auto& [what, yes] : has) ++trees[what];
  }
  EXPECT_EQ(trees.size(), 9u + 5u + 12u);
  for (const auto& [what, count] : trees) {
    std::printf("%5d of 1000 trees: %s\n", count, what.c_str());
    EXPECT_GE(count, 50) << what;
  }
}

TEST(Generators, OptionsOfRandomTreesTakeThingsAway) {
  for (int seed = 0; seed < 50; ++seed) {
    const Model tree =
        make("random:30:massless=no:driven=no:forces=no:kinds=revolute,free:seed=" + std::to_string(seed)).model;
    EXPECT_FALSE(tree.has_singular_inertia());
    EXPECT_EQ(tree.drives(), 0);
    EXPECT_TRUE(tree.passive().empty() && tree.springs().empty() && tree.wrenches().empty() && !tree.has_armature());
    for (const Link& link : tree.links()) EXPECT_TRUE(link.nv == 1 || link.nv == 6);
  }
}

TEST(Generators, BadArgumentsSayWhatToMend) {
  EXPECT_FALSE(generate("chains:3"));
  EXPECT_FALSE(generate("robot.toml"));
  EXPECT_FALSE(generate(""));
  const std::pair<const char*, const char*> cases[] = {
      {"chain", "the number of bodies is missing; use chain:N"},
      {"chain:", "'' is not a number of bodies"},
      {"chain:ten", "'ten' is not a number of bodies"},
      {"chain:1e3", "'1e3' is not a number of bodies"},
      {"chain: 3", "' 3' is not a number of bodies"},
      {"chain:0", "0 bodies; give a number from 1 to"},
      {"chain:-4", "-4 bodies; give a number from 1 to"},
      {"chain:1000000000", "1000000000 bodies; give a number from 1 to"},
      {"chain:100000000000000000000000", "100000000000000000000000 bodies; give a number from 1 to"},
      {"chain:3:joint", "'joint' is not of the form key=value"},
      {"chain:3:joint=ball", "there is no joint 'ball'; choose from fixed, revolute"},
      {"chain:3:joint=", "there is no joint ''"},
      {"chain:3:seed=-1", "seed '-1' is not a whole number"},
      {"chain:3:seed=99999999999999999999999", "seed '99999999999999999999999' is not a whole number"},
      {"chain:3:seed=1:seed=2", "option 'seed' is given twice"},
      {"chain:3:colour=red", "there is no option 'colour'; use chain:N"},
      {"chain:3:branching=2", "there is no option 'branching'"},
      {"chain:3:", "'' is not of the form key=value"},
      {"chain:3:gravity=nan", "gravity 'nan' is not a number"},
      {"tree:3:branching=0", "branching '0' is not a whole number of 1 or more"},
      {"random:3:kinds=revolute,", "there is no joint ''"},
      {"random:3:massless=maybe", "write massless=yes or massless=no"},
  };
  for (const auto& [argument, message] : cases)
    EXPECT_NE(message_of(argument).find(message), std::string::npos) << argument << " gave: " << message_of(argument);
}
