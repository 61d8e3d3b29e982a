// Closed loops by every formulation of the register, mostly for the sake of those that leave eq. 14 to a sparse solver:
// against the KKT system of `dense` in long double, and against the matrix itself.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "lib/closure/scaling.h"
#include "lib/formulation/formulation.h"
#include "lib/io/mechanism.h"
#include "lib/system/eq14_matrix.h"
#include "lib/system/evaluator.h"
#include "tests/support/loop_cases.h"
#include "tests/support/naive.h"
#include "tests/support/tolerance.h"

namespace lanc::test {
namespace {

Solution<long double> reference(const Case& c, const System<long double>& system, Outcome& outcome,
                                RankPolicy policy = {}) {
  Solution<long double> solution(c.model);
  outcome = find_formulation("dense")->create_long_double(c.model)->solve(system, solution, policy);
  EXPECT_TRUE(outcome.usable()) << c.name << ": " << outcome.message;
  return solution;
}

/// Largest error of η̇, â, f̂ and λ relative to the size of its kind.
double error(const Case& c, const System<long double>& system, const Solution<double>& x,
             const Solution<long double>& expected) {
  double worst = relative(difference(c.model, x, expected), sizes(system, expected)).worst();
  const ClosureScaling scaling(c.model);
  double off = 0, size = 0;  // λ in the units of the wrenches over the length
  for (std::size_t k = 0; k < x.lambda.size(); ++k) {
    off = std::max(off, std::abs(x.lambda[k] - static_cast<double>(expected.lambda[k])) / scaling.row[k]);
    size = std::max(size, std::abs(static_cast<double>(expected.lambda[k])) / scaling.row[k]);
    if (!std::isfinite(x.lambda[k])) return 1e300;
  }
  const double load = sizes(system, expected).wrench * c.model.length();
  return std::max(worst, off / std::max(size, load));
}

bool is_sparse(const FormulationInfo& info) {
  return info.name.starts_with("eq14-") || info.name.starts_with("schur-");
}

TEST(SparseLoops, all_formulations_agree_with_the_kkt_system_in_long_double) {
  for (const Case& c : closed_loops()) {
    const System<long double> system = system_in_long_double(c);
    Outcome expected;
    const Solution<long double> exact = reference(c, system, expected);
    Evaluator<double> evaluator(c.model);
    for (const FormulationInfo& info : formulations()) {
      if (const auto why = info.objection(c.model)) {
        EXPECT_FALSE(info.name.starts_with("eq14-")) << info.name << " on " << c.name << ": " << *why;
        continue;
      }
      Solution<double> solution(c.model);
      const Outcome outcome = info.create_double(c.model)->solve(evaluator.system(c.state, c.loads), solution);
      EXPECT_EQ(outcome.status, expected.status) << info.name << " on " << c.name << ": " << outcome.message;
      EXPECT_EQ(outcome.redundant, expected.redundant) << info.name << " on " << c.name;
      EXPECT_TRUE(
          within_relative(std::string(info.name) + " on " + c.name, error(c, system, solution, exact), 1e-10, 1));
    }
  }
}

TEST(SparseLoops, are_solved_in_long_double_with_its_digits) {
  for (const Case& c : closed_loops()) {
    const System<long double> system = system_in_long_double(c);
    Outcome expected;
    const Solution<long double> exact = reference(c, system, expected);
    for (const FormulationInfo& info : formulations()) {
      if (!is_sparse(info) || !info.create_long_double || info.objection(c.model)) continue;
      Solution<long double> solution(c.model);
      const Outcome outcome = info.create_long_double(c.model)->solve(system, solution);
      EXPECT_EQ(outcome.status, expected.status) << info.name << " on " << c.name << ": " << outcome.message;
      const double off = relative(difference(c.model, solution, exact), sizes(system, exact)).worst();
      EXPECT_TRUE(within_relative(std::string(info.name) + " on " + c.name, off, 1e-13, 1));
    }
  }
}

TEST(SparseLoops, all_variants_of_settings_agree) {
  for (const Case& c : closed_loops()) {
    const System<long double> system = system_in_long_double(c);
    Outcome expected;
    const Solution<long double> exact = reference(c, system, expected);
    Evaluator<double> evaluator(c.model);
    for (const FormulationInfo& info : formulations()) {
      if (!is_sparse(info) || info.objection(c.model)) continue;
      for (const Variant& variant : info.variants) {
        const std::string name = std::string(info.name) + " " + std::string(variant.parameters) + " on " + c.name;
        Solution<double> solution(c.model);
        const Outcome outcome = variant.create(c.model)->solve(evaluator.system(c.state, c.loads), solution);
        EXPECT_EQ(outcome.status, expected.status) << name << ": " << outcome.message;
        EXPECT_TRUE(within_relative(name, error(c, system, solution, exact), 1e-10, 1));
      }
    }
  }
}

TEST(SparseLoops, of_all_closures_between_any_bodies_are_solved_alike) {
  int compared = 0;
  for (int seed = 0; seed < 30; ++seed) {
    const Case c = tangle(seed, 1 + seed % 5);
    const System<long double> system = system_in_long_double(c);
    ClosureRank<long double> rank(c.model);
    const ClosureDecision& decision = rank.decide(system);
    if (decision.sigma < 1e-3) continue;  // near a singular configuration every answer is far from the others
    const RankPolicy policy{decision.rank};
    Outcome expected;
    Solution<long double> exact(c.model);
    expected = find_formulation("dense")->create_long_double(c.model)->solve(system, exact, policy);
    Evaluator<double> evaluator(c.model);
    for (const FormulationInfo& info : formulations()) {
      if (info.objection(c.model)) continue;
      Solution<double> solution(c.model);
      const Outcome outcome = info.create_double(c.model)->solve(evaluator.system(c.state, c.loads), solution, policy);
      EXPECT_EQ(outcome.status, expected.status)
          << info.name << " on " << c.name << ": " << outcome.message << " / " << expected.message;
      EXPECT_TRUE(
          within_relative(std::string(info.name) + " on " + c.name, error(c, system, solution, exact), 1e-7, 1));
      ++compared;
    }
  }
  EXPECT_GT(compared, 100);
}

TEST(SparseLoops, follow_from_state_to_state_though_other_rows_become_the_dependent_ones) {
  const auto state = [](double angle) {
    return load_mechanism("four-bar-ladder:4:cut=weld:angle=" + std::to_string(angle));
  };
  const Model model = state(0.7).model;
  for (const FormulationInfo& info : formulations()) {
    if (!is_sparse(info) || info.objection(model)) continue;
    const auto formulation = info.create_double(model);
    for (const double angle : {0.1, 1.2, 2.2, 0.7, -0.9}) {
      const Case c{"ladder", model, state(angle).state, {}};
      const System<long double> system = system_in_long_double(c);
      Outcome expected;
      const Solution<long double> exact = reference(c, system, expected);
      Evaluator<double> evaluator(model);
      Solution<double> solution(model);
      const Outcome outcome = formulation->solve(evaluator.system(c.state), solution);
      EXPECT_EQ(outcome.status, Status::redundant) << info.name << ": " << outcome.message;
      EXPECT_TRUE(within_relative(std::string(info.name), error(c, system, solution, exact), 1e-10, 1)) << angle;
    }
  }
}

TEST(SparseLoops, that_hold_a_tree_without_inertia_are_solved_by_pivoting_and_objected_to_by_others) {
  for (const Case& c : held_by_loops()) {
    const System<long double> system = system_in_long_double(c);
    Outcome expected;
    const Solution<long double> exact = reference(c, system, expected);
    Evaluator<double> evaluator(c.model);
    for (const FormulationInfo& info : formulations()) {
      const std::string name = std::string(info.name) + " on " + c.name;
      const bool must = info.name == "eq14-umfpack" || info.name == "eq14-spqr" || info.name == "eq14-klu";
      const auto judge = [&](const std::string& who, Factory<double> create, bool must_solve) {
        Solution<double> solution(c.model);
        const Outcome outcome = create(c.model)->solve(evaluator.system(c.state, c.loads), solution);
        if (must_solve) {
          EXPECT_EQ(outcome.status, expected.status) << who << ": " << outcome.message;
        }
        if (outcome.usable()) {
          EXPECT_TRUE(within_relative(who, error(c, system, solution, exact), 1e-9, 1));
        } else {
          // rounding may leave of the tree's singular inertia a tiny one, which shows in the answer only
          EXPECT_TRUE(outcome.status == Status::objection || outcome.status == Status::singular)
              << who << ": " << to_string(outcome.status) << " " << outcome.message;
        }
      };
      if (const auto why = info.objection(c.model)) {
        EXPECT_FALSE(must) << name << ": " << *why;
        continue;
      }
      judge(name, info.create_double, must);
      if (!is_sparse(info)) continue;
      for (const Variant& variant : info.variants)
        judge(name + " " + std::string(variant.parameters), variant.create, false);
    }
  }
}

constexpr Eq14Layout layouts[] = {
    {},
    {.bodies = BodyOrder::root_to_leaf},
    {.rows = {Block::acceleration, Block::wrench, Block::velocity},
     .columns = {Block::wrench, Block::acceleration, Block::velocity}},
};

TEST(BorderedEq14Matrix, times_a_solution_is_the_left_hand_side_in_every_layout) {
  for (const Case& c : closed_loops()) {
    Evaluator<double> evaluator(c.model);
    const System<double>& system = evaluator.system(c.state, c.loads);
    Solution<double> solution(c.model);
    ASSERT_TRUE(find_formulation("dense")->create_double(c.model)->solve(system, solution).usable());
    for (const Eq14Layout& layout : layouts) {
      Eq14Matrix<double> matrix(c.model, layout);
      const std::vector<int> starts = matrix.starts(), rows = matrix.rows();
      matrix.refill(system);
      EXPECT_EQ(starts, matrix.starts());
      EXPECT_EQ(rows, matrix.rows());
      std::vector<double> x(matrix.size()), b(matrix.size()), sum(matrix.size(), 0.0), size(matrix.size(), 0.0);
      for (int i = 0; i < c.model.bodies(); ++i) {
        const Motion<double>& a = solution.acceleration[i];
        const Wrench<double>& f = solution.wrench[i];
        const double values[] = {a.angular.x, a.angular.y, a.angular.z, a.linear.x, a.linear.y, a.linear.z,
                                 f.moment.x,  f.moment.y,  f.moment.z,  f.force.x,  f.force.y,  f.force.z};
        std::copy(values, values + 6, x.data() + matrix.column(i, Block::acceleration));
        std::copy(values + 6, values + 12, x.data() + matrix.column(i, Block::wrench));
        const Link& link = c.model.link(i);
        std::copy_n(solution.vdot.data() + link.v, link.nv, x.data() + matrix.column(i, Block::velocity));
      }
      for (int k = 0; k < c.model.closures().rows(); ++k) {
        x[matrix.column(k, Block::closure)] = solution.lambda[k];
        EXPECT_EQ(matrix.closure_of_column(matrix.column(k, Block::closure)), k);
      }
      EXPECT_EQ(matrix.closure_of_column(matrix.column(0, Block::wrench)), -1);
      matrix.scatter(system.rhs, b);
      for (int k = 0; k < matrix.size(); ++k)
        for (int p = matrix.starts()[k]; p < matrix.starts()[k + 1]; ++p) {
          sum[matrix.rows()[p]] += matrix.values()[p] * x[k];
          size[matrix.rows()[p]] += std::abs(matrix.values()[p] * x[k]);
        }
      for (int r = 0; r < matrix.size(); ++r)
        EXPECT_TRUE(
            within(c.name + " row " + std::to_string(r), sum[r] - b[r], matrix.size(), size[r] + std::abs(b[r]) + 1));
    }
  }
}

TEST(BorderedEq14Matrix, replaces_rows_that_do_not_count_and_keeps_the_pattern) {
  const Mechanism m = load_mechanism("four-bar-chain:2");
  Evaluator<double> evaluator(m.model);
  const System<double>& system = evaluator.system(m.state);
  Eq14Matrix<double> matrix(m.model);
  std::vector<char> counts(m.model.closures().rows(), true);
  counts[1] = false;
  matrix.refill(system, counts);
  const int at = matrix.column(1, Block::closure);
  for (int c = 0; c < matrix.size(); ++c)
    for (int p = matrix.starts()[c]; p < matrix.starts()[c + 1]; ++p)
      if (c == at || matrix.rows()[p] == at) {
        EXPECT_EQ(matrix.values()[p], c == at && matrix.rows()[p] == at ? 1 : 0);
      }
  std::vector<double> b(matrix.size());
  matrix.scatter(system.rhs, b);
  EXPECT_EQ(b[at], 0);
  EXPECT_NE(b[matrix.row(0, Block::closure)], 0);
}

TEST(BorderedEq14Matrix, fills_in_proportion_to_the_number_of_loops_by_every_solver) {
  for (const char* name : {"four-bar-ladder:{}", "four-bar-ladder:{}:cut=weld", "four-bar-chain:{}",
                           "four-bar-chain:{}:cut=weld", "four-bar-tree:{}", "four-bar-tree:{}:branching=5"})
    for (const FormulationInfo& info : formulations()) {
      if (!info.name.starts_with("eq14-")) continue;
      std::vector<double> fill;
      for (const int n : {31, 63, 127}) {
        const Mechanism m = load_mechanism(fmt::format(fmt::runtime(name), n));
        Evaluator<double> evaluator(m.model);
        Solution<double> solution(m.model);
        const auto formulation = info.create_double(m.model);
        ASSERT_TRUE(formulation->solve(evaluator.system(m.state), solution).usable()) << info.name << " on " << name;
        fill.push_back(static_cast<double>(formulation->statistics()->factor_nonzeros));
      }
      EXPECT_LT(fill[1], 63.0 / 31 * 1.1 * fill[0]) << info.name << " on " << name;
      EXPECT_LT(fill[2], 127.0 / 63 * 1.1 * fill[1]) << info.name << " on " << name;
    }
}

}  // namespace
}  // namespace lanc::test
