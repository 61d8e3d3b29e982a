// Explicit closure conditions (theory, section 3): J*, η̄, η̿, the choice of s and its changes, β^d by Newton.
#include "lib/closure/explicit.h"

#include <gtest/gtest.h>

#include <numbers>

#include "lib/closure/explicit_walk.h"
#include "lib/io/four_bars.h"
#include "lib/io/mechanism.h"
#include "lib/system/closure_jacobian.h"
#include "lib/system/equations.h"
#include "lib/system/evaluator.h"
#include "tests/support/loop_cases.h"
#include "tests/support/random_model.h"
#include "tests/support/tolerance.h"

namespace lanc::test {
namespace {

using std::numbers::pi;

/// The double rocker 5 : 3 : 5 : 5 where β3 is largest, crank and coupler in line.
State<double> crank_and_coupler_in_line() { return at_rest({std::asin(0.8), 0, 2 * std::asin(0.8)}); }

const ExplicitConditions& conditions_of(ExplicitClosures& closures, const Model& model, const State<double>& state) {
  Evaluator<double> evaluator(model);
  ClosureRank<double> rank(model);
  const System<double>& system = evaluator.system(state);
  return closures.at(system, rank.decide(system));
}

/// A tree of all joint kinds with a closure whose length is prescribed, one at a point, and a gear.
Case driven_loops(std::uint64_t seed) {
  Random random(seed);
  Features features;
  ModelSpec spec = random_spec(seed, 7, features);
  const auto add = [&](const char* kind, std::optional<MotionSpec> motion, std::size_t a, std::size_t b) {
    ClosureSpec closure;
    closure.name = kind;
    closure.kind = *find_closure_kind(kind);
    closure.body_a = spec.bodies[a].name, closure.body_b = spec.bodies[b].name;
    closure.frame_a.position = random.vector(0.7), closure.frame_b.position = random.vector(0.7);
    closure.motion = std::move(motion);
    spec.closures.push_back(closure);
  };
  add("distance", Sine{0.3, 1.2, 1.7, 0.4}, 0, 6);
  add("point-on-point", std::nullopt, 2, 5);
  spec.length = 0.8;
  Case c{"driven loops", Model::build(spec), {}, {}};
  c.state = random_state(random, c.model);
  c.state.t = 0.3;
  return c;
}

TEST(Explicit, velocities_and_accelerations_from_any_independent_ones_satisfy_the_closure_conditions) {
  int tried = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const Case c = driven_loops(seed);
    const int nv = c.model.nv(), rows = c.model.closures().rows();
    Evaluator<double> evaluator(c.model);
    ClosureRank<double> rank(c.model);
    ExplicitClosures closures(c.model);
    const System<double> first = evaluator.system(c.state);
    const ClosureDecision& decision = rank.decide(first);
    if (decision.rank < rows || decision.sigma < 1e-3) continue;  // off the manifold redundant rows contradict
    ++tried;
    const ExplicitConditions at_first = closures.at(first, decision);
    ASSERT_EQ(at_first.J.cols(), nv - rows);
    ASSERT_EQ(static_cast<int>(at_first.dependent.size()), rows);

    ClosureJacobian<double> G(c.model);
    G.evaluate(first);
    for (int r = 0; r < rows; ++r)
      for (int k = 0; k < at_first.J.cols(); ++k) {
        const Eigen::VectorXd column = at_first.J.col(k);
        const double sum = G.times(r, {column.data(), column.data() + nv});
        EXPECT_TRUE(within("G J*", sum, at_first.condition * nv, 1 + column.norm())) << seed;
      }

    // velocities made from s, at which the evaluator's own ġ and G η̇ + γ̿ vanish
    Random random(seed);
    const auto drawn = [&] {
      Eigen::VectorXd s(at_first.J.cols());
      for (double& x : s) x = random.uniform(-2, 2);
      return s;
    };
    const Eigen::VectorXd v = at_first.J * drawn() + at_first.eta;
    State<double> moving = c.state;
    moving.v.assign(v.data(), v.data() + nv);
    const System<double>& system = evaluator.system(moving);
    const double speed = 1 + v.squaredNorm();
    for (int r = 0; r < rows; ++r)
      EXPECT_TRUE(within("Gη + γ̄", system.closure_rows[r].rate, at_first.condition * nv, speed)) << seed;
    const ExplicitConditions& now = closures.at(system, rank.decide(system));
    const Eigen::VectorXd vdot = now.J * drawn() + now.eta_bias;
    Solution<double> solution(c.model);
    solution.vdot.assign(vdot.data(), vdot.data() + nv);
    accelerations(system, system.rhs, solution);
    std::vector<double> second;
    closure_accelerations(system, system.rhs, solution, second);
    for (int r = 0; r < rows; ++r)
      EXPECT_TRUE(within("Gη̇ + γ̿", second[r], at_first.condition * nv, speed + vdot.norm())) << seed;
    // independent velocities and accelerations are what was asked for
    for (int k = 0; k < now.J.cols(); ++k) EXPECT_EQ(now.eta[now.independent[k]], 0);
  }
  EXPECT_GT(tried, 20);
}

TEST(Explicit, the_user_s_choice_is_kept_while_it_is_good_and_its_change_is_logged) {
  const Model model = planar_four_bar(5, 3, 5, 5);
  ExplicitClosures closures(model, {.candidates = {0, 2}});
  closures.choose({2});
  const State<double> stretched = at_rest({pi / 2 - 2 * std::asin(0.8), pi - std::asin(0.6), std::asin(0.6)});
  EXPECT_EQ(conditions_of(closures, model, stretched).independent, std::vector<int>{2});
  EXPECT_TRUE(closures.changes().empty());
  // β3 has a limit point where crank and coupler are in line
  State<double> limit = crank_and_coupler_in_line();
  limit.t = 0.25;
  EXPECT_EQ(conditions_of(closures, model, limit).independent, std::vector<int>{0});
  ASSERT_EQ(closures.changes().size(), 1U);
  const IndependentChange& change = closures.changes()[0];
  EXPECT_EQ(change.t, 0.25);
  EXPECT_EQ(change.before, std::vector<int>{2});
  EXPECT_EQ(change.after, std::vector<int>{0});
  EXPECT_GT(change.condition_before, 1e12);
  EXPECT_LT(change.condition_after, 10);
}

TEST(Explicit, a_choice_is_not_left_for_one_that_is_hardly_better) {
  const Model model = planar_four_bar(5, 3, 5, 5);
  State<double> state = crank_and_coupler_in_line();
  state.q[2] -= 0.02;  // β3 is near its limit, β1 is better
  ExplicitConditions by_rocker;
  by_rocker.independent = {2}, by_rocker.dependent = {0, 1};
  state.q[0] -= 0.2, state.q[1] += 0.3;
  const auto near = solve_dependent(model, state, by_rocker);
  ASSERT_TRUE(near);
  double condition[2];
  for (const int k : {0, 2}) {
    ExplicitClosures closures(model, {.candidates = {}, .leave = 1e9});
    closures.choose({k});
    condition[k / 2] = conditions_of(closures, model, *near).condition;
  }
  const double better = condition[1] / condition[0];
  ASSERT_GT(better, 1.5);
  for (const double gain : {better * 0.99, better * 1.01}) {
    ExplicitClosures closures(model, {.candidates = {0, 2}, .leave = 1, .gain = gain});
    closures.choose({2});
    EXPECT_EQ(conditions_of(closures, model, *near).independent[0], gain < better ? 0 : 2);
  }
}

TEST(Explicit, too_few_candidates_are_told) {
  const Mechanism m = load_mechanism("four-bar-chain:2");
  ExplicitClosures closures(m.model, {.candidates = {0}});
  try {
    conditions_of(closures, m.model, m.state);
    FAIL() << "two freedoms cannot depend on one velocity";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("name at least 2 candidates"), std::string::npos) << error.what();
  }
}

TEST(Explicit, newton_finds_the_dependent_coordinates_up_to_the_limit_point_and_refuses_beyond) {
  for (const bool hinge : {false, true}) {
    const Model model = planar_four_bar(5, 3, 5, 5, hinge);
    const double limit = 2 * std::asin(0.8);  // of β3
    State<double> state = crank_and_coupler_in_line();
    state.q[0] -= 0.4, state.q[1] += 0.7;
    ExplicitClosures closures(model, {.candidates = {2}});
    ExplicitConditions conditions = conditions_of(closures, model, state);
    ASSERT_EQ(conditions.independent, std::vector<int>{2});
    for (const double beyond : {-0.5, -0.1, -1e-3, 1e-3, 0.1}) {
      state.q[2] = limit + beyond;
      const auto solved = solve_dependent(model, state, conditions);
      EXPECT_EQ(solved.has_value(), beyond < 0) << beyond;
      if (!solved) continue;
      EXPECT_EQ(solved->q[2], state.q[2]);
      const double x = 5 * std::cos(solved->q[0]) - 5 * std::sin(solved->q[2]);
      const double y = 5 * std::sin(solved->q[0]) - 5 + 5 * std::cos(solved->q[2]);
      EXPECT_NEAR(std::hypot(x, y), 3, 1e-11) << beyond;
    }
  }
}

/// A walk round the oval; the number of steps until the crank is where it was, moving as it did, or −1.
int walk_round(ExplicitWalk& walk, double h, double& smallest, double& largest) {
  const std::vector<double> start = walk.here().q;
  const double direction = walk.tangent()[0];
  for (int step = 0; step < 5000; ++step) {
    const double before = walk.here().q[0] - start[0];
    if (!walk.advance(h)) return -1;
    const double after = walk.here().q[0] - start[0];
    smallest = std::min(smallest, walk.here().q[0]), largest = std::max(largest, walk.here().q[0]);
    const bool passes = step > 10 && before * direction < 0 && after * direction >= 0;
    if (passes && std::abs(walk.here().q[2] - start[2]) < 0.1) return step;
  }
  return -1;
}

TEST(Explicit, candidates_beta1_and_beta3_take_turns_all_round_the_double_rocker_s_oval) {
  for (const double leave : {20.0, 1e3, 1e5})
    for (const bool hinge : {false, true}) {
      const Model model = planar_four_bar(5, 3, 5, 5, hinge);
      ExplicitWalk walk(model, crank_and_coupler_in_line(), {.candidates = {0, 2}, .leave = leave});
      double smallest = 9, largest = -9;
      EXPECT_GT(walk_round(walk, 0.03, smallest, largest), 0) << leave;
      EXPECT_NEAR(smallest, pi / 2 - 2 * std::asin(0.8), 1e-3);
      EXPECT_NEAR(largest, pi / 2 - 2 * std::asin(0.2), 1e-3);
      ASSERT_EQ(walk.changes().size(), 4U) << "one at each extreme point but the start, and one back to the first";
      for (std::size_t k = 0; k < 4; ++k) {
        const WalkChange& change = walk.changes()[k];
        EXPECT_EQ(change.change.before, std::vector<int>{k % 2 == 0 ? 0 : 2});
        EXPECT_EQ(change.change.after, std::vector<int>{k % 2 == 0 ? 2 : 0});
        EXPECT_GT(change.change.condition_before, leave);
        EXPECT_LT(change.change.condition_after * 4, change.change.condition_before);
      }
    }
}

TEST(Explicit, a_walk_in_large_steps_neither_jumps_nor_turns_back) {
  const Model model = planar_four_bar(5, 3, 5, 5);
  for (const double leave : {20.0, 1e4})
    for (const double h : {0.1, 0.3, 0.6, 1.0}) {
      ExplicitWalk walk(model, crank_and_coupler_in_line(), {.candidates = {0, 2}, .leave = leave});
      for (int step = 0; step < 150; ++step) {
        const std::vector<double> before = walk.here().q;
        const Eigen::VectorXd along = walk.tangent();
        ASSERT_TRUE(walk.advance(h)) << h;
        Eigen::Vector3d way;
        for (int k = 0; k < 3; ++k) way[k] = walk.here().q[k] - before[k];
        EXPECT_LT(way.norm(), 1.4 * h) << h << " step " << step;
        EXPECT_GT(way.dot(along), 0.8 * way.norm()) << h << " step " << step;
        EXPECT_GT(walk.tangent().dot(along), 0.7) << h << " step " << step;
      }
    }
}

TEST(Explicit, a_free_choice_takes_beta2_which_never_fails_on_the_oval) {
  const Model model = planar_four_bar(5, 3, 5, 5);
  ExplicitWalk walk(model, crank_and_coupler_in_line());
  EXPECT_EQ(walk.independent(), 1);
  double smallest = 9, largest = -9;
  EXPECT_GT(walk_round(walk, 0.03, smallest, largest), 0);
  EXPECT_TRUE(walk.changes().empty());
  EXPECT_EQ(walk.independent(), 1);
}

TEST(Explicit, one_coordinate_alone_ends_at_its_limit_point) {
  const Model model = planar_four_bar(5, 3, 5, 5);
  ExplicitWalk walk(model, crank_and_coupler_in_line(), {.candidates = {0}});
  double smallest = 9, largest = -9;
  EXPECT_EQ(walk_round(walk, 0.03, smallest, largest), -1);
  EXPECT_NEAR(walk.here().q[0], pi / 2 - 2 * std::asin(0.2), 1e-6);
  EXPECT_GT(walk.conditions().condition, 1e3);
}

TEST(Explicit, a_walk_needs_one_freedom) {
  const Mechanism m = load_mechanism("four-bar-chain:2");
  EXPECT_THROW(ExplicitWalk(m.model, m.state), InputError);
}

}  // namespace
}  // namespace lanc::test
