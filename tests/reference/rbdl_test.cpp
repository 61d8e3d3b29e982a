// Small chains and trees whose accelerations RBDL publishes, to 1e-13 (data/reference/rbdl.csv).
#include <gtest/gtest.h>

#include <cmath>

#include "lib/formulation/formulation.h"
#include "lib/system/evaluator.h"
#include "tests/support/reference_data.h"
#include "tests/support/tolerance.h"

namespace lanc::test {
namespace {

using Eigen::Vector3d;
const Vector3d x = Vector3d::UnitX(), y = Vector3d::UnitY(), z = Vector3d::UnitZ();

/// Builds trees of revolute joints; bodies are called 1, 2, ...
struct Builder {
  ModelSpec spec;
  Builder() { spec.gravity = {0, -9.81, 0}; }
  Builder& add(const Vector3d& axis, const Vector3d& offset, const Vector3d& com, int parent = -1, double mass = 1,
               const Vector3d& inertia = Vector3d::Ones()) {
    const int number = static_cast<int>(spec.bodies.size()) + 1;
    BodySpec body;
    body.name = std::to_string(number);
    body.mass = mass, body.com = com;
    body.inertia = inertia.asDiagonal();
    JointSpec joint;
    joint.name = "joint" + body.name, joint.body = body.name;
    joint.kind = *find_joint_kind("revolute");
    joint.axis = axis;
    joint.frame.position = offset;
    if (parent < 0) parent = number - 1;
    if (parent > 0) joint.parent = std::to_string(parent);
    spec.bodies.push_back(body), spec.joints.push_back(joint);
    return *this;
  }
};

void expect_published(const char* name, const Builder& builder, std::vector<double> q = {}) {
  const std::vector<double> expected = values(read_reference("rbdl.csv").at(name));
  const Model model = Model::build(builder.spec);
  State<double> state = neutral_state(model);
  if (!q.empty()) state.q = q;
  Evaluator<double> evaluator(model);
  const System<double>& system = evaluator.system(state);
  int solved = 0;
  for (const FormulationInfo& info : formulations()) {
    if (!info.create_double || info.objection(model)) continue;
    Solution<double> solution(model);
    if (!info.create_double(model)->solve(system, solution).usable()) continue;
    ++solved;
    for (int k = 0; k < model.nv(); ++k)
      EXPECT_TRUE(within_relative(std::string(name) + " by " + std::string(info.name), solution.vdot[k] - expected[k],
                                  1e-13, std::max(1.0, std::abs(expected[k]))));
  }
  EXPECT_GE(solved, 1);
}

const Vector3d o = Vector3d::Zero();

TEST(Rbdl, single_bodies) {
  expect_published("single", Builder().add(z, o, x));
  expect_published("single_general", Builder().add(z, o, {1.5, 1, 1}, -1, 1, {1, 2, 3}));
}

TEST(Rbdl, chains_about_parallel_axes) {
  expect_published("double", Builder().add(z, o, x).add(z, x, x));
  expect_published("triple", Builder().add(z, o, x).add(z, x, x).add(z, x, x));
}

TEST(Rbdl, chain_about_two_axes) { expect_published("two_axes", Builder().add(z, o, x).add(y, x, y)); }

TEST(Rbdl, tree_of_five_bodies) {
  expect_published(
      "tree", Builder().add(z, o, x).add(y, x, y).add(x, y, z).add(y, {-0.5, 0, 0}, y, 1).add(x, {0, -0.5, 0}, z, 4));
}

TEST(Rbdl, euler_angles_as_three_hinges_with_massless_bodies) {
  expect_published("euler_angles", Builder().add(z, o, o, -1, 0, o).add(y, o, o, -1, 0, o).add(x, o, {0, 0.5, 0}),
                   {1, 0, 0});
}

}  // namespace
}  // namespace lanc::test
