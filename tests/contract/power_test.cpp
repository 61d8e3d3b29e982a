// Power = dE/dt: what drives, loads, dampers and friction put in is what the energy changes by, along the motion each
// formulation finds.
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "lib/formulation/formulation.h"
#include "lib/system/energy.h"
#include "tests/support/explicit_kinematics.h"
#include "tests/support/naive.h"
#include "tests/support/tolerance.h"
#include "tests/support/zoo.h"

namespace lanc::test {
namespace {

Real damper_and_friction(const CoordinateSpec& c, Real v) {
  // τ beyond the spring, by the words of CoordinateSpec; friction is smoothed as s = v / √(v² + speed²)
  const Real s = v / std::sqrt(v * v + Real(c.friction_speed) * c.friction_speed);
  const Real magnitude = (Real(c.friction_positive) + c.friction_negative) / 2 * s +
                         (Real(c.friction_positive) - c.friction_negative) / 2 * s * s;
  return c.torque - c.damping * v - magnitude;
}

/// Power of everything that is not conservative, in W, and the sum of magnitudes it is made of.
struct Power {
  Real sum = 0, size = 0;
  void add(Real x) { sum += x, size += std::abs(x); }
};

Power power_of(const Case& c, const Solution<double>& solution, const std::vector<BodyMotion>& x) {
  Power power;
  const Model& model = c.model;
  for (int k = 0; k < model.nv(); ++k)
    if (!c.loads.tau.empty()) power.add(Real(c.loads.tau[k]) * c.state.v[k]);
  for (const PassiveCoordinate& passive : model.passive()) {
    const Link& link = model.link(passive.body);
    const Real v = link.drive >= 0 ? Real(model.motion(link.drive).at(c.state.t).velocity)
                                   : Real(c.state.v[link.v + passive.coordinate]);
    power.add(damper_and_friction(passive.spec, v) * v);
  }
  for (int d = 0; d < model.drives(); ++d)
    power.add(Real(solution.drive_force[d]) * model.motion(d).at(c.state.t).velocity);
  const auto on_body = [&](int body, const Wrench<double>& w) {
    const Real3 moment(w.moment.x, w.moment.y, w.moment.z), force(w.force.x, w.force.y, w.force.z);
    power.add(moment.dot(x[body].omega) + force.dot(x[body].velocity));
  };
  for (const auto& w : c.loads.wrenches) on_body(w.body, w.wrench);
  for (const auto& w : model.wrenches()) on_body(w.body, w.wrench);
  for (const PointSpringSpec& s : model.spec().springs) {
    Real3 d = Real3::Zero(), rate = Real3::Zero();
    const auto end = [&](const std::string& name, const Eigen::Vector3d& point, Real sign) {
      if (name.empty()) {
        d += sign * point.cast<Real>();
        return;
      }
      const BodyMotion& b = x[*model.find_body(name)];
      const Real3 arm = b.pose.R * point.cast<Real>();
      d += sign * (b.pose.r + arm), rate += sign * (b.velocity + b.omega.cross(arm));
    };
    end(s.body_b, s.point_b, 1), end(s.body_a, s.point_a, -1);
    const Real stretching = d.normalized().dot(rate);
    power.add(-s.damping * stretching * stretching);
  }
  return power;
}

/// Only ω and v are wanted; without accelerations the curve stays where differences are accurate.
std::vector<BodyMotion> twists_of(const Case& c) {
  return body_motions(c.model, {cast<Real>(c.state), std::vector<Real>(c.model.nv(), 0), true});
}

void check_power(const FormulationInfo& info, const Case& c) {
  if (!info.create_double || info.objection(c.model)) return;
  Evaluator<double> evaluator(c.model);
  Solution<double> solution(c.model);
  const auto formulation = info.create_double(c.model);
  if (!formulation->solve(evaluator.system(c.state, c.loads), solution).usable()) return;

  const Curve curve{cast<Real>(c.state), {solution.vdot.begin(), solution.vdot.end()}, true};
  const Power power = power_of(c, solution, twists_of(c));
  Evaluator<Real> wide(c.model);
  const Real change = derivative([&](Real s) { return energy(wide, state_on(c.model, curve, s)).total(); });
  // the terms that cancel in dE/dt where nothing dissipates: power of the weights and springs
  const Real potential = derivative([&](Real s) { return energy(wide, state_on(c.model, curve, s)).potential; });
  const Real kinetic = derivative([&](Real s) { return energy(wide, state_on(c.model, curve, s)).kinetic; });
  EXPECT_TRUE(within_relative(std::string(info.name) + " on " + c.name, static_cast<double>(change - power.sum),
                              difference_accuracy,
                              static_cast<double>(1 + power.size + std::abs(potential) + std::abs(kinetic))));
}

TEST(Power, of_everything_that_acts_is_the_rate_of_energy_for_every_formulation_and_kind_of_model) {
  for (const Case& c : small_zoo())
    for (const FormulationInfo& info : formulations()) check_power(info, c);
}

TEST(Power, of_everything_that_acts_is_the_rate_of_energy_on_random_trees) {
  for (int seed = 0; seed < 60; ++seed) {
    const Case c = random_case(6100 + seed, 1 + seed % 15);
    for (const FormulationInfo& info : formulations()) check_power(info, c);
  }
}

TEST(Power, of_a_conservative_mechanism_is_zero) {
  Features features;
  features.prescribed = features.dissipation = features.wrenches = false;
  for (int seed = 0; seed < 20; ++seed) {
    const Case c = random_case(6200 + seed, 1 + seed % 15, features);
    Solution<double> unused(c.model);
    EXPECT_EQ(power_of(c, unused, twists_of(c)).size, 0);
    for (const FormulationInfo& info : formulations()) check_power(info, c);
  }
}

}  // namespace
}  // namespace lanc::test
