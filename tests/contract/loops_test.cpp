// Closed loops, every formulation that takes them: closed forms.
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

}  // namespace
}  // namespace lanc::test
