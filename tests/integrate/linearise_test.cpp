// Small motions and states of rest, against closed forms.
#include "lib/integrate/linearise.h"

#include <gtest/gtest.h>

#include <cmath>

#include "lib/io/mechanism.h"
#include "lib/model/error.h"

namespace lanc::test {
namespace {

/// Point masses on massless rods, hinges about y, hanging down: the double pendulum of the textbooks.
const char* const double_pendulum = R"(
gravity = [0, 0, -9.81]
[[body]]
name = "a"
mass = 2
com = [0, 0, -1]
[[joint]]
name = "ja"
type = "revolute"
body = "a"
axis = [0, 1, 0]
[[body]]
name = "b"
mass = 1
com = [0, 0, -0.5]
[[joint]]
name = "jb"
type = "revolute"
parent = "a"
body = "b"
position = [0, 0, -1]
axis = [0, 1, 0]
)";

TEST(Linearised, double_pendulum_has_the_frequencies_of_its_closed_form) {
  Mechanism m = load_toml_text(double_pendulum, "pendulum");
  LinearisedMotion motion;
  ASSERT_TRUE(linearise(m.model, m.state, {}, motion).usable());
  // relative angles: M = [m1 + m2 (1 + l)², m2 (l + l²); ·, m2 l²], K = g [m1 + m2 (1 + l), m2 l; m2 l, m2 l]; l = 1/2
  const double M[] = {2 + 2.25, 0.75, 0.75, 0.25}, K[] = {9.81 * 3.5, 9.81 * 0.5, 9.81 * 0.5, 9.81 * 0.5};
  for (int k = 0; k < 4; ++k) {
    EXPECT_NEAR(motion.M[k], M[k], 1e-13);
    EXPECT_NEAR(motion.C[k], 0, 1e-13);
    EXPECT_NEAR(motion.K[k], K[k], 1e-12);
  }
  // det(K − w M) = 0
  const double a = M[0] * M[3] - M[1] * M[1], b = -(K[0] * M[3] + K[3] * M[0] - 2 * K[1] * M[1]),
               c = K[0] * K[3] - K[1] * K[1], root = std::sqrt(b * b - 4 * a * c);
  ASSERT_EQ(motion.eigenvalues.size(), 4u);
  EXPECT_NEAR(motion.eigenvalues[3].imag(), std::sqrt((-b + root) / (2 * a)), 1e-11);
  EXPECT_NEAR(motion.eigenvalues[2].imag(), std::sqrt((-b - root) / (2 * a)), 1e-11);
  for (const auto& s : motion.eigenvalues) EXPECT_NEAR(s.real(), 0, 1e-11);
}

TEST(Linearised, freedoms_without_inertia_have_no_eigenvalue) {
  // a damper and a spring on a massless carriage: s = −k/c alone
  Mechanism m = load_toml_text(R"(
[[body]]
name = "carriage"
mass = 0
[[joint]]
name = "slide"
type = "prismatic"
body = "carriage"
stiffness = 6
damping = 2
armature = 1e-300
)",
                               "carriage");
  LinearisedMotion motion;
  ASSERT_TRUE(linearise(m.model, m.state, {}, motion).usable());
  ASSERT_EQ(motion.eigenvalues.size(), 1u);
  EXPECT_NEAR(motion.eigenvalues[0].real(), -3, 1e-12);
}

TEST(Linearised, independent_velocities_must_be_as_many_as_there_are_freedoms_each_once) {
  const Mechanism tree = load_mechanism("chain:3"), loop = load_mechanism("four-bar-ladder:1:angle=0.7");
  LinearisedMotion motion;
  EXPECT_THROW((void)linearise(tree.model, tree.state, {0}, motion), InputError);
  EXPECT_THROW((void)linearise(tree.model, tree.state, {0, 1, 1}, motion), InputError);
  EXPECT_THROW((void)linearise(loop.model, loop.state, {0, 1}, motion), InputError);
  EXPECT_TRUE(linearise(loop.model, loop.state, {0}, motion).usable());
}

TEST(Linearised, a_mechanism_without_freedom_has_nothing_to_tell) {
  Mechanism m = load_mechanism(LANC_SOURCE_DIR "/data/models/joint-fixed.toml");
  LinearisedMotion motion;
  EXPECT_TRUE(equilibrium(m.model, m.state).usable());
  EXPECT_TRUE(linearise(m.model, m.state, {}, motion).usable());
  EXPECT_TRUE(motion.eigenvalues.empty());
}

TEST(Equilibrium, of_a_pendulum_is_found_from_anywhere_when_it_has_to_be_stable) {
  Mechanism m = load_toml_text(double_pendulum, "pendulum");
  for (const double start : {0.1, 1.5, 3.0, 3.141592653589793, -2.0}) {
    State<double> state = m.state;
    state.q = {start, 0.3};
    ASSERT_TRUE(equilibrium(m.model, state, {.stable = true}).usable()) << start;
    EXPECT_NEAR(std::remainder(state.q[0], 2 * M_PI), 0, 1e-11) << start;
    EXPECT_NEAR(std::remainder(state.q[1], 2 * M_PI), 0, 1e-11) << start;
  }
  State<double> upright = m.state;
  upright.q = {3.1, 0.05};
  ASSERT_TRUE(equilibrium(m.model, upright).usable());
  EXPECT_NEAR(upright.q[0], M_PI, 1e-11);  // the nearest is not stable
}

TEST(Equilibrium, of_closed_loops_is_that_of_their_closed_form) {
  // a four-bar of equal rods swings like a pendulum: at rest it hangs
  Mechanism m = load_mechanism("four-bar-ladder:2:angle=2:rate=0");
  State<double> state = m.state;
  ASSERT_TRUE(equilibrium(m.model, state, {.stable = true}).usable());
  LinearisedMotion motion;
  ASSERT_TRUE(linearise(m.model, state, {}, motion).usable());
  ASSERT_EQ(motion.eigenvalues.size(), 2u);
  // I phi'' = −c g phi, I = (N+1)/3 + N, c = (N+1)/2 + N (IFToMM problem A02), N = 2
  EXPECT_NEAR(motion.eigenvalues[1].imag(), std::sqrt(3.5 * 9.81 / 3), 1e-10);
}

TEST(Equilibrium, that_is_none_is_reported) {
  Mechanism m = load_toml_text(R"(
gravity = [0, 0, -9.81]
[[body]]
name = "b"
mass = 1
inertia = [1, 1, 1]
[[joint]]
name = "j"
type = "free"
body = "b"
)",
                               "falling");
  const Outcome outcome = equilibrium(m.model, m.state);
  EXPECT_FALSE(outcome.usable());
  EXPECT_FALSE(outcome.message.empty());
}

}  // namespace
}  // namespace lanc::test
