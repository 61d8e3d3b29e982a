// The sparse matrix that recursive-loops takes where leaf first fills.
#include <gtest/gtest.h>

#include "formulations/recursive-loops/loop_elimination.h"
#include "formulations/recursive-loops/quasi_definite.h"
#include "lib/closure/rank.h"
#include "lib/system/evaluator.h"
#include "tests/support/loop_cases.h"
#include "tests/support/naive.h"
#include "tests/support/tolerance.h"

namespace lanc::test {
namespace {

TEST(QuasiDefinite, agrees_with_the_block_elimination_after_few_steps) {
  std::vector<Case> cases = closed_loops();
  cases.push_back(long_chain_tied_to_ground(12));
  cases.push_back(chains_with_rungs(12));
  int compared = 0;
  for (const Case& c : cases) {
    if (c.model.has_singular_inertia()) continue;
    Evaluator<double> evaluator(c.model);
    const System<double>& system = evaluator.system(c.state, c.loads);
    ClosureRank<double> rank(c.model);
    const ClosureDecision& decision = rank.decide(system);
    RightHandSide<double> rhs = system.rhs;
    for (std::size_t k = 0; k < rhs.closure.size(); ++k) rhs.closure[k] += decision.correction[k];
    QuasiDefinite sparse(c.model);
    ASSERT_TRUE(sparse.factorise(system, decision.independent)) << c.name;
    Solution<double> solution(c.model);
    sparse.substitute(system, rhs, solution);
    EXPECT_LE(sparse.steps(), 6) << c.name;
    const auto elimination = make_loop_elimination<double>(c.model);
    ASSERT_TRUE(elimination->factorise(system)) << c.name;
    Solution<double> expected(c.model);
    elimination->solve(system, rhs, expected);
    EXPECT_TRUE(within_relative(c.name, difference(c.model, solution, expected).vdot, 1e-10,
                                norms(c.model, expected).acceleration));
    ++compared;
  }
  EXPECT_GE(compared, 10);
}

TEST(QuasiDefinite, fills_in_proportion_to_the_number_of_loops) {
  for (const auto make : {long_chain_tied_to_ground, chains_with_rungs}) {
    const double few = QuasiDefinite(make(60, 0.7).model).statistics().factorise_flops;
    const double many = QuasiDefinite(make(120, 0.7).model).statistics().factorise_flops;
    EXPECT_LT(many, 2.2 * few);
  }
}

TEST(QuasiDefinite, finds_an_equilibrium_at_rest) {
  const Case c = long_chain_tied_to_ground(60, 0.0);
  Evaluator<double> evaluator(c.model);
  Solution<double> solution(c.model);
  const System<double>& system = evaluator.system(c.state);
  ClosureRank<double> rank(c.model);
  QuasiDefinite sparse(c.model);
  ASSERT_TRUE(sparse.factorise(system, rank.decide(system).independent));
  sparse.substitute(system, system.rhs, solution);
  for (const double vdot : solution.vdot) EXPECT_NEAR(vdot, 0, 1e-12 * 9.81);
}

TEST(QuasiDefinite, says_so_when_an_inertia_is_not_positive_definite) {
  ModelSpec spec = long_chain_tied_to_ground(4).model.spec();
  spec.bodies[2].inertia *= -10;
  spec.bodies[2].allow_nonphysical_inertia = true;
  const Model model = Model::build(spec);
  Evaluator<double> evaluator(model);
  const System<double>& system = evaluator.system(long_chain_tied_to_ground(4).state);
  const std::vector<char> all(model.closures().rows(), true);
  EXPECT_FALSE(QuasiDefinite(model).factorise(system, all));
}

}  // namespace
}  // namespace lanc::test
