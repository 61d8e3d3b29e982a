// A mechanism that cannot be computed says what is to blame; a spring of no length gives the force it has there.
#include "lib/system/finite.h"

#include <gtest/gtest.h>

#include <limits>

#include "lib/formulation/formulation.h"
#include "lib/io/mechanism.h"
#include "lib/system/evaluator.h"
#include "tests/support/tolerance.h"

namespace lanc {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// Two bodies on sliders along x and z; a spring between their reference points.
Mechanism sliders(const std::string& spring, const std::string& motion = "") {
  return load_toml_text(
      "body = [{name = 'a', mass = 1, inertia = [1, 1, 1]}, {name = 'b', mass = 2, inertia = [1, 1, 1]}]\n"
      "joint = [{name = 'along_x', type = 'prismatic', body = 'a', axis = [1, 0, 0]" +
          motion +
          "},\n {name = 'along_z', type = 'prismatic', body = 'b', axis = [0, 0, 1]}]\n"
          "[[spring]]\nname = 'band'\nbody_a = 'a'\nbody_b = 'b'\n" +
          spring,
      "sliders");
}

/// Accelerations of all coordinates by the recursion.
std::vector<double> accelerations(const Mechanism& mechanism, const State<double>& state) {
  Evaluator<double> evaluator(mechanism.model);
  const System<double>& system = evaluator.system(state);
  Solution<double> solution(mechanism.model);
  const Outcome outcome = find_formulation("recursive")->create_double(mechanism.model)->solve(system, solution);
  EXPECT_EQ(to_string(outcome.status), "solved") << outcome.message;
  return solution.vdot;
}

TEST(SpringOfNoLength, has_no_force_when_it_has_no_rest_length) {
  const auto vdot = accelerations(sliders("stiffness = 100"), {0, {0, 0}, {3, 4}});
  EXPECT_EQ(vdot, (std::vector<double>{0, 0}));
}

TEST(SpringOfNoLength, pulls_as_just_before_and_just_after_along_its_motion) {
  const Mechanism m = sliders("stiffness = 100\ndamping = 5");
  const auto at = [&](double t) { return accelerations(m, {0, {3 * t, 4 * t}, {3, 4}}); };
  const auto vdot = at(0);  // the ends part with (−3, 0, 4) m/s
  EXPECT_NEAR(vdot[0], -5 * 3, 1e-12);
  EXPECT_NEAR(vdot[1], -5 * 4 / 2.0, 1e-12);
  for (const double t : {-1e-9, 1e-9, -1e-200, 1e-200})
    for (int k = 0; k < 2; ++k) EXPECT_NEAR(at(t)[k], vdot[k], 1e-6) << t;
  EXPECT_EQ(accelerations(m, {0, {0, 0}, {0, 0}}), (std::vector<double>{0, 0}));
}

TEST(SpringOfNoLength, that_is_a_mere_damper_needs_no_direction_either) {
  EXPECT_NEAR(accelerations(sliders("damping = 5\nrest_length = 1"), {0, {0, 0}, {3, 4}})[0], -15, 1e-12);
}

TEST(SpringOfNoLength, with_a_rest_length_is_not_finite_and_named) {
  const Mechanism m = sliders("stiffness = 100\nrest_length = 0.1");
  Evaluator<double> evaluator(m.model);
  const System<double>& system = evaluator.system({0, {0, 0}, {0, 0}});
  for (const FormulationInfo& info : formulations()) {
    if (info.objection(m.model)) continue;
    Solution<double> solution(m.model);
    const Outcome outcome = info.create_double(m.model)->solve(system, solution);
    EXPECT_EQ(to_string(outcome.status), "not_finite") << info.name;
    EXPECT_NE(outcome.message.find("spring 'band'"), std::string::npos) << outcome.message;
    EXPECT_NE(outcome.message.find("rest_length"), std::string::npos) << outcome.message;
  }
}

/// Blame for a state and loads.
std::string blame(const Mechanism& m, const State<double>& state, const Loads<double>& loads = {}) {
  Evaluator<double> evaluator(m.model);
  const System<double>& system = evaluator.system(state, loads);
  const std::string words = not_finite_because(system);
  EXPECT_EQ(words.empty(), finite(system)) << words;
  return words;
}

TEST(NotFinite, names_what_is_to_blame) {
  const Mechanism plain = sliders("stiffness = 1");
  const Mechanism driven =
      sliders("stiffness = 1", ", motion = {type = 'spline', times = [0, 1, 2, 3], values = [0, 1, 0, 1]}");
  const auto expect = [](const std::string& words, const std::string& part) {
    EXPECT_NE(words.find(part), std::string::npos) << "expected: " << part << "\ngot: " << words;
  };
  EXPECT_EQ(blame(plain, {0, {1, 1}, {1, 1}}), "");
  EXPECT_EQ(blame(driven, {2.5, {1}, {1}}), "");
  expect(blame(driven, {3.5, {1}, {1}}), "prescribed motion of joint 'along_x'");
  expect(blame(plain, {0, {1, nan}, {1, 1}}), "position or velocity of joint 'along_z'");
  expect(blame(plain, {0, {1, 1}, {1, 1}}, {{}, {{0, {{0, nan, 0}, {0, 0, 0}}}}}), "load on body 'a'");
  expect(blame(plain, {0, {1, 1}, {1, 1}}, {{0, 1e200}, {}}), "force along 'along_z.travel_rate'");
}

TEST(NotFinite, names_the_joint_whose_motion_broke_not_those_it_carries) {
  const Mechanism chain = load_toml_text(
      "body = [{name = 'a', mass = 1, com = [0, 1, 0], inertia = [1, 1, 1]}, {name = 'b', mass = 1, inertia = [1, 1, "
      "1]}]\n"
      "joint = [{name = 'first', type = 'revolute', body = 'a', axis = [1, 0, 0], motion = {type = 'expression', "
      "formula = '1/t'}},\n {name = 'second', type = 'revolute', parent = 'a', body = 'b', position = [0, 1, 0], "
      "motion = {type = 'constant-speed', start = 0, rate = 1}}]\n",
      "chain");
  EXPECT_NE(blame(chain, {0, {}, {}}).find("'first'"), std::string::npos);
  EXPECT_EQ(blame(chain, {1, {}, {}}), "");
}

}  // namespace
}  // namespace lanc
