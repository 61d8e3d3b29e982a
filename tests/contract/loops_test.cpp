// Closed loops, every formulation that takes them: closed forms, and statuses.
#include <gtest/gtest.h>

#include "lib/formulation/formulation.h"
#include "lib/io/mechanism.h"
#include "lib/system/evaluator.h"
#include "tests/support/tolerance.h"

namespace lanc::test {
namespace {

TEST(Loops, ladder_accelerates_as_its_closed_form_says) {
  for (const char* cut : {"point", "weld"})
    for (const int n : {1, 2, 5, 10, 30, 100}) {
      const Mechanism m = load_mechanism("four-bar-ladder:" + std::to_string(n) + ":cut=" + cut);
      const double exact = 9.81 * ((n + 1) / 2.0 + n) * std::sin(0.7) / ((n + 1) / 3.0 + n);
      for (const FormulationInfo& info : formulations()) {
        if (info.objection(m.model)) continue;
        Evaluator<double> evaluator(m.model);
        Solution<double> solution(m.model);
        const auto formulation = info.create_double(m.model);
        const Outcome outcome = formulation->solve(evaluator.system(m.state), solution);
        EXPECT_EQ(outcome.status, Status::redundant)
            << info.name << " " << n << ": " << to_string(outcome.status) << " " << outcome.message;
        EXPECT_EQ(outcome.redundant, (std::string(cut) == "point" ? 1 : 3) * n) << info.name;
        for (int k = 0; k < m.model.nv(); ++k)
          EXPECT_NEAR(solution.vdot[k], k % 2 == 0 || cut[0] == 'w' ? solution.vdot[k] : -exact, 1e-12 * exact)
              << info.name << " " << n;
        EXPECT_NEAR(solution.vdot[0], exact, 1e-12 * exact) << info.name << " " << n << " " << cut;
      }
    }
}

TEST(Loops, a_mechanism_that_cannot_move_is_redundant_and_not_singular) {
  // the projection of a direction on an empty kernel is a rounding error, which another place of the pin makes another
  for (const char* pin : {"[0.3, 0.0, 0.2]", "[0.1, 0.0, -0.7]", "[0.5, 0.2, 0.3]", "[0.21, 0.0, 0.33]"}) {
    const Mechanism m = load_toml_text(std::string(R"(
gravity = [0, 0, -9.81]
[[body]]
name = "a"
mass = 1.2
com = [0.1, 0, -0.4]
inertia = [0.06, 0.06, 0.01]
[[joint]]
name = "j"
type = "revolute"
body = "a"
axis = [0, 1, 0]
[[closure]]
name = "pin"
type = "point-on-point"
body_a = "a"
position_a = )") + pin +
                                           "\nposition_b = " + pin + "\n",
                                       "pinned");
    Evaluator<double> evaluator(m.model);
    for (const FormulationInfo& info : formulations()) {
      if (info.objection(m.model)) continue;
      Solution<double> solution(m.model);
      const Outcome outcome = info.create_double(m.model)->solve(evaluator.system(m.state), solution);
      EXPECT_EQ(to_string(outcome.status), "redundant") << info.name << ": " << outcome.message;
      EXPECT_EQ(outcome.redundant, 2) << info.name;
      EXPECT_NEAR(solution.vdot[0], 0, 1e-12) << info.name;
    }
  }
}

TEST(Loops, a_state_that_violates_them_changes_no_status_of_others) {
  const Mechanism m = load_mechanism("random-loops:1:seed=2:redundant=bennett");
  State<double> apart = m.state;
  for (std::size_t k = 0; k < apart.q.size(); ++k) apart.q[k] += 0.1 + 0.05 * static_cast<double>(k);
  Evaluator<double> evaluator(m.model);
  for (const FormulationInfo& info : formulations()) {
    if (info.objection(m.model)) continue;
    const auto formulation = info.create_double(m.model);
    Solution<double> solution(m.model);
    const auto status = [&](const State<double>& state) {
      return to_string(formulation->solve(evaluator.system(state), solution).status);
    };
    EXPECT_EQ(status(m.state), "redundant") << info.name;
    EXPECT_NE(status(apart), "redundant") << info.name;
    EXPECT_EQ(status(m.state), "redundant") << info.name;
  }
}

}  // namespace
}  // namespace lanc::test
