// Derivatives of forward dynamics: the analytic recursion against dual numbers, differences of solve(), and laws.
#include "lib/derivatives/forward_derivatives.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <filesystem>

#include "lib/closure/assembly.h"
#include "lib/formulation/formulation.h"
#include "lib/io/mechanism.h"
#include "lib/model/coordinates.h"
#include "lib/system/mass_matrix.h"
#include "tests/support/loop_cases.h"
#include "tests/support/random_model.h"
#include "tests/support/tolerance.h"
#include "tests/support/zoo.h"

namespace lanc::test {
namespace {

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

/// What issue "Speed" demands of two ways to the same derivatives.
constexpr double agreement = 1e-10;

using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
Eigen::Map<const Rows> view(const std::vector<double>& m, Eigen::Index columns) {
  return {m.data(), columns == 0 ? 0 : static_cast<Eigen::Index>(m.size()) / columns, columns};
}
double largest(const std::vector<double>& m) { return m.empty() ? 0 : view(m, 1).cwiseAbs().maxCoeff(); }
double difference(const std::vector<double>& a, const std::vector<double>& b) {
  if (a.size() != b.size()) return std::numeric_limits<double>::infinity();
  return a.empty() ? 0 : (view(a, 1) - view(b, 1)).cwiseAbs().maxCoeff();
}

/// A case at its state with the answer of the first formulation that has one.
struct Solved {
  const Case& c;
  Evaluator<double> evaluator;
  const System<double>& system;
  Solution<double> solution;
  Outcome outcome;

  explicit Solved(const Case& the_case)
      : c(the_case), evaluator(c.model), system(evaluator.system(c.state, c.loads)), solution(c.model) {
    for (const char* name : {"recursive", "dense", "nullspace"}) {
      outcome = find_formulation(name)->create_double(c.model)->solve(system, solution);
      if (outcome.usable()) return;
    }
  }
  Outcome analytic(AnalyticDerivatives& derivatives) {
    return derivatives.at(evaluator, system, c.state, c.loads, solution);
  }
  Outcome dual(DualDerivatives& derivatives) { return derivatives.at(system, c.state, solution); }
};

Case load(const std::string& name) {
  const Mechanism m = load_mechanism(name);
  return {name, m.model, m.state, {}};
}

/// A mechanism's lightest freedom, if all others stood still: 1 / kg m² or kg.
double lightest(const System<double>& system) {
  const std::vector<double> mass = mass_matrix(system);
  const auto M = view(mass, system.model.nv());
  return M.size() == 0 ? 0 : 1 / M.diagonal().minCoeff();
}

/// Errors relative to the largest entry, or to what a stiffness or damper of 1 would make where that is larger. Where
/// nothing can move (all derivatives are zero) to 1/1000 of what could without loops.
void expect_agreement(const Case& c) {
  SCOPED_TRACE(c.name);
  Solved solved(c);
  ASSERT_TRUE(solved.outcome.usable()) << solved.outcome.message;
  AnalyticDerivatives analytic(c.model);
  DualDerivatives dual(c.model, c.loads);
  const Outcome outcome = solved.analytic(analytic);
  ASSERT_TRUE(outcome.usable()) << outcome.message;
  ASSERT_TRUE(solved.dual(dual).usable());
  const ForwardDerivatives &a = analytic.derivatives(), &b = dual.derivatives();
  EXPECT_EQ(a.independent, b.independent);
  const double least = 1e-3 * lightest(solved.system), unit = std::max(largest(b.force), least);
  const auto agree = [](const char* what, const auto& x, const auto& y, double at_least) {
    EXPECT_TRUE(within_relative(what, difference(x, y), agreement, largest(y) + at_least));
  };
  agree("position", a.position, b.position, unit);
  agree("velocity", a.velocity, b.velocity, unit);
  agree("force", a.force, b.force, least);
  agree("multiplier position", a.multiplier_position, b.multiplier_position, 1);
  agree("multiplier velocity", a.multiplier_velocity, b.multiplier_velocity, 1);
  agree("multiplier force", a.multiplier_force, b.multiplier_force, 0);
}

TEST(ForwardDerivatives, recursion_and_dual_numbers_agree_on_random_trees_of_all_features) {
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    Case c = random_case(seed, 1 + static_cast<int>(seed % 16));
    c.name = "seed " + std::to_string(seed);
    expect_agreement(c);
  }
}

TEST(ForwardDerivatives, recursion_and_dual_numbers_agree_on_every_kind_of_joint_alone) {
  for (unsigned char kind = 0; kind < joint_kinds; ++kind)
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
      Features features;
      features.only_joint = std::string(JointKind{kind}.traits().name);
      features.singular_inertias = false;
      Case c = random_case(seed, 1 + static_cast<int>(seed), features);
      c.name = features.only_joint + ", seed " + std::to_string(seed);
      expect_agreement(c);
    }
}

TEST(ForwardDerivatives, recursion_and_dual_numbers_agree_on_mechanisms_of_every_kind) {
  for (const Case& c : small_zoo()) {
    AnalyticDerivatives analytic(c.model);
    Solved solved(c);
    if (const Outcome outcome = solved.analytic(analytic); outcome.status == Status::objection) {
      EXPECT_EQ(c.name, "mass matrix not positive definite") << outcome.message;
      continue;
    }
    expect_agreement(c);
  }
}

TEST(ForwardDerivatives, recursion_and_dual_numbers_agree_on_all_models_of_data) {
  int seen = 0;
  for (const char* folder : {"", "/linkages", "/problems"})
    for (const auto& entry :
         std::filesystem::directory_iterator(LANC_SOURCE_DIR "/data/models" + std::string(folder))) {
      if (entry.path().extension() != ".toml" && entry.path().extension() != ".urdf") continue;
      const Case c = load(entry.path().string());
      if (!Solved(c).outcome.usable()) continue;  // singular configurations, on purpose
      expect_agreement(c);
      ++seen;
    }
  EXPECT_GE(seen, 45);
}

TEST(ForwardDerivatives, recursion_and_dual_numbers_agree_on_closed_loops) {
  for (const Case& c : closed_loops()) expect_agreement(c);
  for (int seed = 1; seed <= 40; ++seed)
    expect_agreement(load("random-loops:" + std::to_string(1 + seed % 4) + ":seed=" + std::to_string(seed)));
}

/// The state reached by going `by` along velocities w, with positions and velocities that obey the conditions.
State<double> along(const Case& c, const Vector& w, double by) {
  State<double> moved = c.state;
  const Vector d = w * by;
  moved.q = displaced(c.model, c.state.q, {d.begin(), d.end()});
  if (!c.model.has_closures()) return moved;
  const AssemblyResult assembled = assemble(c.model, moved);
  EXPECT_TRUE(assembled.assembled()) << c.name;
  const VelocityResult consistent = consistent_velocities(c.model, assembled.state);
  EXPECT_TRUE(consistent.consistent) << c.name;
  return consistent.state;
}

/// Along a motion that keeps the conditions, the derivatives add up to the change of the answers of solve().
void expect_differences(const Case& c, std::uint64_t seed) {
  SCOPED_TRACE(c.name);
  Solved solved(c);
  ASSERT_TRUE(solved.outcome.usable()) << solved.outcome.message;
  AnalyticDerivatives analytic(c.model);
  ASSERT_TRUE(solved.analytic(analytic).usable());
  const int n = c.model.nv();
  const ForwardDerivatives& d = analytic.derivatives();
  // ∂η̇/∂τ τ obeys G w = 0, whatever τ
  Random random(seed);
  Vector tau(n);
  for (double& t : tau) t = random.uniform(-1, 1);
  Vector w = view(d.force, n) * tau;
  if (!(w.norm() > 1e-8)) return;  // no freedom
  w /= w.norm();
  constexpr double h = 1e-5;  // rounding of η̇ by h, and h² times third derivatives: about 1e-10 both
  const Case plus{c.name, c.model, along(c, w, h), c.loads}, minus{c.name, c.model, along(c, w, -h), c.loads};
  const Solved after(plus), before(minus);
  ASSERT_TRUE(after.outcome.usable() && before.outcome.usable());
  const auto quotient = [&](const std::vector<double>& a, const std::vector<double>& b) {
    return Vector((view(a, 1) - view(b, 1)) / (2 * h));
  };
  const Vector dv = quotient(plus.state.v, minus.state.v);
  const Vector found = view(d.position, n) * w + view(d.velocity, n) * dv;
  const Vector expected = quotient(after.solution.vdot, before.solution.vdot);
  const double size =
      (view(d.position, n).cwiseAbs() * w.cwiseAbs() + view(d.velocity, n).cwiseAbs() * dv.cwiseAbs()).maxCoeff();
  EXPECT_TRUE(within_relative("along a motion", (found - expected).cwiseAbs().maxCoeff(), 1e-8,
                              size + view(solved.solution.vdot, 1).cwiseAbs().maxCoeff()));
}

TEST(ForwardDerivatives, are_differences_of_solve_along_motions_that_keep_the_closure_conditions) {
  for (int seed = 1; seed <= 24; ++seed)
    expect_differences(load("random-loops:" + std::to_string(1 + seed % 3) + ":seed=" + std::to_string(seed)), seed);
  for (const char* linkage : {"bennett", "bricard", "sarrus", "stewart-gough"})
    expect_differences(load(LANC_SOURCE_DIR "/data/models/linkages/" + std::string(linkage) + ".toml"), 5);
  for (const char* cut : {"point", "hinge", "weld"})
    expect_differences(load("four-bar-ladder:3:cut=" + std::string(cut)), 5);
}

TEST(ForwardDerivatives, are_differences_of_solve_on_trees) {
  for (std::uint64_t seed = 1; seed <= 12; ++seed) expect_differences(random_case(seed, 5), seed);
}

TEST(ForwardDerivatives, with_respect_to_forces_are_the_inverse_mass_matrix_and_symmetric) {
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    const Case c = random_case(seed, 8);
    Solved solved(c);
    AnalyticDerivatives analytic(c.model);
    ASSERT_TRUE(solved.analytic(analytic).usable());
    const int n = c.model.nv();
    const Matrix inverse = view(analytic.derivatives().force, n);
    EXPECT_EQ(inverse, inverse.transpose()) << "seed " << seed;
    const Matrix one = view(mass_matrix(solved.system), n) * inverse;
    EXPECT_TRUE(within("M̄ M̄⁻¹, seed " + std::to_string(seed), (one - Matrix::Identity(n, n)).cwiseAbs().maxCoeff(), n,
                       (view(mass_matrix(solved.system), n).cwiseAbs() * inverse.cwiseAbs()).maxCoeff()));
  }
}

/// A random tree on one free body under gravity; nothing ties it to the world.
Case floating(std::uint64_t seed) {
  Features features;
  features.springs = features.wrenches = false;
  ModelSpec spec = random_spec(seed, 6, features);
  Random random(seed);
  spec.gravity = random.vector(9.81);
  for (JointSpec& joint : spec.joints)
    if (joint.parent.empty()) joint.parent = "the free one";
  spec.bodies.push_back(random_body(random, "the free one"));
  JointSpec free = random_joint(random, *find_joint_kind("free"), "free");
  free.body = "the free one";
  spec.joints.push_back(free);
  const Model model = Model::build(spec);
  Case c{"floating, seed " + std::to_string(seed), model, random_state(random, model), {}};
  c.loads.tau.resize(model.nv());
  for (double& t : c.loads.tau) t = random.uniform(-2, 2);
  return c;
}

TEST(ForwardDerivatives, of_a_free_mechanism_vanish_along_translations_and_turns_about_the_direction_of_gravity) {
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    const Case c = floating(seed);
    Solved solved(c);
    ASSERT_TRUE(solved.outcome.usable());
    AnalyticDerivatives analytic(c.model);
    ASSERT_TRUE(solved.analytic(analytic).usable());
    const int n = c.model.nv();
    const auto position = view(analytic.derivatives().position, n);
    int root = 0;
    while (c.model.link(root).parent != ground) ++root;
    const Link& link = c.model.link(root);
    ASSERT_EQ(link.nv, 6);
    const Mat3<double>& R = solved.evaluator.rotation(root);
    const Vec3<double> g = c.model.gravity(), turn = transpose_times(R, g),
                       shift = transpose_times(R, cross(g, solved.evaluator.positions()[root]));
    Matrix directions = Matrix::Zero(n, 4);
    directions.block(link.v, 0, 6, 1) << turn.x, turn.y, turn.z, shift.x, shift.y, shift.z;
    directions.block(link.v + 3, 1, 3, 3).setIdentity();
    const Matrix change = position * directions, size = position.cwiseAbs() * directions.cwiseAbs();
    EXPECT_TRUE(within(c.name, change.cwiseAbs().maxCoeff(), n, size.maxCoeff()));
    EXPECT_GT(position.middleCols(link.v, 3).cwiseAbs().maxCoeff(), 1e-3);  // about other axes they do not
  }
}

TEST(ForwardDerivatives, of_one_object_do_not_depend_on_what_it_did_before) {
  const Case first = random_case(3, 9);
  Random random(8);
  const Case second{"elsewhere", first.model, random_state(random, first.model), random_loads(random, first.model)};
  AnalyticDerivatives used(first.model), fresh(first.model);
  ASSERT_TRUE(Solved(first).analytic(used).usable());
  ASSERT_TRUE(Solved(second).analytic(used).usable());
  ASSERT_TRUE(Solved(second).analytic(fresh).usable());
  EXPECT_EQ(used.derivatives().position, fresh.derivatives().position);
  EXPECT_EQ(used.derivatives().velocity, fresh.derivatives().velocity);
  EXPECT_EQ(used.derivatives().force, fresh.derivatives().force);
}

TEST(ForwardDerivatives, that_would_be_wrong_are_refused) {
  for (const Case& c : held_by_loops()) {
    Solved solved(c);
    AnalyticDerivatives analytic(c.model);
    EXPECT_EQ(solved.analytic(analytic).status, Status::objection) << c.name;
  }
  Case open = load("four-bar-ladder:1:angle=0.7");
  open.state.q[0] += 0.01;
  const Case singular = load(LANC_SOURCE_DIR "/data/models/linkages/flat-parallelogram.toml");
  for (const auto& [c, expected] :
       {std::pair<const Case*, Status>{&open, Status::inconsistent}, {&singular, Status::singular}}) {
    Solved solved(*c);
    AnalyticDerivatives analytic(c->model);
    DualDerivatives dual(c->model, {});
    EXPECT_EQ(solved.analytic(analytic).status, expected) << c->name;
    EXPECT_EQ(solved.dual(dual).status, expected) << c->name;
  }
}

}  // namespace
}  // namespace lanc::test
