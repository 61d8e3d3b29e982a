// What every formulation must do with every mechanism: satisfy eq. 14, be undone by inverse dynamics, keep no memory of
// earlier states, and never call `solved` what is not.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "lib/formulation/formulation.h"
#include "lib/system/equations.h"
#include "lib/system/evaluator.h"
#include "tests/support/naive.h"
#include "tests/support/tolerance.h"
#include "tests/support/zoo.h"

namespace lanc::test {
namespace {

/// Whether the coefficients show that an input was not finite; the speed of a slider on the ground, for one, is in
/// none.
bool all_finite(const System<double>& system) {
  double sum = 0;  // 0 × NaN and 0 × ∞ are NaN
  const auto add = [&](const Vec3<double>& a) { sum += 0 * a.x + 0 * a.y + 0 * a.z; };
  for (const auto& body : system.bodies) add(body.r), add(body.inertia.h);
  for (const auto& bias : system.rhs.bias) add(bias.angular), add(bias.linear);
  for (const auto& force : system.rhs.force) add(force.moment), add(force.force);
  for (const double tau : system.rhs.tau) sum += 0 * tau;
  return sum == 0;
}

/// The zoo's solvable small ones and random trees.
const std::vector<Case>& mechanisms() {
  static const std::vector<Case> all = [] {
    std::vector<Case> list = small_zoo();
    for (int seed = 0; seed < 40; ++seed) list.push_back(random_case(3100 + seed, 1 + seed % 20));
    return list;
  }();
  return all;
}

/// Calls check(info, case, formulation, system, solution) where the formulation solves the mechanism.
template <class Check>
void for_all_solved(Check check) {
  for (const Case& c : mechanisms()) {
    Evaluator<double> evaluator(c.model);
    const System<double>& system = evaluator.system(c.state, c.loads);
    for (const FormulationInfo& info : formulations()) {
      if (!info.create_double || info.objection(c.model)) continue;
      const auto formulation = info.create_double(c.model);
      Solution<double> solution(c.model);
      if (!formulation->solve(system, solution).usable()) continue;
      SCOPED_TRACE(std::string(info.name) + " on " + c.name);
      check(info, c, *formulation, system, solution);
    }
  }
}

TEST(Solve, agrees_with_eq_14_solved_naively_in_long_double) {
  for (const Case& c : mechanisms()) {
    const System<long double> wide = system_in_long_double(c);
    const Solution<long double> reference = reference_solution(c);
    const Norms size = sizes(wide, reference);
    for (const FormulationInfo& info : formulations()) {
      if (!info.create_double || info.objection(c.model)) continue;
      Evaluator<double> evaluator(c.model);
      Solution<double> solution(c.model);
      if (!info.create_double(c.model)->solve(evaluator.system(c.state, c.loads), solution).usable()) continue;
      const Norms e = relative(difference(c.model, solution, reference), size);
      EXPECT_TRUE(within(std::string(info.name) + " on " + c.name, e.worst(), 1 + c.model.bodies(), 1));
    }
  }
}

TEST(Solve, in_long_double_and_on_count_gives_the_answer_of_double) {
  for (const Case& c : mechanisms()) {
    const System<long double> wide = system_in_long_double(c);
    const Solution<long double> reference = reference_solution(c);
    const Norms size = sizes(wide, reference);
    for (const FormulationInfo& info : formulations()) {
      if (info.objection(c.model)) continue;
      const std::string who = std::string(info.name) + " on " + c.name;
      if (info.create_long_double) {
        Solution<long double> solution(c.model);
        const Outcome outcome = info.create_long_double(c.model)->solve(wide, solution);
        if (outcome.usable()) {
          EXPECT_TRUE(within_relative(who + " in long double",
                                      relative(difference(c.model, solution, reference), size).worst(), 1e-13, 1));
        }
      }
      if (info.create_count && info.create_double) {
        Evaluator<Count> counting(c.model);
        Evaluator<double> evaluator(c.model);
        Solution<Count> counted(c.model);
        Solution<double> solution(c.model);
        const Outcome a =
            info.create_count(c.model)->solve(counting.system(cast<Count>(c.state), cast<Count>(c.loads)), counted);
        const Outcome b = info.create_double(c.model)->solve(evaluator.system(c.state, c.loads), solution);
        EXPECT_EQ(to_string(a.status), to_string(b.status)) << who;
        if (a.usable() && b.usable()) {
          EXPECT_TRUE(within(who + " on Count", relative(difference(c.model, counted, solution), size).worst(),
                             1 + c.model.bodies(), 1));
        }
      }
    }
  }
}

TEST(Solve, leaves_a_residual_of_eq_14_at_rounding) {
  for_all_solved([](const FormulationInfo&, const Case& c, Formulation<double>&, const System<double>& system,
                    const Solution<double>& solution) {
    EXPECT_TRUE(within("normwise backward error", backward_error(system, solution).normwise, 1 + c.model.bodies(), 1));
  });
}

TEST(Solve, is_undone_by_inverse_dynamics) {
  for_all_solved([](const FormulationInfo&, const Case& c, Formulation<double>&, const System<double>& system,
                    const Solution<double>& solution) {
    Solution<double> again = solution;
    std::vector<double> tau;  // beyond rhs.tau, which holds the loads already
    inverse_dynamics(system, again, tau);
    const Norms size = sizes(system_in_long_double(c), reference_solution(c));
    for (int k = 0; k < c.model.nv(); ++k) {
      const double unit = c.model.column_kind(k) == ColumnKind::translation ? 1 : c.model.length();
      EXPECT_TRUE(within(c.model.velocity_names()[k], tau[k] / unit, 1 + c.model.bodies(), size.wrench));
    }
    EXPECT_TRUE(within("accelerations and wrenches", relative(difference(c.model, again, solution), size).worst(),
                       1 + c.model.bodies(), 1));
  });
}

TEST(Solve, fills_every_drive_force_from_its_joint_wrench) {
  for_all_solved([](const FormulationInfo&, const Case& c, Formulation<double>&, const System<double>& system,
                    const Solution<double>& solution) {
    Solution<double> again = solution;
    drive_forces(system, again);
    for (int d = 0; d < c.model.drives(); ++d) EXPECT_EQ(again.drive_force[d], solution.drive_force[d]);
  });
}

TEST(Solve, on_a_used_object_gives_what_a_fresh_one_gives) {
  for (const Case& c : mechanisms()) {
    Random random(8);
    Case other{c.name, c.model, random_state(random, c.model), random_loads(random, c.model)};
    for (const FormulationInfo& info : formulations()) {
      if (!info.create_double || info.objection(c.model)) continue;
      SCOPED_TRACE(std::string(info.name) + " on " + c.name);
      Evaluator<double> evaluator(c.model), fresh_evaluator(c.model);
      const auto used = info.create_double(c.model), fresh = info.create_double(c.model);
      Solution<double> a(c.model), b(c.model);
      const Outcome first = used->solve(evaluator.system(other.state, other.loads), a);
      if (first.usable()) used->refine(evaluator.system(other.state, other.loads), a);
      const Outcome second = used->solve(evaluator.system(c.state, c.loads), a);
      const Outcome alone = fresh->solve(fresh_evaluator.system(c.state, c.loads), b);
      EXPECT_EQ(to_string(second.status), to_string(alone.status));
      if (second.usable()) {
        EXPECT_EQ(difference(c.model, a, b).worst(), 0);
      }
    }
  }
}

TEST(Solve, recovers_from_a_state_that_was_not_finite) {
  for (const Case& c : mechanisms()) {
    if (c.model.nv() == 0) continue;
    for (const FormulationInfo& info : formulations()) {
      if (!info.create_double || info.objection(c.model)) continue;
      SCOPED_TRACE(std::string(info.name) + " on " + c.name);
      Evaluator<double> evaluator(c.model);
      const auto formulation = info.create_double(c.model), fresh = info.create_double(c.model);
      Solution<double> a(c.model), b(c.model);
      Loads<double> broken = c.loads;
      broken.tau.assign(c.model.nv(), std::numeric_limits<double>::quiet_NaN());
      EXPECT_EQ(to_string(formulation->solve(evaluator.system(c.state, broken), a).status), "not_finite");
      const Outcome again = formulation->solve(evaluator.system(c.state, c.loads), a);
      const Outcome alone = fresh->solve(evaluator.system(c.state, c.loads), b);
      EXPECT_EQ(to_string(again.status), to_string(alone.status));
      if (alone.usable()) {
        EXPECT_EQ(difference(c.model, a, b).worst(), 0);
      }
    }
  }
}

TEST(Solve, tells_not_finite_for_every_input_that_reaches_the_coefficients_and_is_not) {
  for (const Case& c : small_zoo(20)) {
    if (c.model.nv() == 0) continue;
    for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
      std::vector<Case> broken(4, c);
      broken[0].state.q[0] = bad;
      broken[1].state.v[c.model.nv() - 1] = bad;
      broken[2].loads.tau.assign(c.model.nv(), 0.0);
      broken[2].loads.tau[0] = bad;
      broken[3].loads.wrenches = {{c.model.bodies() - 1, {{0, bad, 0}, {0, 0, 0}}}};
      for (std::size_t k = 0; k < broken.size(); ++k)
        for (const FormulationInfo& info : formulations()) {
          if (!info.create_double || info.objection(c.model)) continue;
          Evaluator<double> evaluator(c.model);
          Solution<double> solution(c.model);
          const System<double>& system = evaluator.system(broken[k].state, broken[k].loads);
          const Outcome outcome = info.create_double(c.model)->solve(system, solution);
          if (k >= 2) {
            EXPECT_FALSE(all_finite(system));
          }
          EXPECT_EQ(to_string(outcome.status), all_finite(system) ? "solved" : "not_finite")
              << info.name << " on " << c.name << ", input " << k;
        }
    }
  }
}

TEST(Solve, of_a_nearly_singular_mechanism_is_right_or_not_called_solved) {
  for (const double ratio : {1e-4, 1e-8, 1e-10, 1e-12, 1e-14, 1e-16}) {
    for (int place = 0; place < 4; ++place) {
      for (const char* joint : {"revolute", "spherical", "free"}) {
        Features features;
        features.prescribed = features.singular_inertias = false;
        features.only_joint = joint;
        ModelSpec spec = random_spec(2100 + place, 4, features);
        for (JointSpec& j : spec.joints) j.coordinates.clear();
        spec.springs.clear(), spec.wrenches.clear();
        spec.bodies[place].mass *= ratio, spec.bodies[place].inertia *= ratio;
        Case c{"body " + std::to_string(place) + " of 1e" + std::to_string(std::lround(std::log10(ratio))) + " on " +
                   joint + " joints",
               Model::build(spec),
               {},
               {}};
        Random random(4);
        c.state = random_state(random, c.model);
        const Solution<long double> reference = reference_solution(c);
        const Norms size = sizes(system_in_long_double(c), reference);
        Evaluator<double> evaluator(c.model);
        for (const FormulationInfo& info : formulations()) {
          if (!info.create_double || info.objection(c.model)) continue;
          Solution<double> solution(c.model);
          if (!info.create_double(c.model)->solve(evaluator.system(c.state, c.loads), solution).usable()) continue;
          // solve() accepts an answer only when its last refinement changed it by less than 1e-8 of itself; what
          // refinement cannot see in double may be a hundred times that. The reference, in long double, is itself no
          // better than its ε over the ratio: at 1e-16 its light body is off by 1e-2, and schur-cholmod is right.
          const double promised = std::max(1e-6, 100 * double(std::numeric_limits<long double>::epsilon()) / ratio);
          EXPECT_TRUE(within_relative(std::string(info.name) + ", " + c.name,
                                      relative(difference(c.model, solution, reference), size).worst(), promised, 1));
        }
      }
    }
  }
}

TEST(Refine, never_makes_a_right_answer_worse) {
  for_all_solved([](const FormulationInfo&, const Case& c, Formulation<double>& formulation,
                    const System<double>& system, const Solution<double>& solution) {
    const Solution<long double> reference = reference_solution(c);
    const Norms size = sizes(system_in_long_double(c), reference);
    Solution<double> refined = solution;
    formulation.refine(system, refined);
    const double before = relative(difference(c.model, solution, reference), size).worst();
    const double after = relative(difference(c.model, refined, reference), size).worst();
    // both may be at rounding, where either can be the larger
    EXPECT_LE(after, std::max(2 * before, 100 * epsilon * (1 + c.model.bodies())));
  });
}

}  // namespace
}  // namespace lanc::test
