// The formulations that leave eq. 14 (or its Schur complement) to a sparse solver.
#include <gtest/gtest.h>

#include "formulations/recursive/recursive.h"
#include "lib/formulation/eq14_formulation.h"
#include "lib/system/equations.h"
#include "lib/system/evaluator.h"
#include "tests/support/random_model.h"
#include "tests/support/tolerance.h"

namespace lanc::test {
namespace {

/// The formulations of this file that are built; without the GPL there are fewer.
std::vector<const FormulationInfo*> sparse() {
  std::vector<const FormulationInfo*> result;
  for (const FormulationInfo& info : formulations())
    if (info.name.starts_with("eq14-") || info.name.starts_with("schur-")) result.push_back(&info);
  return result;
}

/// Error of η̇, â and f̂ relative to the largest entry of the same kind.
double error(const Solution<double>& x, const Solution<long double>& reference) {
  double worst = 0;
  const auto compare = [&worst](auto&& entries) {
    double difference = 0, norm = 0;
    entries([&](double a, long double b) {
      difference = std::max(difference, std::isfinite(a) ? static_cast<double>(std::abs(a - b)) : 1e300);
      norm = std::max(norm, static_cast<double>(std::abs(b)));
    });
    if (difference > 0) worst = std::max(worst, difference / norm);
  };
  const auto three = [](auto&& put, const Vec3<double>& a, const Vec3<long double>& b) {
    put(a.x, b.x), put(a.y, b.y), put(a.z, b.z);
  };
  compare([&](auto put) {
    for (size_t k = 0; k < x.vdot.size(); ++k) put(x.vdot[k], reference.vdot[k]);
  });
  compare([&](auto put) {
    for (size_t i = 0; i < x.acceleration.size(); ++i) {
      three(put, x.acceleration[i].angular, reference.acceleration[i].angular);
      three(put, x.acceleration[i].linear, reference.acceleration[i].linear);
    }
  });
  compare([&](auto put) {
    for (size_t i = 0; i < x.wrench.size(); ++i) {
      three(put, x.wrench[i].moment, reference.wrench[i].moment);
      three(put, x.wrench[i].force, reference.wrench[i].force);
    }
  });
  return worst;
}

Solution<long double> reference(const Case& c) {
  Evaluator<long double> evaluator(c.model);
  Recursive<long double> recursive(c.model);
  Solution<long double> solution(c.model);
  const Outcome outcome =
      recursive.solve(evaluator.system(cast<long double>(c.state), cast<long double>(c.loads)), solution);
  EXPECT_TRUE(outcome.usable()) << c.name << ": " << outcome.message;
  return solution;
}

const Features regular{.singular_inertias = false};

TEST(SparseFormulations, agree_with_the_recursion_in_long_double_on_random_trees_of_all_joints) {
  for (int seed = 0; seed < 60; ++seed) {
    const int bodies = 1 + seed % 20;
    const Case c = random_case(seed, bodies, regular);
    const Solution<long double> expected = reference(c);
    Evaluator<double> evaluator(c.model);
    const System<double>& system = evaluator.system(c.state, c.loads);
    for (const FormulationInfo* info : sparse()) {
      ASSERT_EQ(info->objection(c.model), std::nullopt);
      Solution<double> solution(c.model);
      const auto formulation = info->create_double(c.model);
      const Outcome outcome = formulation->solve(system, solution);
      ASSERT_EQ(outcome.status, Status::solved) << info->name << " on " << c.name << ": " << outcome.message;
      EXPECT_TRUE(within(c.name + " by " + std::string(info->name), error(solution, expected), bodies, 1));
    }
  }
}

TEST(SparseFormulations, follow_from_one_state_to_the_next_with_the_analysis_of_the_model) {
  Case c = random_case(5, 25, regular);
  Evaluator<double> evaluator(c.model);
  for (const FormulationInfo* info : sparse()) {
    const auto formulation = info->create_double(c.model);
    Solution<double> solution(c.model);
    for (int step = 0; step < 5; ++step) {
      Random random(step);
      c.state = random_state(random, c.model);
      const Outcome outcome = formulation->solve(evaluator.system(c.state, c.loads), solution);
      ASSERT_EQ(outcome.status, Status::solved) << info->name << ": " << outcome.message;
      EXPECT_TRUE(within(std::string(info->name), error(solution, reference(c)), 25, 1));
    }
  }
}

TEST(SparseFormulations, solve_for_another_right_hand_side_with_the_same_factors) {
  const Case c = random_case(11, 12, regular);
  Evaluator<double> evaluator(c.model);
  const System<double>& system = evaluator.system(c.state, c.loads);
  for (const FormulationInfo* info : sparse()) {
    const auto formulation = info->create_double(c.model);
    Solution<double> once(c.model), twice(c.model);
    ASSERT_TRUE(formulation->solve(system, once).usable());
    RightHandSide<double> doubled = system.rhs;
    for (auto& f : doubled.force) f = f * 2.0;
    for (auto& a : doubled.bias) a = a * 2.0;
    for (auto& t : doubled.tau) t *= 2;
    formulation->substitute(system, doubled, twice);
    for (int k = 0; k < c.model.nv(); ++k) EXPECT_DOUBLE_EQ(twice.vdot[k], 2 * once.vdot[k]) << info->name;
    EXPECT_LT(formulation->refine(system, once), 1e-9) << info->name;
  }
}

TEST(SparseFormulations, all_variants_of_settings_agree) {
  const Case c = random_case(21, 30, regular);
  const Solution<long double> expected = reference(c);
  Evaluator<double> evaluator(c.model);
  const System<double>& system = evaluator.system(c.state, c.loads);
  for (const FormulationInfo* info : sparse()) {
    for (const Variant& variant : info->variants) {
      const auto formulation = variant.create(c.model);
      Solution<double> solution(c.model);
      const Outcome outcome = formulation->solve(system, solution);
      const std::string name = std::string(info->name) + " " + std::string(variant.parameters);
      ASSERT_EQ(outcome.status, Status::solved) << name << ": " << outcome.message;
      EXPECT_TRUE(within(name, error(solution, expected), 30, 1));
      const auto statistics = formulation->statistics();
      ASSERT_TRUE(statistics.has_value());
      EXPECT_GT(statistics->factor_nonzeros, 0) << name;
      EXPECT_GT(statistics->bytes, 0) << name;
    }
  }
}

/// A chain of n equal bodies, or of bodies with masses that alternate by `ratio`, in units of `metre` a metre.
Case chain(int n, double ratio = 1, double metre = 1) {
  ModelSpec spec = random_spec(3, n,
                               {.prescribed = false,
                                .singular_inertias = false,
                                .dissipation = false,
                                .springs = false,
                                .wrenches = false,
                                .armature = false,
                                .only_joint = "revolute"});
  spec.gravity *= metre;
  for (int i = 0; i < n; ++i) {
    BodySpec& body = spec.bodies[i];
    JointSpec& joint = spec.joints[i];
    if (i > 0) joint.parent = spec.bodies[i - 1].name;
    const double factor = i % 2 ? ratio : 1;
    body.mass *= factor, body.com *= metre, body.inertia *= factor * metre * metre;
    joint.frame.position *= metre;
  }
  Case c{"chain", Model::build(spec), {}, {}};
  Random random(4);
  c.state = random_state(random, c.model);
  return c;
}

TEST(SparseFormulations, keep_their_digits_with_mass_ratios_of_a_million) {
  for (const double ratio : {1e-6, 1e6}) {
    Case c = chain(32, ratio);
    Evaluator<double> evaluator(c.model);
    for (const FormulationInfo* info : sparse()) {
      const auto formulation = info->create_double(c.model);
      Solution<double> solution(c.model);
      for (int step = 0; step < 3; ++step) {  // the pivots of the first state must do for the others
        Random random(step);
        c.state = random_state(random, c.model);
        const Outcome outcome = formulation->solve(evaluator.system(c.state), solution);
        if (!outcome.usable()) {
          EXPECT_EQ(outcome.status, Status::objection) << info->name << ": " << outcome.message;
          EXPECT_TRUE(info->name.starts_with("schur")) << info->name << ": " << outcome.message;
          continue;
        }
        EXPECT_TRUE(within_relative(std::string(info->name), error(solution, reference(c)), 1e-8, 1));
      }
    }
  }
}

TEST(SparseFormulations, take_a_model_in_millimetres) {
  const Case c = chain(10, 1, 1000);
  const Solution<long double> expected = reference(c);
  Evaluator<double> evaluator(c.model);
  const System<double>& system = evaluator.system(c.state);
  for (const FormulationInfo* info : sparse()) {
    const auto formulation = info->create_double(c.model);
    Solution<double> solution(c.model);
    const Outcome outcome = formulation->solve(system, solution);
    ASSERT_EQ(outcome.status, Status::solved) << info->name << ": " << outcome.message;
    EXPECT_TRUE(within(std::string(info->name), error(solution, expected), 10, 1));
  }
}

TEST(SparseFormulations, never_call_a_wrong_answer_solved_where_inertias_are_singular) {
  int solved = 0, possible = 0;
  for (int seed = 0; seed < 60; ++seed) {
    const Case c = random_case(seed, 2 + seed % 12);
    if (!c.model.has_singular_inertia()) continue;
    const Solution<long double> expected = reference(c);
    Evaluator<double> evaluator(c.model);
    const System<double>& system = evaluator.system(c.state, c.loads);
    for (const FormulationInfo* info : sparse()) {
      ++possible;
      if (info->objection(c.model)) continue;
      Solution<double> solution(c.model);
      const auto formulation = info->create_double(c.model);
      const Outcome outcome = formulation->solve(system, solution);
      if (!outcome.usable()) {
        EXPECT_EQ(outcome.status, Status::objection) << info->name << " on " << c.name << ": " << outcome.message;
        continue;
      }
      ++solved;
      EXPECT_TRUE(within_relative(c.name + " by " + std::string(info->name), error(solution, expected), 1e-6, 1));
    }
  }
  std::printf("%d of %d solved\n", solved, possible);
  EXPECT_GT(solved, possible / 4);
}

TEST(SparseFormulations, are_right_or_object_while_an_inertia_becomes_singular) {
  int objections = 0;
  for (int seed = 0; seed < 40; ++seed)
    for (double axial = 1; axial > 1e-17; axial /= 100) {
      ModelSpec spec = random_spec(seed, 6, {.singular_inertias = false, .armature = false, .only_joint = "revolute"});
      Random random(seed);
      for (int i = seed % 2; i < 6; i += 2) {  // a rod whose axis no coordinate plane contains
        const Eigen::Vector3d along = random.direction();
        spec.bodies[i].inertia =
            spec.bodies[i].mass / 12 * (Eigen::Matrix3d::Identity() - (1 - axial) * along * along.transpose());
      }
      Case c{"rods", Model::build(spec), {}, {}};
      c.state = random_state(random, c.model);
      const Solution<long double> expected = reference(c);
      Evaluator<double> evaluator(c.model);
      const System<double>& system = evaluator.system(c.state);
      for (const FormulationInfo* info : sparse()) {
        Solution<double> solution(c.model);
        Outcome outcome{Status::objection};
        if (!info->objection(c.model)) outcome = info->create_double(c.model)->solve(system, solution);
        if (outcome.status == Status::objection) {
          EXPECT_LT(axial, 1e-3) << info->name << ": " << outcome.message;
          ++objections;
          continue;
        }
        ASSERT_EQ(outcome.status, Status::solved) << info->name << ", " << axial << ": " << outcome.message;
        EXPECT_TRUE(within_relative(std::string(info->name) + ", axial inertia " + std::to_string(axial),
                                    error(solution, expected), 1e-6, 1));
      }
    }
  EXPECT_GT(objections, 0);
}

TEST(SparseFormulations, name_the_body_where_the_mass_matrix_is_singular) {
  // a massless body on a joint of its own: nothing resists η̇
  ModelSpec spec =
      random_spec(1, 3, {.prescribed = false, .singular_inertias = false, .armature = false, .only_joint = "revolute"});
  spec.bodies[2].mass = 0, spec.bodies[2].inertia.setZero();
  spec.joints[2].parent = spec.bodies[1].name;
  const Model model = Model::build(spec);
  Evaluator<double> evaluator(model);
  const System<double>& system = evaluator.system(neutral_state(model));
  for (const FormulationInfo* info : sparse()) {
    if (const auto why = info->objection(model)) {
      EXPECT_NE(why->find("body2"), std::string::npos) << *why;
      continue;
    }
    Solution<double> solution(model);
    const Outcome outcome = info->create_double(model)->solve(system, solution);
    EXPECT_EQ(outcome.status, Status::singular) << info->name;
    EXPECT_NE(outcome.message.find("body2"), std::string::npos) << info->name << ": " << outcome.message;
  }
}

TEST(SparseFormulations, of_maximal_coordinates_object_to_a_huge_star_with_the_number) {
  ModelSpec spec = random_spec(1, 4000, {.singular_inertias = false, .only_joint = "revolute"});
  for (int i = 1; i < 4000; ++i) spec.joints[i].parent = spec.bodies[0].name;
  const auto why = find_formulation("schur-cholmod")->objection(Model::build(spec));
  ASSERT_TRUE(why.has_value());
  EXPECT_NE(why->find("entries"), std::string::npos) << *why;
  EXPECT_EQ(find_formulation("eq14-klu")->objection(Model::build(spec)), std::nullopt);
}

/// Dense copy, rows by columns.
template <class S>
std::vector<std::vector<S>> dense(const Eq14Matrix<S>& matrix) {
  std::vector<std::vector<S>> result(matrix.size(), std::vector<S>(matrix.size(), S(0.0)));
  for (int c = 0; c < matrix.size(); ++c)
    for (int p = matrix.starts()[c]; p < matrix.starts()[c + 1]; ++p) result[matrix.rows()[p]][c] += matrix.values()[p];
  return result;
}

constexpr Eq14Layout layouts[] = {
    {},
    {.bodies = BodyOrder::root_to_leaf},
    {.rows = {Block::acceleration, Block::wrench, Block::velocity},
     .columns = {Block::wrench, Block::acceleration, Block::velocity}},
    {.bodies = BodyOrder::root_to_leaf,
     .rows = {Block::velocity, Block::wrench, Block::acceleration},
     .columns = {Block::wrench, Block::velocity, Block::acceleration}},
};

TEST(Eq14Matrix, times_a_solution_is_the_left_hand_side_in_every_layout) {
  const Case c = random_case(8, 14);
  Evaluator<double> evaluator(c.model);
  const System<double>& system = evaluator.system(c.state, c.loads);
  const Solution<double> solution = [&] {
    Solution<double> x(c.model);
    EXPECT_TRUE(Recursive<double>(c.model).solve(system, x).usable());
    return x;
  }();
  for (const Eq14Layout& layout : layouts) {
    Eq14Matrix<double> matrix(c.model, layout);
    matrix.refill(system);
    std::vector<double> x(matrix.size()), b(matrix.size());
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
    Solution<double> back(c.model);
    matrix.gather(x, back);
    EXPECT_EQ(back.vdot, solution.vdot);
    matrix.scatter(system.rhs, b);
    const auto K = dense(matrix);
    for (int r = 0; r < matrix.size(); ++r) {
      double sum = 0, size = std::abs(b[r]);
      for (int k = 0; k < matrix.size(); ++k) sum += K[r][k] * x[k], size += std::abs(K[r][k] * x[k]);
      EXPECT_TRUE(within("row " + std::to_string(r), sum - b[r], matrix.size(), size));
    }
    for (int i = 0; i < c.model.bodies(); ++i)
      for (const Block block : {Block::acceleration, Block::wrench}) {
        EXPECT_EQ(matrix.body_of_column(matrix.column(i, block)), i);
        EXPECT_EQ(matrix.body_of_column(matrix.column(i, block) + 5), i);
      }
  }
}

TEST(Eq14Matrix, upper_triangle_is_half_of_the_symmetric_whole) {
  const Case c = random_case(9, 10);
  Evaluator<double> evaluator(c.model);
  const System<double>& system = evaluator.system(c.state, c.loads);
  Eq14Matrix<double> whole(c.model), half(c.model, {.upper_triangle = true});
  whole.refill(system), half.refill(system);
  const auto K = dense(whole), U = dense(half);
  for (int r = 0; r < whole.size(); ++r)
    for (int k = 0; k < whole.size(); ++k) {
      EXPECT_EQ(K[r][k], K[k][r]);
      EXPECT_EQ(U[r][k], r <= k ? K[r][k] : 0);
    }
}

TEST(Eq14Matrix, leaves_structural_zeros_out) {
  const Case c = chain(10);
  EXPECT_EQ(Eq14Matrix<double>(c.model).nonzeros(), 10 * (24 + 12 + 6) + 9 * 24);
  EXPECT_EQ(Eq14Matrix<double>(c.model, {.upper_triangle = true}).nonzeros(), 10 * (15 + 6 + 3) + 9 * 12);
}

}  // namespace
}  // namespace lanc::test
