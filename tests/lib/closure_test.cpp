// Closure conditions: G, γ̄ and γ̿ are the derivatives of g, on and off the manifold, for every closure kind.
#include <gtest/gtest.h>

#include "lib/io/four_bars.h"
#include "lib/io/mechanism.h"
#include "lib/system/closure_jacobian.h"
#include "lib/system/equations.h"
#include "lib/system/evaluator.h"
#include "tests/support/explicit_kinematics.h"
#include "tests/support/random_model.h"
#include "tests/support/tolerance.h"

namespace lanc::test {
namespace {

Placement random_placement(Random& random) { return {random.rotation(), random.vector(0.7)}; }

std::vector<MotionSpec> some_motions() {
  return {ConstantSpeed{0.3, 0.7}, Polynomial{{0.9, -0.4, 0.3}}, Sine{0.5, 0.2, 1.7, 0.4},
          Formula{"0.8 + 0.1*sin(2*t)"}};
}

/// A tree of all joint kinds with one closure of every kind, driven where that can be, and couplers; at a state that
/// satisfies none of them.
Case off_the_manifold(std::uint64_t seed, bool driven) {
  Random random(seed);
  ModelSpec spec = random_spec(seed, 9);
  const auto body = [&] { return spec.bodies[random.below(static_cast<int>(spec.bodies.size()))].name; };
  for (unsigned char k = 0; k < closures::all_closures.size(); ++k) {
    const ClosureTraits& traits = ClosureKind{k}.traits();
    if (driven && !traits.can_be_driven()) continue;
    ClosureSpec closure;
    closure.name = std::string(traits.name);
    closure.kind = {k};
    closure.body_a = random.chance(0.2) ? std::string() : body();
    do closure.body_b = random.chance(0.1) ? std::string() : body();
    while (closure.body_b == closure.body_a);
    closure.frame_a = random_placement(random), closure.frame_b = random_placement(random);
    if (traits.axes != JointAxes::none) closure.axis = random.direction();
    if (traits.has_pitch) closure.pitch = 0.3;
    if (traits.has_length && !driven) closure.length = 0.6;
    if (driven) closure.motion = some_motions()[k % some_motions().size()];
    spec.closures.push_back(closure);
  }
  CouplerSpec coupler;
  coupler.name = "gear";
  for (const JointSpec& joint : spec.joints)
    if (!joint.motion && joint.kind.traits().nv > 0 && joint.kind.traits().rates_are_velocities())
      coupler.terms.push_back({joint.name, joint.kind.traits().nv - 1, random.uniform(0.5, 2)});
  coupler.offset = 0.2;
  if (driven) coupler.motion = Sine{0.1, 0.3, 1.1, 0.2};
  if (!coupler.terms.empty()) spec.couplers.push_back(coupler);
  spec.length = 1;
  Case c{"closures", Model::build(spec), {}, {}};
  c.state = random_state(random, c.model);
  return c;
}

Real relative_size(const System<Real>& system, int k) {
  const auto& row = system.closure_rows[k];
  return 1 + std::abs(row.g) + std::abs(system.rhs.closure[k]);
}

void expect_derivatives_of_g(const Case& c) {
  Random random(5);
  std::vector<Real> vdot;
  for (int k = 0; k < c.model.nv(); ++k) vdot.push_back(random.uniform(-2, 2));
  const Curve curve{cast<Real>(c.state), vdot, true};
  Evaluator<Real> evaluator(c.model);
  const System<Real> here = evaluator.system(curve.state);
  ClosureJacobian<Real> G(c.model);
  G.evaluate(here);
  State<Real> resting = curve.state;
  std::fill(resting.v.begin(), resting.v.end(), Real(0));
  Evaluator<Real> at_rest(c.model);
  const System<Real>& still = at_rest.system(resting);
  Solution<Real> solution(c.model);
  solution.vdot = vdot;
  accelerations(here, here.rhs, solution);
  std::vector<Real> second;
  closure_accelerations(here, here.rhs, solution, second);
  // ġ on the curve, exactly, where the state is exact: at its beginning, and to first order around
  const auto rate = [&](Real s, int k) {
    Evaluator<Real> other(c.model);
    return other.system(state_on(c.model, curve, s)).closure_rows[k].rate;
  };
  for (int k = 0; k < G.rows(); ++k) {
    const std::string& name = c.model.closures().row_names[k];
    const Real first = here.closure_rows[k].rate;
    // G is the part of ġ that grows with η
    const double G_error =
        static_cast<double>(std::abs(first - still.closure_rows[k].rate - G.times(k, curve.state.v)));
    EXPECT_TRUE(within(name + ": G η", G_error, c.model.bodies(), static_cast<double>(1 + std::abs(first))));
    const Real first_by_differences = derivative([&](Real s) {
      Evaluator<Real> other(c.model);
      return other.system(state_on(c.model, curve, s)).closure_rows[k].g;
    });
    const Real second_by_differences = derivative([&](Real s) { return rate(s, k); });
    const double size = static_cast<double>(relative_size(here, k));
    EXPECT_TRUE(within_relative(name + ": first derivative",
                                static_cast<double>(std::abs(first - first_by_differences)), difference_accuracy,
                                size));
    EXPECT_TRUE(within_relative(name + ": second derivative",
                                static_cast<double>(std::abs(second[k] - second_by_differences)), difference_accuracy,
                                size));
  }
}

TEST(Closures, rows_are_the_exact_derivatives_of_g_off_the_manifold) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) expect_derivatives_of_g(off_the_manifold(seed, false));
}

TEST(Closures, rows_of_driven_closures_are_the_exact_derivatives_of_g_too) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) expect_derivatives_of_g(off_the_manifold(seed, true));
}

TEST(Closures, four_bars_come_assembled_with_consistent_velocities) {
  for (const char* name :
       {"four-bar-ladder:7", "four-bar-ladder:7:cut=weld", "four-bar-chain:5", "four-bar-chain:5:cut=weld"}) {
    const Mechanism m = load_mechanism(name);
    Evaluator<double> evaluator(m.model);
    const System<double>& system = evaluator.system(m.state);
    ClosureJacobian<double> G(m.model);
    G.evaluate(system);
    for (int k = 0; k < G.rows(); ++k) {
      EXPECT_NEAR(system.closure_rows[k].g, 0, 1e-14) << name << " " << m.model.closures().row_names[k];
      EXPECT_NEAR(system.closure_rows[k].rate, 0, 1e-14) << name;
      EXPECT_NEAR(G.times(k, m.state.v), 0, 1e-14) << name;
    }
  }
}

}  // namespace
}  // namespace lanc::test
