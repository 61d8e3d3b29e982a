// Random mechanisms for the tests: rich in what a model may contain, always with a solution.
//
// Apart from the generators of lib/io on purpose: those serve users and stay small; these must reach every feature of
// ModelSpec (friction, point springs, motions, singular inertias, arbitrary axes) and are repeated from a seed.
#pragma once

#include <cstdint>
#include <string>

#include "lib/model/model.h"

namespace lanc::test {

/// A mechanism, its state, and what acts on it.
struct Case {
  std::string name;
  Model model;
  State<double> state;
  Loads<double> loads;
};

/// Numbers from a seed, the same on every machine (the standard's distributions are not).
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  std::uint64_t next();  // SplitMix64
  double uniform(double lower, double upper);
  int below(int n) { return static_cast<int>(next() % static_cast<std::uint64_t>(n)); }
  bool chance(double p) { return uniform(0, 1) < p; }
  Eigen::Vector3d vector(double size);
  Eigen::Vector3d direction();
  Eigen::Matrix3d rotation();

 private:
  std::uint64_t state_;
};

/// Which features random_spec may use.
struct Features {
  bool prescribed = true;         // rheonomic joints with all kinds of motion
  bool singular_inertias = true;  // massless bodies, point masses, slender rods where the mechanism stays solvable
  bool dissipation = true;        // dampers and friction
  bool springs = true;            // of joints and between points
  bool wrenches = true;           // and constant torques
  bool armature = true;
  std::string only_joint;  // one kind for all joints, instead of all kinds
};

/// A joint of the kind with an arbitrary frame and arbitrary axes, and a body with a full inertia tensor.
JointSpec random_joint(Random& random, JointKind kind, const std::string& name);
BodySpec random_body(Random& random, const std::string& name);
/// One of the five kinds of motion, defined at least for −1 <= t <= 2; index 0..4 as in MotionSpec.
MotionSpec random_motion(Random& random, int kind);

ModelSpec random_spec(std::uint64_t seed, int bodies, const Features& features = {});
State<double> random_state(Random& random, const Model& model);
Loads<double> random_loads(Random& random, const Model& model);
/// All of it.
Case random_case(std::uint64_t seed, int bodies, const Features& features = {});

}  // namespace lanc::test
