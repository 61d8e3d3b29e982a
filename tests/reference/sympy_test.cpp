// Two four-bars of SymPy's test suite and documentation (data/reference/sympy.csv).
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "lib/formulation/formulation.h"
#include "lib/io/mechanism.h"
#include "lib/system/evaluator.h"
#include "tests/support/reference_data.h"
#include "tests/support/tolerance.h"

namespace lanc::test {
namespace {

/// Calls check(name, solution) for every formulation that takes the mechanism; all of them must solve it.
template <class Check>
void by_every_formulation(const Mechanism& m, Check check) {
  int solved = 0;
  for (const FormulationInfo& info : formulations()) {
    if (!info.create_double || info.objection(m.model)) continue;
    Evaluator<double> evaluator(m.model);
    Solution<double> solution(m.model);
    const Outcome outcome = info.create_double(m.model)->solve(evaluator.system(m.state), solution);
    ASSERT_TRUE(outcome.usable()) << info.name << ": " << to_string(outcome.status) << " " << outcome.message;
    check(std::string(info.name), solution);
    ++solved;
  }
  EXPECT_GE(solved, 10);
}

TEST(SymPy, four_bar_accelerates_as_published) {
  const Mechanism m = load_mechanism(LANC_SOURCE_DIR "/data/models/linkages/sympy-four-bar.toml");
  const std::vector<double> expected = values(read_reference("sympy.csv").at("vdot"));
  by_every_formulation(m, [&](const std::string& name, const Solution<double>& solution) {
    for (int k = 0; k < m.model.nv(); ++k)
      EXPECT_TRUE(within_relative(name, solution.vdot[k] - expected[k], 1e-11, std::abs(expected[k])));
  });
}

/// Links of 1, 2 and 1 m and 5 kg/m, upright, their loop closed by a joint of this kind.
Mechanism upright_four_bar(const char* closure) {
  ModelSpec spec;
  spec.gravity = {0, -9.81, 0};
  const auto link = [&](const std::string& name, const std::string& parent, double from, double length) {
    const double mass = 5 * length, inertia = mass * length * length / 12;
    BodySpec body;
    body.name = name;
    body.mass = mass, body.com = {length / 2, 0, 0};
    body.inertia.diagonal() << 0, inertia, inertia;
    JointSpec joint;
    joint.name = "to " + name, joint.parent = parent, joint.body = name;
    joint.kind = *find_joint_kind("revolute");
    joint.frame.position = {from, 0, 0};
    spec.bodies.push_back(body), spec.joints.push_back(joint);
  };
  link("right", "", 1, 1);
  link("coupler", "right", 1, 2);
  link("left", "coupler", 2, 1);
  ClosureSpec loop;
  loop.name = "loop", loop.kind = *find_closure_kind(closure), loop.body_b = "left";
  loop.frame_a.position = {-1, 0, 0}, loop.frame_b.position = {1, 0, 0};
  spec.closures.push_back(loop);
  Model model = Model::build(spec);
  State<double> state = neutral_state(model);
  state.q.assign(3, std::numbers::pi / 2);
  return {std::move(model), std::move(state)};
}

TEST(SymPy, loop_joint_of_the_upright_four_bar_carries_half_of_its_weight) {
  const std::vector<double> expected = values(read_reference("sympy.csv").at("loop_joint_force"));
  for (const char* closure : {"revolute", "point-on-line"}) {
    const Mechanism m = upright_four_bar(closure);
    const auto& names = m.model.closures().row_names;
    by_every_formulation(m, [&](const std::string& name, const Solution<double>& solution) {
      for (int k = 0; k < m.model.nv(); ++k) EXPECT_NEAR(solution.vdot[k], 0, 1e-12) << name;
      for (std::size_t k = 0; k < names.size(); ++k) {
        const double force = names[k] == "loop.x" ? expected[0] : names[k] == "loop.y" ? expected[1] : 0;
        EXPECT_TRUE(within(name + " " + names[k], solution.lambda[k] - force, 3, 98.1));
      }
    });
  }
}

}  // namespace
}  // namespace lanc::test
