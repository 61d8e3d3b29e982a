#include "lib/system/power.h"

#include <cmath>

namespace lanc {
namespace {

double power_of(const Wrench<double>& wrench, const Motion<double>& twist) { return dot(twist, wrench); }

/// Torque beyond spring and rotor of one coordinate, as Evaluator has it, in two parts.
void add_coordinate(const CoordinateSpec& c, double v, Power& power) {
  power.loads += c.torque * v;
  const double s = v / std::sqrt(v * v + c.friction_speed * c.friction_speed);
  const double friction =
      s * ((c.friction_positive + c.friction_negative) / 2 + s * (c.friction_positive - c.friction_negative) / 2);
  power.dissipated -= (c.damping * v + friction) * v;
}

void add_springs(Evaluator<double>& evaluator, const Model& model, Power& power) {
  if (model.springs().empty()) return;
  const auto& positions = evaluator.positions();
  const auto& twists = evaluator.twists();
  for (const PointSpring& spring : model.springs()) {
    if (spring.damping == 0) continue;
    Vec3<double> x[2], u[2];
    const std::pair<int, Vec3<double>> ends[] = {{spring.body_a, spring.point_a}, {spring.body_b, spring.point_b}};
    for (int k = 0; k < 2; ++k) {
      const auto& [body, point] = ends[k];
      if (body == ground) {
        x[k] = point, u[k] = {0, 0, 0};
        continue;
      }
      const Vec3<double> arm = evaluator.rotation(body) * point;
      x[k] = positions[body] + arm;
      u[k] = twists[body].linear + cross(twists[body].angular, arm);
    }
    const Vec3<double> d = x[1] - x[0], speed = u[1] - u[0];
    const double squared = dot(d, d), along = dot(d, speed);
    power.dissipated -= spring.damping * (squared > 0 ? along * along / squared : dot(speed, speed));
  }
}

/// −λ γ̄ of conditions that are prescribed in time: γ̄ is what ġ is more than the velocities make of it.
void add_driven_closures(Evaluator<double>& evaluator, const System<double>& system, const State<double>& state,
                         const Solution<double>& solution, Power& power) {
  const ClosureSet& set = system.model.closures();
  const auto& twists = evaluator.twists();
  for (const Closure& c : set.closures) {
    if (c.motion < 0) continue;
    for (int k = c.row; k < c.row + c.conditions().count; ++k) {
      double driven = system.closure_rows[k].rate;
      if (c.body_a != ground) driven -= power_of(system.closure_rows[k].a, twists[c.body_a]);
      if (c.body_b != ground) driven -= power_of(system.closure_rows[k].b, twists[c.body_b]);
      power.drives -= solution.lambda[k] * driven;
    }
  }
  for (const Coupler& c : set.couplers)
    if (c.motion >= 0) power.drives += solution.lambda[c.row] * set.motions[c.motion]->at(state.t).velocity;
}

}  // namespace

Power power(Evaluator<double>& evaluator, const System<double>& system, const State<double>& state,
            const Loads<double>& loads, const Solution<double>& solution) {
  const Model& model = system.model;
  Power power;
  for (std::size_t k = 0; k < loads.tau.size(); ++k) power.loads += loads.tau[k] * state.v[k];
  for (const PassiveCoordinate& passive : model.passive()) {
    const Link& link = model.link(passive.body);
    add_coordinate(
        passive.spec,
        link.drive >= 0 ? model.motion(link.drive).at(state.t).velocity : state.v[link.v + passive.coordinate], power);
  }
  for (int d = 0; d < model.drives(); ++d)
    power.drives += solution.drive_force[d] * model.motion(d).at(state.t).velocity;
  const bool applied = !model.wrenches().empty() || !loads.wrenches.empty();
  if (applied || model.has_closures()) {
    const auto& twists = evaluator.twists();
    for (const ConstantWrench& w : model.wrenches()) power.loads += power_of(w.wrench, twists[w.body]);
    for (const auto& w : loads.wrenches) power.loads += power_of(w.wrench, twists[w.body]);
  }
  add_springs(evaluator, model, power);
  if (model.has_closures()) add_driven_closures(evaluator, system, state, solution, power);
  return power;
}

}  // namespace lanc
