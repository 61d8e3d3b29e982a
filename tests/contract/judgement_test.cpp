// Mechanisms on which a judgement of answers by residuals and corrections alone goes wrong: each found by trying.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "lib/formulation/formulation.h"
#include "lib/formulation/momentum_balance.h"
#include "lib/io/mechanism.h"
#include "lib/system/evaluator.h"
#include "tests/support/zoo.h"

namespace lanc {
namespace {

/// Status of every formulation without objection, and what it answers.
template <class Check>
void for_all_answers(const Mechanism& mechanism, const State<double>& state, const Check& check) {
  Evaluator<double> evaluator(mechanism.model);
  const System<double>& system = evaluator.system(checked_state(mechanism.model, state));
  for (const FormulationInfo& info : formulations()) {
    if (info.objection(mechanism.model)) continue;
    Solution<double> solution(mechanism.model);
    const Outcome outcome = info.create_double(mechanism.model)->solve(system, solution);
    if (outcome.status != Status::objection) check(info, outcome, solution);
  }
}

/// Every open mechanism of the zoo with an answer that passes the first look.
template <class Check>
void for_good_answers_of_trees(const Check& check) {
  int seen = 0;
  for (const test::Case& c : test::small_zoo()) {
    if (c.model.has_closures()) continue;
    Evaluator<double> evaluator(c.model);
    System<double> system = evaluator.system(c.state);
    Solution<double> solution(c.model);
    (void)find_formulation("recursive")->create_double(c.model)->solve(system, solution);
    if (judgement::first_look(system, solution) != 0) continue;  // massless on purpose
    ++seen;
    check(c, system, solution);
  }
  EXPECT_GT(seen, 10);
}

TEST(FirstLook, refuses_every_number_that_is_not_finite_and_every_torque_that_is_not_balanced) {
  for_good_answers_of_trees([](const test::Case& c, System<double>& system, Solution<double>& solution) {
    const auto refused = [&](double& number, const char* which) {
      const double good = number;
      for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
        number = bad;
        EXPECT_FALSE(judgement::first_look(system, solution) == 0) << c.name << ": " << which << " " << bad;
      }
      number = good;
    };
    for (double& vdot : solution.vdot) refused(vdot, "vdot");
    for (double& tau : system.rhs.tau) refused(tau, "tau");
    for (int i = 0; i < c.model.bodies(); ++i) {
      for (Vec3<double>* part : {&solution.wrench[i].moment, &solution.wrench[i].force})
        for (double* number : {&part->x, &part->y, &part->z}) refused(*number, "wrench");
      if (c.model.link(i).parent == ground) refused(system.bodies[i].r.y, "place");
    }
    for (int k = 0; k < c.model.nv(); ++k) {
      double& tau = system.rhs.tau[k];
      const Wrench<double>& load = system.rhs.force[c.model.body_of_velocity(k)];
      const double good = tau, size = 1 + std::abs(tau) + std::abs(load.moment.x) + std::abs(load.force.z);
      tau += 1e-3 * size;
      EXPECT_GT(judgement::first_look(system, solution), 0) << c.name << " " << k;
      tau = good;
    }
    EXPECT_EQ(judgement::first_look(system, solution), 0) << c.name;
  });
}

TEST(FirstLook, by_momentum_balance_finds_the_wrenches_and_refuses_the_same) {
  for_good_answers_of_trees([](const test::Case& c, System<double>& system, Solution<double>& solution) {
    const std::vector<Wrench<double>> expected = solution.wrench;
    MomentumBalance<double> balance(c.model);
    EXPECT_EQ(balance.look(system, solution, false), 0) << c.name;
    EXPECT_EQ(balance.look(system, solution, true), 0) << c.name;
    const auto norm = [](const Wrench<double>& f) {
      return std::sqrt(dot(f.moment, f.moment) + dot(f.force, f.force));
    };
    double size = 1;
    for (const Wrench<double>& f : expected) size = std::max(size, norm(f));
    for (int i = 0; i < c.model.bodies(); ++i)
      EXPECT_LT(norm(solution.wrench[i] - expected[i]), 1e-11 * size) << c.name << " body " << i;
    const auto refused = [&](double& number, double wrong) {
      const double good = std::exchange(number, wrong);
      for (const bool keep : {false, true})
        EXPECT_FALSE(balance.look(system, solution, keep) == 0) << c.name << " " << wrong;
      number = good;
    };
    for (double& vdot : solution.vdot) refused(vdot, std::numeric_limits<double>::quiet_NaN());
    for (int i = 0; i < c.model.bodies(); ++i) {
      refused(solution.acceleration[i].angular.x, std::numeric_limits<double>::infinity());
      refused(solution.acceleration[i].linear.y, std::numeric_limits<double>::quiet_NaN());
    }
    for (double& tau : system.rhs.tau) refused(tau, tau + 1e-3 * size);
  });
}

TEST(Judgement, a_double_pendulum_of_point_masses_is_solved_though_every_moment_is_zero) {
  const Mechanism pendulum = load_toml_text(R"(gravity = [0, 0, -9.81]
body = [{name = "a", mass = 1, com = [0, 0, -1]}, {name = "b", mass = 1, com = [0, 0, -1]}]
joint = [{name = "j", type = "revolute", body = "a", axis = [0, 1, 0]},
         {name = "k", type = "revolute", parent = "a", body = "b", axis = [0, 1, 0], position = [0, 0, -1]}])",
                                            "pendulum");
  for (const double q : {0.5, 1.0, 2.0}) {
    // textbook, equal masses and lengths, angles a and a + b from the vertical, at rest
    const double b = 0.3 + q / 2, d = -b, c = std::cos(d), g = 9.81;
    const double s1 = std::sin(q), s2 = std::sin(q + b);
    const double first = g * (s2 * c - 2 * s1) / (2 - c * c), second = -g * s2 - c * first;
    for_all_answers(pendulum, {0, {q, b}, {0, 0}},
                    [&](const FormulationInfo& info, const Outcome& outcome, const Solution<double>& solution) {
                      EXPECT_EQ(to_string(outcome.status), "solved") << info.name << ": " << outcome.message;
                      EXPECT_NEAR(solution.vdot[0], first, 1e-12) << info.name;
                      EXPECT_NEAR(solution.vdot[1], second - first, 1e-12) << info.name;
                    });
  }
}

TEST(Judgement, a_gimbal_in_lock_is_never_solved_though_its_equations_have_solutions) {
  const Mechanism gimbal = load_toml_text(R"(gravity = [1, 2, -9.81]
body = [{name = "a", mass = 0}, {name = "b", mass = 0},
        {name = "c", mass = 1, com = [0.1, 0.2, 1], inertia = [1, 1, 1]}]
joint = [{name = "j", type = "revolute", body = "a", axis = [0, 0, 1]},
         {name = "k", type = "revolute", parent = "a", body = "b", axis = [0, 1, 0]},
         {name = "l", type = "revolute", parent = "b", body = "c", axis = [0, 0, 1]}])",
                                          "gimbal");
  for_all_answers(gimbal, {0, {0.3, 0, 0.2}, {0, 0, 0}},
                  [&](const FormulationInfo& info, const Outcome& outcome, const Solution<double>&) {
                    EXPECT_EQ(to_string(outcome.status), "singular") << info.name;
                  });
  for_all_answers(gimbal, {0, {0.3, 0.5, 0.2}, {0, 0, 0}},
                  [&](const FormulationInfo& info, const Outcome& outcome, const Solution<double>&) {
                    EXPECT_EQ(to_string(outcome.status), "solved") << info.name << ": " << outcome.message;
                  });
}

TEST(Judgement, a_light_body_under_a_long_rigid_boom_is_right_or_not_called_solved) {
  // The boom's inertia of 2.7e10 is about axes across the hinge; about the hinge itself there are 2e-4 of the light
  // body.
  ModelSpec spec;
  const auto add = [&](const std::string& name, const char* joint, const std::string& parent, double mass, double x) {
    BodySpec body{.name = name, .mass = mass};
    body.inertia = Eigen::Vector3d::Constant(mass).asDiagonal();
    spec.bodies.push_back(body);
    JointSpec spec_of_joint{.name = "at_" + name, .kind = *find_joint_kind(joint), .parent = parent, .body = name};
    spec_of_joint.frame.position.x() = x;
    spec.joints.push_back(spec_of_joint);
  };
  add("light", "revolute", "", 2e-4, 0);
  add("b0", "revolute", "light", 1, 0);
  for (int k = 1; k <= 200; ++k) add("b" + std::to_string(k), "fixed", "b" + std::to_string(k - 1), 1, 100);
  spec.joints[0].coordinates = {CoordinateSpec{.torque = 1}};
  const Mechanism boom{Model::build(spec), {}};
  for_all_answers(boom, neutral_state(boom.model),
                  [&](const FormulationInfo& info, const Outcome& outcome, const Solution<double>& solution) {
                    if (outcome.usable()) EXPECT_NEAR(solution.vdot[0], 1 / 2e-4, 1e-6 / 2e-4) << info.name;
                  });
}

TEST(Judgement, numbers_that_overflow_are_told_apart_from_a_singular_mechanism) {
  Mechanism pendulum = load_mechanism("chain:3");
  Evaluator<double> evaluator(pendulum.model);
  for (const FormulationInfo& info : formulations()) {
    Solution<double> solution(pendulum.model);
    const Outcome outcome = info.create_double(pendulum.model)
                                ->solve(evaluator.system(pendulum.state, {{1e308, 1e308, 1e308}, {}}), solution);
    EXPECT_TRUE(outcome.usable() || outcome.status == Status::not_finite) << info.name << ": " << outcome.message;
  }
}

}  // namespace
}  // namespace lanc
