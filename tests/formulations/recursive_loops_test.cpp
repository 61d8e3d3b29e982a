// What only recursive-loops promises: linear plans, dropped rows, and the sparse matrix where leaf first fills. That it
// solves closed loops is tested with all others in tests/contract.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "formulations/recursive-loops/loop_elimination.h"
#include "lib/formulation/formulation.h"
#include "lib/io/mechanism.h"
#include "lib/report/phases.h"
#include "lib/system/equations.h"
#include "lib/system/evaluator.h"
#include "tests/support/loop_cases.h"
#include "tests/support/naive.h"
#include "tests/support/tolerance.h"

namespace lanc::test {
namespace {

const FormulationInfo& formulation() { return *find_formulation("recursive-loops"); }

bool is_sparse(const Model& model) { return formulation().create_double(model)->statistics().has_value(); }

/// Largest error of η̇, â, f̂ relative to the size of its kind, against `dense` in long double.
double error(const Case& c, const Solution<double>& solution) {
  const System<long double> system = system_in_long_double(c);
  Solution<long double> exact(c.model);
  EXPECT_TRUE(find_formulation("dense")->create_long_double(c.model)->solve(system, exact).usable()) << c.name;
  return relative(difference(c.model, solution, exact), sizes(system, exact)).worst();
}

TEST(RecursiveLoops, counts_of_operations_grow_by_the_same_number_with_every_loop) {
  for (const char* name : {"four-bar-ladder:{}", "four-bar-ladder:{}:cut=weld", "four-bar-ladder:{}:cut=hinge",
                           "four-bar-chain:{}", "four-bar-chain:{}:cut=weld"}) {
    std::vector<std::int64_t> flops;
    for (const int n : {20, 40, 60}) {
      const Mechanism m = load_mechanism(fmt::format(fmt::runtime(name), n));
      const PhaseCounts counts = count_phases(formulation(), m.model, m.state);
      EXPECT_TRUE(counts.outcome.usable()) << name;
      flops.push_back(counts.factorise.flops() + counts.solve.flops());
    }
    // which rows are dropped, and so a few operations, may change with the ends of a chain
    EXPECT_NEAR(static_cast<double>(flops[2] - flops[1]), static_cast<double>(flops[1] - flops[0]),
                2e-3 * static_cast<double>(flops[1]))
        << name;
  }
}

TEST(RecursiveLoops, counts_of_operations_on_a_tree_of_loops_grow_in_proportion_to_the_number_of_loops) {
  for (const char* name : {"four-bar-tree:{}", "four-bar-tree:{}:cut=weld", "four-bar-tree:{}:branching=5"}) {
    std::vector<double> flops;
    for (const int n : {31, 63, 127}) {
      const Mechanism m = load_mechanism(fmt::format(fmt::runtime(name), n));
      const PhaseCounts counts = count_phases(formulation(), m.model, m.state);
      EXPECT_TRUE(counts.outcome.usable()) << name;
      flops.push_back(static_cast<double>(counts.factorise.flops() + counts.solve.flops()) / n);
    }
    EXPECT_NEAR(flops[1] / flops[0], 1, 0.03) << name;
    EXPECT_NEAR(flops[2] / flops[1], 1, 0.03) << name;
  }
}

TEST(RecursiveLoops, on_trees_it_is_the_recursion_operation_by_operation) {
  for (const char* name : {"chain:12", "tree:31", "random:20:seed=4", "chain:7:joint=mixed"}) {
    const Mechanism m = load_mechanism(name);
    const PhaseCounts ours = count_phases(formulation(), m.model, m.state);
    const PhaseCounts theirs = count_phases(*find_formulation("recursive"), m.model, m.state);
    EXPECT_LE(ours.factorise.flops(), theirs.factorise.flops()) << name;
    EXPECT_LE(ours.solve.flops(), theirs.solve.flops() + 6 * m.model.bodies()) << name;
    Evaluator<double> evaluator(m.model);
    Solution<double> a(m.model), b(m.model);
    ASSERT_TRUE(formulation().create_double(m.model)->solve(evaluator.system(m.state), a).usable());
    ASSERT_TRUE(find_formulation("recursive")->create_double(m.model)->solve(evaluator.system(m.state), b).usable());
    for (int k = 0; k < m.model.nv(); ++k) EXPECT_TRUE(within(name, a.vdot[k] - b.vdot[k], 1, norms(m.model, b).vdot));
  }
}

TEST(RecursiveLoops, long_ladders_accelerate_as_their_closed_form_says) {
  // by pivots alone; welds of uprights a kilometre away cost digits of the closure rows themselves
  for (const auto& [cut, n] : {std::pair{"point", 1000}, {"weld", 300}}) {
    const Mechanism m = load_mechanism(fmt::format("four-bar-ladder:{}:cut={}", n, cut));
    const double exact = 9.81 * ((n + 1) / 2.0 + n) * std::sin(0.7) / ((n + 1) / 3.0 + n);
    Evaluator<double> evaluator(m.model);
    const auto elimination = make_loop_elimination<double>(m.model);
    Solution<double> solution(m.model);
    const System<double>& system = evaluator.system(m.state);
    ASSERT_TRUE(elimination->factorise(system));
    EXPECT_EQ(elimination->dropped(), (std::string(cut) == "point" ? 1 : 3) * n);
    elimination->solve(system, system.rhs, solution);
    EXPECT_NEAR(solution.vdot[0], exact, 1e-12 * exact) << cut;
  }
}

TEST(RecursiveLoops, refinement_restores_the_digits_that_loops_in_series_lose) {
  const Mechanism m = load_mechanism("four-bar-chain:300");
  Evaluator<long double> wide(m.model);
  Solution<long double> exact(m.model);
  const auto wide_elimination = make_loop_elimination<long double>(m.model);
  const System<long double>& wide_system = wide.system(cast<long double>(m.state));
  ASSERT_TRUE(wide_elimination->factorise(wide_system));
  wide_elimination->solve(wide_system, wide_system.rhs, exact);
  Evaluator<double> evaluator(m.model);
  Solution<double> solution(m.model);
  const auto elimination = make_loop_elimination<double>(m.model);
  const System<double>& system = evaluator.system(m.state);
  ASSERT_TRUE(elimination->factorise(system));
  elimination->solve(system, system.rhs, solution);
  // kinematics in double alone cost 2e-12; without refinement it is 2e-10
  EXPECT_TRUE(within_relative("chain of 300 loops", difference(m.model, solution, exact).vdot, 1e-11,
                              norms(m.model, solution).vdot));
  EXPECT_LT(backward_error(system, solution).componentwise, 1e-13);
}

TEST(RecursiveLoops, pivots_drop_as_many_rows_as_singular_values_find_dependent) {
  std::vector<Case> cases = closed_loops();
  for (int seed = 1; seed <= 60; ++seed) {
    const char* cause[] = {"any", "parallel", "bennett", "duplicate", "none"};
    const Mechanism m =
        load_mechanism(fmt::format("random-loops:{}:seed={}:redundant={}", 1 + seed % 9, seed, cause[seed % 5]));
    cases.push_back({m.model.name(), m.model, m.state, {}});
  }
  for (const Case& c : cases) {
    Evaluator<double> evaluator(c.model);
    const System<double>& system = evaluator.system(c.state, c.loads);
    ClosureRank<double> rank(c.model);
    const ClosureDecision& decision = rank.decide(system);
    if (decision.sigma < 1e-4) continue;  // pivots are σ²
    const auto elimination = make_loop_elimination<double>(c.model);
    ASSERT_TRUE(elimination->factorise(system)) << c.name;
    EXPECT_EQ(elimination->dropped(), decision.redundant) << c.name;
  }
}

TEST(RecursiveLoops, rows_of_a_closure_side_by_side_give_what_rows_one_by_one_give) {
  int strips = 0;
  for (const char* name : {"four-bar-ladder:7", "four-bar-ladder:7:cut=weld", "four-bar-chain:5",
                           "four-bar-chain:5:cut=weld", "four-bar-nest:4", "polygon:6:cut=weld"}) {
    const Mechanism m = load_mechanism(name);
    Evaluator<double> evaluator(m.model);
    const System<double>& system = evaluator.system(m.state);
    const auto beside = make_loop_elimination<double>(m.model);
    const auto one_by_one = make_loop_elimination<double>(m.model, EliminationPlan(m.model));
    strips += plan_for<double>(m.model).width > 1;
    Solution<double> a(m.model), b(m.model);
    ASSERT_TRUE(beside->factorise(system)) << name;
    ASSERT_TRUE(one_by_one->factorise(system)) << name;
    EXPECT_EQ(beside->dropped(), one_by_one->dropped()) << name;
    for (int k = 0; k < 2; ++k) {  // nothing of the first is left in the second
      beside->solve(system, system.rhs, a);
      one_by_one->solve(system, system.rhs, b);
      ASSERT_TRUE(beside->factorise(system)) << name;
    }
    EXPECT_TRUE(within_relative(name, difference(m.model, a, b).worst(), 1e-11, norms(m.model, b).worst()));
  }
  EXPECT_EQ(strips, 6);
}

TEST(EliminationPlan, refuses_strips_that_are_no_closures) {
  const Model model = load_mechanism("four-bar-ladder:3:cut=weld").model;
  EXPECT_THROW(EliminationPlan(model, 3), std::logic_error);
  EXPECT_THROW(make_loop_elimination<long double>(model, EliminationPlan(model, 6)), std::logic_error);
}

/// From a body to the root.
std::vector<int> path(const Model& model, int body) {
  std::vector<int> result;
  for (; body != ground; body = model.link(body).parent) result.push_back(body);
  return result;
}

TEST(EliminationPlan, lets_a_closure_go_when_its_loop_hangs_on_one_body) {
  std::vector<Model> models;
  for (const Case& c : closed_loops()) models.push_back(c.model);
  for (int seed = 0; seed < 30; ++seed) models.push_back(tangle(seed, 1 + seed % 6).model);
  for (const Model& model : models) {
    const EliminationPlan plan(model);
    ASSERT_EQ(plan.bodies.size() + plan.closures.size(), plan.order.size());
    ASSERT_EQ(static_cast<int>(plan.bodies.size()), model.bodies());
    std::vector<std::size_t> gone(model.bodies(), plan.order.size());
    for (std::size_t at = 0; at < plan.order.size(); ++at)
      if (plan.order[at] >= 0) gone[plan.bodies[plan.order[at]].body] = at;
    for (int i = 0; i < model.bodies(); ++i)
      if (model.link(i).parent != ground) EXPECT_LT(gone[i], gone[model.link(i).parent]) << model.name();
    for (std::size_t at = 0; at < plan.order.size(); ++at) {
      if (plan.order[at] >= 0) continue;
      const ClosureStep& step = plan.closures[-1 - plan.order[at]];
      for (const Closure& closure : model.closures().closures) {
        if (closure.row != step.strip) continue;
        const std::vector<int> a = path(model, closure.body_a), b = path(model, closure.body_b);
        for (const int body : a)
          if (std::find(b.begin(), b.end(), body) == b.end()) EXPECT_LT(gone[body], at) << model.name();
        for (const int body : b)
          if (std::find(a.begin(), a.end(), body) == a.end()) EXPECT_LT(gone[body], at) << model.name();
      }
    }
  }
}

TEST(EliminationPlan, lets_a_coupler_go_after_the_bodies_whose_velocities_it_acts_on) {
  int seen = 0;
  std::vector<Case> cases = closed_loops();
  for (int seed = 0; seed < 30; seed += 2) cases.push_back(tangle(seed, 1 + seed % 5));
  for (const Case& c : cases) {
    const EliminationPlan plan(c.model);
    std::vector<char> gone(c.model.bodies(), false);
    for (const int at : plan.order) {
      if (at >= 0) {
        gone[plan.bodies[at].body] = true;
        continue;
      }
      for (const Coupler& coupler : c.model.closures().couplers) {
        if (coupler.row != plan.closures[-1 - at].strip) continue;
        for (const Coupler::Term& term : coupler.terms) EXPECT_TRUE(gone[c.model.body_of_velocity(term.v)]) << c.name;
        ++seen;
      }
    }
  }
  EXPECT_GE(seen, 10);
}

TEST(EliminationPlan, gives_up_beyond_the_limit) {
  const Model model = long_chain_tied_to_ground(60).model;
  EXPECT_TRUE(std::isinf(EliminationPlan(model, 1, EliminationRule::path, 1e4).operations));
  EXPECT_LT(EliminationPlan(model).operations, 1e9);
}

TEST(RecursiveLoops, closures_after_all_bodies_give_the_same_answer) {
  for (const Case& c : closed_loops()) {
    Evaluator<double> evaluator(c.model);
    const System<double>& system = evaluator.system(c.state, c.loads);
    Solution<double> a(c.model), b(c.model);
    for (Solution<double>* solution : {&a, &b}) {
      const EliminationRule rule = solution == &a ? EliminationRule::path : EliminationRule::bodies_first;
      const auto elimination = make_loop_elimination<double>(c.model, plan_for<double>(c.model, rule));
      ASSERT_TRUE(elimination->factorise(system)) << c.name;
      elimination->solve(system, system.rhs, *solution);
    }
    EXPECT_TRUE(within_relative(c.name, difference(c.model, a, b).vdot, 1e-11, norms(c.model, a).vdot));
  }
}

TEST(RecursiveLoops, takes_the_sparse_matrix_where_leaf_first_fills_and_only_there) {
  for (const char* name : {"four-bar-ladder:100", "four-bar-chain:100:cut=weld", "polygon:200", "chain:50"})
    EXPECT_FALSE(is_sparse(load_mechanism(name).model)) << name;
  EXPECT_TRUE(is_sparse(load_mechanism("four-bar-nest:60").model));
  EXPECT_FALSE(is_sparse(long_chain_tied_to_ground(5).model));
  for (const Case& c : {long_chain_tied_to_ground(60), chains_with_rungs(60)}) {
    EXPECT_TRUE(is_sparse(c.model)) << c.name;
    Evaluator<double> evaluator(c.model);
    Solution<double> solution(c.model);
    const Outcome outcome = formulation().create_double(c.model)->solve(evaluator.system(c.state), solution);
    EXPECT_EQ(outcome.status, Status::redundant) << c.name << ": " << outcome.message;
    EXPECT_TRUE(within_relative(c.name, error(c, solution), 1e-11, 1));
  }
}

TEST(RecursiveLoops, a_massless_body_keeps_the_block_elimination_however_it_fills) {
  Case c = long_chain_tied_to_ground(30);
  ModelSpec spec = c.model.spec();
  spec.bodies[11].mass = 0, spec.bodies[11].inertia.setZero();  // a coupler; the upright on it has mass
  c.model = Model::build(spec);
  EXPECT_FALSE(is_sparse(c.model));
  Evaluator<double> evaluator(c.model);
  Solution<double> solution(c.model);
  const Outcome outcome = formulation().create_double(c.model)->solve(evaluator.system(c.state), solution);
  EXPECT_EQ(outcome.status, Status::redundant) << outcome.message;
  EXPECT_TRUE(within_relative(c.name, error(c, solution), 1e-10, 1));
}

TEST(RecursiveLoops, a_held_rank_by_pivots_gives_the_accelerations_of_singular_values) {
  for (const Case& c : closed_loops()) {
    Evaluator<double> evaluator(c.model);
    const System<double>& system = evaluator.system(c.state, c.loads);
    const auto solver = formulation().create_double(c.model);
    Solution<double> automatic(c.model), held(c.model);
    const Outcome first = solver->solve(system, automatic);
    ASSERT_TRUE(first.usable()) << c.name;
    const Outcome outcome = solver->solve(system, held, {.rank = first.rank, .by_pivots = true});
    EXPECT_EQ(outcome.status, first.status) << c.name << ": " << outcome.message;
    EXPECT_EQ(outcome.redundant, first.redundant) << c.name;
    EXPECT_TRUE(std::isnan(outcome.sigma)) << c.name << ": singular values were taken all the same";
    const Norms off = difference(c.model, held, automatic), size = norms(c.model, automatic);
    EXPECT_TRUE(within_relative(c.name, std::max(off.vdot, off.acceleration), 1e-11, size.acceleration));
    // other wrenches, and the same balance
    EXPECT_LT(backward_error(system, held).componentwise, 1e-11) << c.name;
    for (const int wrong : {first.rank - 1, first.rank + 1}) {
      const Outcome other = solver->solve(system, held, {.rank = wrong, .by_pivots = true});
      EXPECT_FALSE(std::isnan(other.sigma)) << c.name << ": a rank that pivots do not find is for singular values";
    }
  }
}

TEST(RecursiveLoops, prepares_other_right_hand_sides_by_singular_values_whatever_the_policy) {
  const Mechanism m = load_mechanism("four-bar-ladder:3");
  Evaluator<double> evaluator(m.model);
  const System<double>& system = evaluator.system(m.state);
  const auto solver = formulation().create_double(m.model);
  Solution<double> expected(m.model), solution(m.model);
  ASSERT_TRUE(solver->solve(system, expected).usable());
  const Outcome outcome = solver->prepare(system, {.rank = 6, .by_pivots = true});
  EXPECT_TRUE(outcome.usable()) << outcome.message;
  EXPECT_FALSE(std::isnan(outcome.sigma));
  RightHandSide<double> rhs = system.rhs;
  solver->respond(system, rhs, solution);
  for (int k = 0; k < m.model.nv(); ++k) EXPECT_NEAR(solution.vdot[k], expected.vdot[k], 1e-11);
}

TEST(RecursiveLoops, a_held_rank_by_pivots_does_not_hide_that_conditions_contradict) {
  Mechanism m = load_mechanism("four-bar-ladder:3");
  ModelSpec spec = m.model.spec();
  ClosureSpec rod = spec.closures[0];
  rod.name = "driven again", rod.kind = *find_closure_kind("distance");
  rod.body_a = "", rod.frame_a.position = Eigen::Vector3d(-1, 0, 0);
  rod.frame_b.position = Eigen::Vector3d(0, 0, 1);
  const double angle = 0.7, length = std::hypot(2 + std::sin(angle), std::cos(angle));
  rod.motion = Polynomial{{length, 0.0, 3.0}};
  spec.closures.push_back(rod);
  spec.closures.push_back(rod);
  spec.closures.back().name = "driven otherwise", spec.closures.back().motion = Polynomial{{length, 0.0, 1.0}};
  const Model model = Model::build(spec);
  std::fill(m.state.v.begin(), m.state.v.end(), 0.0);
  Evaluator<double> evaluator(model);
  const System<double>& system = evaluator.system(m.state);
  const auto solver = formulation().create_double(model);
  Solution<double> solution(model);
  const Outcome automatic = solver->solve(system, solution);
  EXPECT_EQ(automatic.status, Status::inconsistent) << automatic.message;
  EXPECT_FALSE(solver->solve(system, solution, {.rank = automatic.rank, .by_pivots = true}).usable());
}

TEST(RecursiveLoops, near_a_singular_position_an_answer_is_right_or_none) {
  int solved = 0;
  for (const double distance : {1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9}) {
    const double angle = std::acos(0.0) - distance;
    const Mechanism m = load_mechanism(fmt::format("four-bar-ladder:10:angle={:.17g}", angle));
    Evaluator<double> evaluator(m.model);
    Solution<double> solution(m.model);
    const Outcome outcome = formulation().create_double(m.model)->solve(evaluator.system(m.state), solution);
    if (!outcome.usable()) continue;
    ++solved;
    const int n = 10;
    const double exact = 9.81 * ((n + 1) / 2.0 + n) * std::sin(angle) / ((n + 1) / 3.0 + n);
    EXPECT_NEAR(solution.vdot[0], exact, 1e-6 * exact) << distance;
  }
  EXPECT_GE(solved, 3);
}

}  // namespace
}  // namespace lanc::test
