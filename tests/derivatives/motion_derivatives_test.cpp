// Exact derivatives of the equations of motion, against difference quotients in extended precision.
#include "lib/derivatives/motion_derivatives.h"

#include <gtest/gtest.h>

#include "lib/io/mechanism.h"
#include "lib/model/coordinates.h"
#include "lib/system/equations.h"
#include "tests/support/random_model.h"
#include "tests/support/tolerance.h"

namespace lanc::test {
namespace {

using Real = long double;

/// Everything MotionDerivatives differentiates, one number after another.
std::vector<Real> everything(const Model& model, State<Real> state, const std::vector<double>& vdot,
                             const std::vector<double>& lambda, const Loads<double>& loads) {
  normalise(model, state.q.data());
  std::vector<Real> all(model.nq());
  coordinate_rates(model, state.q.data(), state.v.data(), all.data());
  Evaluator<Real> evaluator(model);
  const System<Real>& system = evaluator.system(state, cast<Real>(loads));
  Solution<Real> solution(model);
  solution.vdot.assign(vdot.begin(), vdot.end());
  solution.lambda.assign(lambda.begin(), lambda.end());
  std::vector<Real> tau(model.nv()), open(model.closures().rows());
  inverse_dynamics(system, solution, tau);
  all.insert(all.end(), tau.begin(), tau.end());
  if (model.has_closures()) closure_accelerations(system, system.rhs, solution, open);
  for (const auto& row : system.closure_rows) all.push_back(row.g);
  for (const auto& row : system.closure_rows) all.push_back(row.rate);
  all.insert(all.end(), open.begin(), open.end());
  return all;
}

void expect_derivatives(const std::string& name, const Model& model, const State<double>& state,
                        const Loads<double>& loads) {
  Random random(17);
  std::vector<double> vdot(model.nv()), lambda(model.closures().rows());
  for (double& x : vdot) x = random.uniform(-2, 2);
  for (double& x : lambda) x = random.uniform(-2, 2);
  Differentiator differentiator(model, loads);
  const MotionDerivatives& d = differentiator.at(state, vdot, lambda);
  const int nq = model.nq(), columns = nq + model.nv();
  EXPECT_EQ(differentiator.passes(), (columns + Differentiator::lanes - 1) / Differentiator::lanes) << name;
  const Eigen::MatrixXd* blocks[] = {&d.coordinate_rate, &d.balance, &d.position, &d.velocity, &d.acceleration};
  constexpr Real h = 1e-6L;
  for (int c = 0; c < columns; ++c) {
    const auto shifted = [&](Real by) {
      State<Real> moved = cast<Real>(state);
      (c < nq ? moved.q[c] : moved.v[c - nq]) += by;
      return everything(model, std::move(moved), vdot, lambda, loads);
    };
    const auto plus = shifted(h), minus = shifted(-h);
    std::size_t k = 0;
    for (const Eigen::MatrixXd* block : blocks)
      for (Eigen::Index r = 0; r < block->rows(); ++r, ++k) {
        const double expected = static_cast<double>((plus[k] - minus[k]) / (2 * h));
        const double size = 1 + std::abs(expected) + static_cast<double>(std::abs(plus[k]));
        EXPECT_TRUE(within_relative(name + " column " + std::to_string(c) + " row " + std::to_string(r),
                                    std::abs((*block)(r, c) - expected), 1e-8, size));
      }
  }
}

TEST(Derivatives, of_random_trees_are_their_difference_quotients) {
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    const Case c = random_case(seed, 6);
    expect_derivatives("seed " + std::to_string(seed), c.model, c.state, c.loads);
  }
}

TEST(Derivatives, of_closed_loops_are_their_difference_quotients) {
  for (int seed = 1; seed <= 8; ++seed) {
    const Mechanism m = load_mechanism("random-loops:2:seed=" + std::to_string(seed));
    expect_derivatives("random-loops " + std::to_string(seed), m.model, m.state, {});
  }
}

}  // namespace
}  // namespace lanc::test
