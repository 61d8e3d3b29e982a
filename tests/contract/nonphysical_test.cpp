// Inertias that no body can have, where they are allowed: M̄ may then be indefinite. One rule: eq. 14 has an answer as
// long as M̄ is regular; a formulation that needs M̄ positive definite objects, and nobody calls the mechanism singular.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <set>

#include "lib/formulation/formulation.h"
#include "lib/io/mechanism.h"
#include "lib/system/evaluator.h"
#include "lib/system/mass_matrix.h"

namespace lanc {
namespace {

/// Hinge about y; inertia about it: J + 2.
Mechanism pendulum(double J) {
  return load_toml_text(fmt::format("gravity = [0, 0, -10]\n"
                                    "[[body]]\nname = 'b'\nmass = 2\ncom = [0, 0, -1]\ninertia = [1, {}, 1]\n"
                                    "allow_nonphysical_inertia = true\n"
                                    "[[joint]]\nname = 'j'\ntype = 'revolute'\nbody = 'b'\naxis = [0, 1, 0]\n",
                                    J),
                        "pendulum");
}

/// Names of the formulations by status; `check` sees the answers.
template <class S, class Check>
std::map<std::string, std::set<std::string>> statuses(const Mechanism& m, const Check& check) {
  std::map<std::string, std::set<std::string>> names;
  Evaluator<S> evaluator(m.model);
  const System<S>& system = evaluator.system(cast<S>(m.state));
  for (const FormulationInfo& info : formulations()) {
    if (info.objection(m.model) || !info.factory<S>()) continue;
    Solution<S> solution(m.model);
    const Outcome outcome = info.factory<S>()(m.model)->solve(system, solution);
    names[std::string(to_string(outcome.status))].insert(std::string(info.name));
    if (outcome.usable()) check(to_double(solution.vdot[0]));
  }
  return names;
}

template <class S>
void check_negative_inertia() {
  Mechanism m = pendulum(-7);
  m.state.q[0] = 0.3;
  const double expected = -2 * 10 * std::sin(0.3) / (-7 + 2);  // it falls up
  const auto names = statuses<S>(m, [&](double vdot) { EXPECT_NEAR(vdot, expected, 1e-13); });
  EXPECT_EQ(names.size(), 2u);
  // Cholesky of M̄ or of the open chain's part of it; the other formulations pivot, or divide by one body's at a time
  EXPECT_EQ(names.at("objection"),
            (std::set<std::string>{"augmented", "dense", "nullspace", "partitioning", "proximal", "udwadia-kalaba"}));
  EXPECT_TRUE(names.at("solved").count("recursive"));
}

TEST(NonphysicalInertia, with_a_negative_mass_matrix_is_solved_or_objected_to) {
  check_negative_inertia<double>();
  check_negative_inertia<long double>();
  check_negative_inertia<Count>();
}

TEST(NonphysicalInertia, with_a_singular_mass_matrix_is_singular) {
  auto names = statuses<double>(pendulum(-2), [](double) {});
  EXPECT_EQ(names.count("solved"), 0u);
  for (const char* name : {"composite", "dense", "recursive", "eq14-klu"})
    EXPECT_TRUE(names["singular"].count(name)) << name;  // others may object that an inertia of a body is singular
}

TEST(NonphysicalInertia, that_leaves_the_mass_matrix_positive_definite_is_solved_by_all) {
  const auto names = statuses<double>(pendulum(-1), [](double vdot) { EXPECT_NEAR(vdot, 0, 1e-15); });
  EXPECT_EQ(names.size(), 1u);
  EXPECT_EQ(names.begin()->first, "solved");
}

TEST(NonphysicalInertia, of_any_size_may_make_the_mass_matrix_indefinite) {
  for (const double unit : {1e-12, 1.0, 1e12}) {
    ModelSpec spec;
    for (const double J : {1.0, -3.0}) {
      BodySpec body{.name = fmt::format("b{}", J), .mass = unit};
      body.inertia = J * unit * Eigen::Matrix3d::Identity();
      body.allow_nonphysical_inertia = true;
      spec.joints.push_back({.name = "j" + body.name,
                             .kind = *find_joint_kind("spherical"),
                             .parent = spec.bodies.empty() ? "" : spec.bodies[0].name,
                             .body = body.name});
      spec.bodies.push_back(body);
    }
    Evaluator<double> evaluator(Model::build(spec));
    EXPECT_TRUE(regular_but_indefinite(evaluator.system(neutral_state(Model::build(spec))))) << unit;
    for (BodySpec& body : spec.bodies) body.inertia.setIdentity();
    Evaluator<double> sound(Model::build(spec));
    EXPECT_FALSE(regular_but_indefinite(sound.system(neutral_state(Model::build(spec))))) << unit;
  }
}

}  // namespace
}  // namespace lanc
