// The lecture's elimination is a sparse factorisation of eq. 14.
#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "formulations/eq14-cholmod/eq14_cholmod.h"
#include "formulations/recursive/recursive.h"
#include "lib/system/evaluator.h"
#include "tests/support/random_model.h"
#include "tests/support/tolerance.h"

namespace lanc::test {
namespace {

using Eigen::MatrixXd;

/// Diagonal block [first, first + size) of L times that of D times its transpose: what is eliminated in one step.
MatrixXd block_pivot(const LdlFactors& f, int first, int size) {
  MatrixXd L = MatrixXd::Identity(size, size);
  Eigen::VectorXd D(size);
  for (int k = 0; k < size; ++k) {
    const int start = f.starts[first + k];
    D[k] = f.values[start];
    for (int p = start + 1; p < start + f.counts[first + k]; ++p)
      if (f.rows[p] < first + size) L(f.rows[p] - first, k) = f.values[p];
  }
  return L * D.asDiagonal() * L.transpose();
}

MatrixXd full(const ArticulatedInertia<double>& I) {
  MatrixXd result(6, 6);
  for (int k = 0; k < 6; ++k) {
    Motion<double> unit;
    double* const entries[] = {&unit.angular.x, &unit.angular.y, &unit.angular.z,
                               &unit.linear.x,  &unit.linear.y,  &unit.linear.z};
    *entries[k] = 1;
    const Wrench<double> f = I * unit;
    result.col(k) << f.moment.x, f.moment.y, f.moment.z, f.force.x, f.force.y, f.force.z;
  }
  return result;
}

void expect_pivots_of_the_recursion(const Case& c) {
  Evaluator<double> evaluator(c.model);
  const System<double>& system = evaluator.system(c.state, c.loads);
  Eq14Cholmod cholmod(c.model);
  cholmod.assemble(system);
  const Outcome outcome = cholmod.factorise(system);
  ASSERT_TRUE(outcome.usable()) << outcome.message;
  Recursive<double> recursive(c.model);
  ASSERT_TRUE(recursive.factorise(system).usable());

  for (int i = 0; i < c.model.bodies(); ++i) {
    const std::string body = c.name + ", body " + std::to_string(i);
    const Link& link = c.model.link(i);
    const MatrixXd star = full(recursive.articulated_inertia(i));
    MatrixXd C(6, link.nv);
    for (int k = 0; k < link.nv; ++k) {
      const Motion<double>& a = system.columns[link.v + k];
      C.col(k) << a.angular.x, a.angular.y, a.angular.z, a.linear.x, a.linear.y, a.linear.z;
    }
    MatrixXd N = C.transpose() * star * C;
    for (int k = 0; k < link.nv; ++k) N(k, k) += c.model.armature()[link.v + k];

    const Eq14Matrix<double>& matrix = cholmod.matrix();
    const auto pivot = [&](Block block, int size) {
      return block_pivot(cholmod.factors(), matrix.column(i, block), size);
    };
    const double condition = star.norm() * star.inverse().norm();
    EXPECT_TRUE(within(body + ", M*", (pivot(Block::acceleration, 6) - star).norm(), condition, star.norm()));
    EXPECT_TRUE(
        within(body + ", −(M*)⁻¹", (pivot(Block::wrench, 6) * star + MatrixXd::Identity(6, 6)).norm(), condition, 1));
    if (link.nv > 0)
      EXPECT_TRUE(within(body + ", N", (pivot(Block::velocity, link.nv) - N).norm(), condition, N.norm()));
  }
}

TEST(Pivots, of_cholmod_from_leaf_to_root_are_those_of_the_recursion_on_trees_of_all_joints) {
  for (int seed = 100; seed < 130; ++seed)
    expect_pivots_of_the_recursion(random_case(seed, 1 + seed % 17, {.singular_inertias = false}));
}

TEST(Pivots, of_cholmod_from_leaf_to_root_are_those_of_the_recursion_on_trees_of_ball_joints_and_free_bodies) {
  for (const char* joint : {"spherical", "free", "revolute"})
    for (int seed = 0; seed < 5; ++seed)
      expect_pivots_of_the_recursion(random_case(seed, 12, {.singular_inertias = false, .only_joint = joint}));
}

TEST(Pivots, of_cholmod_from_leaf_to_root_fill_nothing_outside_a_body_and_its_parent) {
  for (int seed = 0; seed < 40; ++seed) {
    const Case c = random_case(seed, 20, {.singular_inertias = false});
    const Eq14Cholmod cholmod(c.model);
    const LdlFactors f = cholmod.factors();
    const Eq14Matrix<double>& matrix = cholmod.matrix();
    for (int column = 0; column < matrix.size(); ++column) {
      const int body = matrix.body_of_column(column), parent = c.model.link(body).parent;
      for (int p = f.starts[column]; p < f.starts[column] + f.counts[column]; ++p) {
        const int other = matrix.body_of_column(f.rows[p]);
        EXPECT_TRUE(other == body || other == parent) << c.name << ": " << other << " in the column of " << body;
      }
    }
  }
}

}  // namespace
}  // namespace lanc::test
