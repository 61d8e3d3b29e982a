// Formulations of the reduced system on closed loops: agreement of all in the register, and what each has of its own.
#include <gtest/gtest.h>

#include <numbers>

#include "formulations/partitioning/partitioning.h"
#include "lib/io/mechanism.h"
#include "lib/system/closure_jacobian.h"
#include "lib/system/evaluator.h"
#include "tests/support/random_model.h"
#include "tests/support/tolerance.h"

namespace lanc::test {
namespace {

const char* const reduced[] = {"partitioning", "nullspace", "udwadia-kalaba", "augmented", "proximal"};

/// Largest difference of η̇ and â, relative to the largest acceleration; angles count with the model's length.
double difference_of_motions(const Model& model, const Solution<double>& a, const Solution<double>& b) {
  double largest = 0, size = 0;
  const auto add = [&](double x, double y, double unit) {
    largest = std::max(largest, std::abs(x - y) * unit), size = std::max(size, std::abs(y) * unit);
  };
  for (int k = 0; k < model.nv(); ++k)
    add(a.vdot[k], b.vdot[k], model.column_kind(k) == ColumnKind::translation ? 1 : model.length());
  for (int i = 0; i < model.bodies(); ++i) {
    const Motion<double>&x = a.acceleration[i], &y = b.acceleration[i];
    add(x.angular.x, y.angular.x, model.length()), add(x.angular.y, y.angular.y, model.length());
    add(x.angular.z, y.angular.z, model.length());
    add(x.linear.x, y.linear.x, 1), add(x.linear.y, y.linear.y, 1), add(x.linear.z, y.linear.z, 1);
  }
  return size > 0 ? largest / size : largest;
}

double largest(const std::vector<double>& x) {
  double size = 0;
  for (const double value : x) size = std::max(size, std::abs(value));
  return size;
}

/// λ of minimum norm is one; and what it does to the bodies is in the wrenches, which must agree too.
double reaction_difference(const Solution<double>& a, const Solution<double>& b) {
  double error = 0, size = largest(b.lambda);
  for (std::size_t k = 0; k < a.lambda.size(); ++k) error = std::max(error, std::abs(a.lambda[k] - b.lambda[k]));
  for (std::size_t i = 0; i < a.wrench.size(); ++i)
    size = std::max(size, std::sqrt(dot(b.wrench[i].force, b.wrench[i].force)));
  return error / size;
}

TEST(Constrained, all_formulations_agree_on_four_bars_and_with_the_closed_form) {
  for (const char* name : {"four-bar-ladder:3", "four-bar-ladder:10", "four-bar-ladder:3:cut=weld",
                           "four-bar-ladder:10:cut=weld", "four-bar-chain:4", "four-bar-chain:4:cut=weld"}) {
    const Mechanism m = load_mechanism(name);
    Evaluator<double> evaluator(m.model);
    const System<double>& system = evaluator.system(m.state);
    Solution<double> reference(m.model), solution(m.model);
    ASSERT_EQ(find_formulation("dense")->create_double(m.model)->solve(system, reference).status, Status::redundant);
    if (const std::string text = name; text.starts_with("four-bar-ladder")) {
      const double n = text[16] == '3' ? 3 : 10;
      const double exact = 9.81 * ((n + 1) / 2 + n) * std::sin(0.7) / ((n + 1) / 3 + n);
      EXPECT_NEAR(reference.vdot[0], exact, 1e-12 * exact) << name;
    }
    for (const FormulationInfo& info : formulations()) {
      if (!info.create_double || info.objection(m.model)) continue;
      const Outcome outcome = info.create_double(m.model)->solve(system, solution);
      EXPECT_EQ(outcome.status, Status::redundant) << info.name << " on " << name << ": " << outcome.message;
      EXPECT_LT(difference_of_motions(m.model, solution, reference), 1e-12) << info.name << " on " << name;
      EXPECT_LT(reaction_difference(solution, reference), 1e-12) << info.name << " on " << name;
    }
  }
}

/// A random tree whose bodies are fastened to one another and to the ground, anywhere: no state on the manifold is
/// needed where the rank is given. `twice`: the first closure again, measured along other axes, so that its three
/// conditions are redundant but for rounding.
Case random_loops(std::uint64_t seed, bool twice) {
  Random random(seed);
  Features features;
  features.prescribed = features.singular_inertias = false;
  const int bodies = 4 + random.below(9);
  ModelSpec spec = random_spec(seed, bodies, features);
  const int loops = 1 + random.below(3);
  for (int k = 0; k < loops; ++k) {
    ClosureSpec closure;
    closure.name = "closure" + std::to_string(k);
    constexpr const char* kinds[] = {"point-on-plane", "distance", "point-on-line", "point-on-point"};
    closure.kind = *find_closure_kind(kinds[k > 0 ? random.below(2) : twice ? 3 : random.below(4)]);
    closure.body_b = spec.bodies[bodies - 1 - k].name;
    if (random.chance(0.5)) closure.body_a = spec.bodies[0].name;
    closure.frame_a = {random.rotation(), random.vector(0.7)},
    closure.frame_b = {random.rotation(), random.vector(0.7)};
    const ClosureTraits& traits = closure.kind.traits();
    if (traits.axes != JointAxes::none) closure.axis = random.direction();
    if (traits.has_length) closure.length = 0.6;
    spec.closures.push_back(closure);
  }
  if (twice) {
    spec.closures.push_back(spec.closures[0]);
    spec.closures.back().name = "again";
    spec.closures.back().frame_a.rotation = random.rotation();
  }
  Case c{"loops", Model::build(spec), {}, {}};
  c.state = random_state(random, c.model);
  c.loads = random_loads(random, c.model);
  return c;
}

/// Number of mechanisms compared; ill-conditioned ones are left out.
int expect_agreement_on_random_loops(bool twice) {
  int compared = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    const Case c = random_loops(seed, twice);
    Evaluator<double> evaluator(c.model);
    const System<double>& system = evaluator.system(c.state, c.loads);
    Solution<double> reference(c.model), solution(c.model);
    const RankPolicy policy{c.model.closures().rows() - (twice ? 3 : 0)};
    const Outcome expected = find_formulation("dense")->create_double(c.model)->solve(system, reference, policy);
    if (!expected.usable() || expected.rank != policy.rank || expected.sigma < 1e-3) continue;
    ++compared;
    for (const FormulationInfo& info : formulations()) {
      if (!info.create_double || info.objection(c.model)) continue;
      const Outcome outcome = info.create_double(c.model)->solve(system, solution, policy);
      EXPECT_EQ(outcome.status, expected.status) << info.name << " on seed " << seed << ": " << outcome.message;
      EXPECT_LT(difference_of_motions(c.model, solution, reference), 1e-9) << info.name << " on seed " << seed;
      EXPECT_LT(reaction_difference(solution, reference), 1e-9) << info.name << " on seed " << seed;
    }
  }
  return compared;
}

TEST(Constrained, all_formulations_agree_on_random_closures_of_full_rank) {
  EXPECT_GE(expect_agreement_on_random_loops(false), 30);
}

TEST(Constrained, all_formulations_agree_on_random_closures_that_are_redundant_but_for_rounding) {
  EXPECT_GE(expect_agreement_on_random_loops(true), 30);
}

TEST(Constrained, iterations_on_contradictory_conditions_end_at_the_least_squares_answer_of_the_scaled_rows) {
  int compared = 0, contradicting = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Case c = random_loops(seed, true);
    Evaluator<double> evaluator(c.model);
    System<double> system = evaluator.system(c.state, c.loads);
    system.rhs.closure.back() += 1;
    const RankPolicy policy{c.model.closures().rows() - 3};
    Solution<double> reference(c.model), solution(c.model);
    const Outcome expected = find_formulation("dense")->create_double(c.model)->solve(system, reference, policy);
    contradicting += expected.status == Status::inconsistent;
    if (expected.rank != policy.rank || expected.sigma < 1e-3) continue;
    ++compared;
    for (const char* name : {"augmented", "proximal"}) {
      const auto formulation = find_formulation(name)->create_double(c.model);
      formulation->decide(system, policy);
      formulation->assemble(system);
      ASSERT_TRUE(formulation->factorise(system).usable()) << name;
      formulation->substitute(system, system.rhs, solution);  // γ̿ as it is
      EXPECT_LT(difference_of_motions(c.model, solution, reference), 1e-8) << name << " on seed " << seed;
      const auto* iterated = dynamic_cast<const RegularisedFormulation<double>*>(formulation.get());
      ASSERT_TRUE(iterated) << name;
      EXPECT_LE(iterated->steps(), 6) << name << " on seed " << seed;
    }
  }
  EXPECT_GE(compared, 10);
  EXPECT_GE(contradicting, 18);  // of the others the row that was changed hardly depends on others
}

TEST(Constrained, in_long_double_and_on_count_the_answer_is_that_of_double) {
  const Mechanism m = load_mechanism("four-bar-ladder:3");
  Evaluator<double> evaluator(m.model);
  Evaluator<long double> wide_evaluator(m.model);
  Evaluator<Count> count_evaluator(m.model);
  State<long double> wide_state{m.state.t, {m.state.q.begin(), m.state.q.end()}, {m.state.v.begin(), m.state.v.end()}};
  State<Count> count_state{m.state.t, {m.state.q.begin(), m.state.q.end()}, {m.state.v.begin(), m.state.v.end()}};
  for (const char* name : reduced) {
    const FormulationInfo& info = *find_formulation(name);
    Solution<double> solution(m.model);
    Solution<long double> wide(m.model);
    Solution<Count> counted(m.model);
    EXPECT_TRUE(info.create_double(m.model)->solve(evaluator.system(m.state), solution).usable()) << name;
    EXPECT_TRUE(info.create_long_double(m.model)->solve(wide_evaluator.system(wide_state), wide).usable()) << name;
    const Tally before = Count::tally();
    EXPECT_TRUE(info.create_count(m.model)->solve(count_evaluator.system(count_state), counted).usable()) << name;
    EXPECT_GT((Count::tally() - before).flops(), 1000) << name;
    for (int k = 0; k < m.model.nv(); ++k) {
      EXPECT_NEAR(static_cast<double>(wide.vdot[k]), solution.vdot[k], 1e-12 * largest(solution.vdot)) << name;
      EXPECT_NEAR(counted.vdot[k].value(), solution.vdot[k], 1e-12 * largest(solution.vdot)) << name;
    }
  }
}

/// Crank and rod of 1 m; the rod's tip stays at the height h. With s the crank's velocity, G^d vanishes where the rod
/// is perpendicular to the line; with s the rod's, where its tip is above the hinge of the crank. Never both.
constexpr double height = 0.3;
Mechanism offset_slider_crank() {
  return load_toml_text(R"(gravity = [0, 0, -9.81]
body = [{name = "crank", mass = 1, com = [0.5, 0, 0], inertia = [0, 0.1, 0.1]},
        {name = "rod", mass = 1, com = [0.5, 0, 0], inertia = [0, 0.1, 0.1]}]
joint = [{name = "j", type = "revolute", body = "crank", axis = [0, -1, 0]},
         {name = "k", type = "revolute", parent = "crank", body = "rod", axis = [0, -1, 0], position = [1, 0, 0]}]
closure = [{name = "slide", type = "point-on-plane", body_b = "rod", axis = [0, 0, 1], position_a = [0, 0, 0.3], position_b = [1, 0, 0]}])",
                        "slider-crank");
}

/// State in which the rod makes the angle `rod` with the line, at 1 rad/s.
State<double> on_the_line(double rod, double t) {
  const double crank = std::asin(height - std::sin(rod));
  const double crank_rate = -std::cos(rod) / std::cos(crank);
  return {t, {crank, rod - crank}, {crank_rate, 1 - crank_rate}};
}

TEST(Constrained, partitioning_changes_s_where_its_Gd_goes_singular_keeps_it_otherwise_and_logs_it) {
  const Mechanism m = offset_slider_crank();
  const auto dense = find_formulation("dense")->create_double(m.model);
  Partitioning<double> partitioning(m.model);
  Evaluator<double> evaluator(m.model);
  Solution<double> reference(m.model), solution(m.model);
  const auto solve = [&](double rod, double t) {
    const System<double>& system = evaluator.system(on_the_line(rod, t));
    EXPECT_EQ(dense->solve(system, reference).status, Status::solved);
    const Outcome outcome = partitioning.solve(system, solution);
    EXPECT_EQ(outcome.status, Status::solved) << "rod at " << rod << ": " << outcome.message;
    EXPECT_LT(difference_of_motions(m.model, solution, reference), 1e-12) << "rod at " << rod;
  };
  solve(0.2, 0);
  EXPECT_EQ(partitioning.independent(), std::vector<int>{1});
  EXPECT_TRUE(partitioning.changes().empty());
  // at these two states exactly one of the choices is singular
  const double above_hinge = std::numbers::pi - std::asin(height / 2), upright = std::numbers::pi / 2;
  solve(upright, 1);  // not for s = rod
  EXPECT_TRUE(partitioning.changes().empty());
  solve(above_hinge - 0.1, 2);  // worse, not bad
  EXPECT_TRUE(partitioning.changes().empty());
  solve(above_hinge, 3);
  ASSERT_EQ(partitioning.changes().size(), 1u);
  const IndependentChange& change = partitioning.changes()[0];
  EXPECT_EQ(change.t, 3);
  EXPECT_EQ(change.before, std::vector<int>{1});
  EXPECT_EQ(change.after, std::vector<int>{0});
  EXPECT_GT(change.condition_before, 1e10);
  EXPECT_LT(change.condition_after, 10);
  EXPECT_EQ(partitioning.independent(), std::vector<int>{0});
  solve(above_hinge - 0.1, 4);  // the other would be as good again: kept
  EXPECT_EQ(partitioning.changes().size(), 1u);
  solve(upright, 5);
  ASSERT_EQ(partitioning.changes().size(), 2u);
  EXPECT_EQ(partitioning.changes()[1].after, std::vector<int>{1});
  partitioning.reset();
  EXPECT_TRUE(partitioning.changes().empty());
  solve(0.2, 6);
  EXPECT_TRUE(partitioning.changes().empty());
}

/// A four-bar whose coupler has no mass: without the loop its freedom has no inertia.
Mechanism massless_coupler() {
  Mechanism m = load_mechanism("four-bar-ladder:1");
  ModelSpec spec = m.model.spec();
  for (BodySpec& body : spec.bodies)
    if (body.name == "c1") body.mass = 0, body.inertia.setZero();
  m.model = Model::build(spec);
  return m;
}

TEST(Constrained, a_massless_coupler_is_solved_by_what_does_not_divide_by_the_mass_matrix_of_the_tree) {
  const Mechanism m = massless_coupler();
  ASSERT_TRUE(m.model.has_singular_inertia());
  Evaluator<double> evaluator(m.model);
  const System<double>& system = evaluator.system(m.state);
  Solution<double> solution(m.model);
  const double exact = 9.81 * std::sin(0.7) * 1.5;  // two uniform uprights of 1 m: each a pendulum of its own
  for (const FormulationInfo& info : formulations()) {
    if (!info.create_double || info.objection(m.model)) continue;
    const Outcome outcome = info.create_double(m.model)->solve(system, solution);
    if (outcome.usable()) EXPECT_NEAR(solution.vdot[0], exact, 1e-12 * exact) << info.name;
    for (const char* name : {"partitioning", "nullspace", "augmented", "proximal", "dense"})
      if (info.name == name) EXPECT_EQ(outcome.status, Status::redundant) << info.name << ": " << outcome.message;
    if (info.name == "udwadia-kalaba") EXPECT_EQ(outcome.status, Status::objection);
  }
}

TEST(Constrained, a_mechanism_without_any_freedom_left_stands_still) {
  Mechanism m = offset_slider_crank();
  ModelSpec spec = m.model.spec();
  ClosureSpec wall = spec.closures[0];
  wall.name = "wall", wall.axis = Eigen::Vector3d::UnitX(), wall.frame_a.position = {2 * std::cos(0.2), 0, 0};
  spec.closures[0].frame_a.position.z() = 2 * std::sin(0.2);
  spec.closures.push_back(wall);
  const Model model = Model::build(spec);
  Evaluator<double> evaluator(model);
  const System<double>& system = evaluator.system(State<double>{0, {0.3, -0.2}, {0, 0}});
  for (const char* name : reduced) {
    Solution<double> solution(model);
    const Outcome outcome = find_formulation(name)->create_double(model)->solve(system, solution, RankPolicy{2});
    EXPECT_EQ(outcome.status, Status::solved) << name << ": " << outcome.message;
    EXPECT_LT(largest(solution.vdot), 1e-12) << name;
    EXPECT_GT(largest(solution.lambda), 1) << name;
  }
}

}  // namespace
}  // namespace lanc::test
