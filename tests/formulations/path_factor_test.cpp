// LᵀDL along the tree against dense algebra.
#include "formulations/composite/path_factor.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <limits>

#include "lib/io/generators.h"
#include "tests/support/random_model.h"

namespace lanc::test {
namespace {

/// A symmetric matrix with the sparsity of M̄, whose pivots are far from zero and, where asked for, of both signs.
Eigen::MatrixXd tree_matrix(const Model& model, Random& random, bool indefinite) {
  const VelocityPaths paths(model);
  const int n = model.nv();
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(n, n);
  for (int k = 0; k < n; ++k) {
    H(k, k) = (indefinite && random.chance(0.4) ? -1 : 1) * random.uniform(50, 60 + n);
    for (int l = paths.before(k); l >= 0; l = paths.before(l)) H(k, l) = H(l, k) = random.uniform(-1, 1);
  }
  return H;
}

template <class S>
void fill(const Model& model, const Eigen::MatrixXd& H, PathFactor<S>& factor) {
  const VelocityPaths paths(model);
  for (int k = 0; k < model.nv(); ++k) {
    S* const row = factor.begin_row(k);
    for (int l = k, e = factor.depth(k) - 1; l >= 0; l = paths.before(l), --e) row[e] = S(H(k, l));
  }
}

template <class S>
double error(const Model& model, const Eigen::MatrixXd& H, PathFactor<S>& factor, Random& random) {
  fill(model, H, factor);
  factor.factorise();
  Eigen::VectorXd b(model.nv());
  std::vector<S> x;
  for (double& value : b) value = random.uniform(-1, 1), x.push_back(S(value));
  factor.solve(x);
  const Eigen::VectorXd exact = H.fullPivLu().solve(b);
  double largest = 0;
  for (int k = 0; k < model.nv(); ++k) largest = std::max(largest, std::abs(to_double(x[k]) - exact[k]));
  return largest / exact.cwiseAbs().maxCoeff();
}

TEST(PathFactor, solves_matrices_of_every_tree_with_pivots_of_either_sign) {
  Random random(7);
  std::vector<Model> models;
  for (const char* argument : {"chain:1", "chain:7", "chain:8", "chain:9", "chain:16", "chain:17", "chain:50",
                               "star:20", "tree:40", "chain:6:joint=free", "tree:9:joint=spherical"})
    models.push_back(generate(argument)->model);
  for (int seed = 1; seed <= 40; ++seed) models.push_back(random_case(seed, 1 + 2 * (seed % 20)).model);
  for (const Model& model : models) {
    if (model.nv() == 0) continue;
    PathFactor<double> factor(model);
    PathFactor<long double> precise(model);
    PathFactor<Count> counted(model);
    for (const bool indefinite : {false, true, false}) {
      const Eigen::MatrixXd H = tree_matrix(model, random, indefinite);
      EXPECT_LE(error(model, H, factor, random), 1e-13) << model.name() << " " << model.nv();
      EXPECT_LE(error(model, H, precise, random), 1e-13) << model.name();
      EXPECT_LE(error(model, H, counted, random), 1e-13) << model.name();
    }
  }
}

TEST(PathFactor, forgets_a_matrix_that_was_no_number) {
  Random random(3);
  for (const char* argument : {"chain:5", "chain:9", "tree:40"}) {
    const Model model = generate(argument)->model;
    PathFactor<double> factor(model);
    Eigen::MatrixXd H = tree_matrix(model, random, false);
    fill(model, H * std::numeric_limits<double>::quiet_NaN(), factor);
    factor.factorise();
    std::vector<double> x(model.nv(), 1.0);
    factor.solve(x);
    EXPECT_TRUE(std::isnan(x[0]));
    EXPECT_LE(error(model, H, factor, random), 1e-13) << argument;
  }
}

}  // namespace
}  // namespace lanc::test
