// Laws that hold for any mechanism, checked for every formulation: numbering, the place of the world's origin, units,
// and the sign of time change no acceleration other than as they must.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "lib/formulation/formulation.h"
#include "lib/spatial/eigen.h"
#include "lib/system/evaluator.h"
#include "tests/support/naive.h"
#include "tests/support/tolerance.h"
#include "tests/support/zoo.h"

namespace lanc::test {
namespace {

std::vector<Case> random_cases(const Features& features = {}) {
  std::vector<Case> result;
  for (int seed = 0; seed < 25; ++seed) result.push_back(random_case(5100 + seed, 1 + seed, features));
  return result;
}

/// Empty where the formulation refuses.
std::optional<Solution<double>> solve(const FormulationInfo& info, const Case& c) {
  if (!info.create_double || info.objection(c.model)) return std::nullopt;
  Evaluator<double> evaluator(c.model);
  Solution<double> solution(c.model);
  if (!info.create_double(c.model)->solve(evaluator.system(c.state, c.loads), solution).usable()) return std::nullopt;
  return solution;
}

/// Every formulation must give on `changed` what `expected` makes of its answer on `c`.
template <class Expected>
void expect_law(const std::string& law, const Case& c, const Case& changed, Expected expected) {
  const Norms size = sizes(system_in_long_double(changed), reference_solution(changed));
  for (const FormulationInfo& info : formulations()) {
    const auto before = solve(info, c), after = solve(info, changed);
    EXPECT_EQ(before.has_value(), after.has_value()) << law << ": " << info.name << " solves only one on " << c.name;
    if (!before || !after) continue;
    const Solution<double> image = expected(*before);
    const double error = relative(difference(changed.model, *after, image), size).worst();
    EXPECT_TRUE(within(law + ": " + std::string(info.name) + " on " + c.name, error, c.model.bodies(), 1));
  }
}

/// State, loads and solutions follow the joints and bodies by name.
struct Renaming {
  const Model &from, &to;

  template <class Visit>
  void each(Visit visit) const {
    for (int i = 0; i < from.bodies(); ++i) visit(i, *to.find_body(from.spec().bodies[i].name));
  }
  State<double> state(const State<double>& s) const {
    State<double> result = s;
    each([&](int i, int j) {
      std::copy_n(s.q.begin() + from.link(i).q, from.link(i).nq, result.q.begin() + to.link(j).q);
      std::copy_n(s.v.begin() + from.link(i).v, from.link(i).nv, result.v.begin() + to.link(j).v);
    });
    return result;
  }
  Loads<double> loads(const Loads<double>& l) const {
    Loads<double> result = l;
    each([&](int i, int j) {
      if (!l.tau.empty())
        std::copy_n(l.tau.begin() + from.link(i).v, from.link(i).nv, result.tau.begin() + to.link(j).v);
      for (std::size_t k = 0; k < l.wrenches.size(); ++k)
        if (l.wrenches[k].body == i) result.wrenches[k].body = j;
    });
    return result;
  }
  Solution<double> solution(const Solution<double>& s) const {
    Solution<double> result(to);
    each([&](int i, int j) {
      result.acceleration[j] = s.acceleration[i], result.wrench[j] = s.wrench[i];
      std::copy_n(s.vdot.begin() + from.link(i).v, from.link(i).nv, result.vdot.begin() + to.link(j).v);
      if (from.link(i).drive >= 0) result.drive_force[to.link(j).drive] = s.drive_force[from.link(i).drive];
    });
    return result;
  }
};

void check_renumbering(const Case& c, const ModelSpec& spec) {
  Case changed{c.name, Model::build(spec), {}, {}};
  const Renaming renaming{c.model, changed.model};
  changed.state = renaming.state(c.state), changed.loads = renaming.loads(c.loads);
  expect_law("renumbering", c, changed, [&](const Solution<double>& s) { return renaming.solution(s); });
}

TEST(Invariance, the_order_of_siblings_changes_nothing) {
  for (const Case& c : random_cases()) {
    ModelSpec reversed = c.model.spec();
    std::reverse(reversed.bodies.begin(), reversed.bodies.end());
    check_renumbering(c, reversed);
    ModelSpec shuffled = c.model.spec();
    Random random(3);
    for (std::size_t k = shuffled.bodies.size(); k > 1; --k) {
      std::swap(shuffled.bodies[k - 1], shuffled.bodies[random.below(static_cast<int>(k))]);
      std::swap(shuffled.joints[k - 1], shuffled.joints[random.below(static_cast<int>(k))]);
    }
    check_renumbering(c, shuffled);
  }
}

Vec3<double> turned(const Eigen::Matrix3d& R, const Vec3<double>& a) {
  return from_eigen(Eigen::Vector3d(R * to_eigen(a)));
}

TEST(Invariance, a_rigid_motion_of_the_world_turns_accelerations_and_wrenches_and_leaves_the_rest) {
  Random random(17);
  for (const Case& c : random_cases()) {
    const Eigen::Matrix3d R = random.rotation();
    const Eigen::Vector3d shift = random.vector(3);
    ModelSpec spec = c.model.spec();
    spec.gravity = R * spec.gravity;
    for (JointSpec& joint : spec.joints)
      if (joint.parent.empty()) {
        joint.frame.rotation = R * joint.frame.rotation;
        joint.frame.position = R * joint.frame.position + shift;
      }
    for (PointSpringSpec& spring : spec.springs) {
      if (spring.body_a.empty()) spring.point_a = R * spring.point_a + shift;
      if (spring.body_b.empty()) spring.point_b = R * spring.point_b + shift;
    }
    for (WrenchSpec& w : spec.wrenches) w.moment = R * w.moment, w.force = R * w.force;
    spec.length = c.model.length();
    Case changed{c.name, Model::build(spec), c.state, c.loads};
    for (auto& w : changed.loads.wrenches) w.wrench = {turned(R, w.wrench.moment), turned(R, w.wrench.force)};
    expect_law("rigid motion of the world", c, changed, [&](Solution<double> s) {
      for (auto& a : s.acceleration) a = {turned(R, a.angular), turned(R, a.linear)};
      for (auto& f : s.wrench) f = {turned(R, f.moment), turned(R, f.force)};
      return s;
    });
  }
}

/// Other units: every quantity of dimension kg^a m^b s^c is multiplied by mass^a length^b time^c.
struct Units {
  double mass, length, time;
  double operator()(double a, double b, double c) const {
    return std::pow(mass, a) * std::pow(length, b) * std::pow(time, c);
  }
};

/// Angles, or lengths, of a coordinate.
bool is_rotation(ColumnKind kind) { return kind != ColumnKind::translation; }

void scale(const Units& u, bool rotation, CoordinateSpec& c) {
  const double length = rotation ? 1 : u.length;  // of the coordinate
  const double torque = u(1, 2, -2) / length;     // its force
  c.rest *= length;
  c.stiffness *= torque / length;
  c.damping *= torque / length * u.time;
  c.friction_positive *= torque, c.friction_negative *= torque, c.torque *= torque;
  c.friction_speed *= length / u.time;
  c.armature *= torque / length * u.time * u.time;
}

void scale(const Units& u, double length, MotionSpec& motion) {
  if (auto* m = std::get_if<ConstantSpeed>(&motion)) m->start *= length, m->rate *= length / u.time;
  if (auto* m = std::get_if<Polynomial>(&motion))
    for (std::size_t k = 0; k < m->coefficients.size(); ++k) m->coefficients[k] *= length * std::pow(u.time, -1.0 * k);
  if (auto* m = std::get_if<Sine>(&motion)) m->offset *= length, m->amplitude *= length, m->frequency /= u.time;
  if (auto* m = std::get_if<SplineTable>(&motion)) {
    for (double& t : m->times) t *= u.time;
    for (double& x : m->values) x *= length;
  }
  if (auto* m = std::get_if<Formula>(&motion)) {
    // t stands alone in the formulas of random_motion, never inside a name other than sqrt and tan
    std::string text;
    for (std::size_t k = 0; k < m->text.size(); ++k) {
      const bool in_name = (k > 0 && std::isalpha(static_cast<unsigned char>(m->text[k - 1]))) ||
                           (k + 1 < m->text.size() && std::isalpha(static_cast<unsigned char>(m->text[k + 1])));
      char number[40];
      std::snprintf(number, sizeof number, "(t/%.17g)", u.time);
      text += m->text[k] == 't' && !in_name ? std::string(number) : std::string(1, m->text[k]);
    }
    char factor[40];
    std::snprintf(factor, sizeof factor, "%.17g*(", length);
    m->text = factor + text + ")";
  }
}

Case scaled(const Units& u, const Case& c) {
  ModelSpec spec = c.model.spec();
  spec.gravity *= u(0, 1, -2);
  spec.length = c.model.length() * u.length;
  for (BodySpec& body : spec.bodies) body.mass *= u.mass, body.com *= u.length, body.inertia *= u(1, 2, 0);
  for (JointSpec& joint : spec.joints) {
    joint.frame.position *= u.length;
    joint.pitch *= u.length;
    const JointTraits& traits = joint.kind.traits();
    for (std::size_t k = 0; k < joint.coordinates.size(); ++k)
      scale(u, is_rotation(traits.columns[k]), joint.coordinates[k]);
    if (joint.motion) scale(u, is_rotation(traits.columns[0]) ? 1 : u.length, *joint.motion);
  }
  for (PointSpringSpec& s : spec.springs) {
    s.point_a *= u.length, s.point_b *= u.length, s.rest_length *= u.length;
    s.stiffness *= u(1, 0, -2), s.damping *= u(1, 0, -1);
  }
  for (WrenchSpec& w : spec.wrenches) w.moment *= u(1, 2, -2), w.force *= u(1, 1, -2);
  Case result{c.name, Model::build(spec), c.state, c.loads};
  result.state.t *= u.time;
  for (const Link& link : c.model.links()) {
    const JointTraits& traits = link.kind.traits();
    for (int k = 0; k < link.nq; ++k)
      if (traits.q_units[k] == "m") result.state.q[link.q + k] *= u.length;
    for (int k = 0; k < link.nv; ++k)
      result.state.v[link.v + k] *= (is_rotation(traits.columns[k]) ? 1 : u.length) / u.time;
  }
  for (int k = 0; k < c.model.nv(); ++k)
    if (!c.loads.tau.empty()) result.loads.tau[k] *= is_rotation(c.model.column_kind(k)) ? u(1, 2, -2) : u(1, 1, -2);
  for (auto& w : result.loads.wrenches) w.wrench = {w.wrench.moment * u(1, 2, -2), w.wrench.force * u(1, 1, -2)};
  return result;
}

TEST(Invariance, units_of_mass_length_and_time_scale_every_result_by_its_dimension) {
  const Units all_units[] = {{1024, 1, 1}, {1, 1000, 1}, {1, 1, 64}, {1e-3, 1e3, 1}, {0.3, 7, 11}};
  for (const Units& u : all_units)
    for (const Case& c : random_cases()) {
      const Case changed = scaled(u, c);
      const std::string law =
          "units " + std::to_string(u.mass) + " " + std::to_string(u.length) + " " + std::to_string(u.time);
      expect_law(law, c, changed, [&](Solution<double> s) {
        for (int k = 0; k < c.model.nv(); ++k)
          s.vdot[k] *= is_rotation(c.model.column_kind(k)) ? u(0, 0, -2) : u(0, 1, -2);
        for (auto& a : s.acceleration) a = {a.angular * u(0, 0, -2), a.linear * u(0, 1, -2)};
        for (auto& f : s.wrench) f = {f.moment * u(1, 2, -2), f.force * u(1, 1, -2)};
        for (int d = 0; d < c.model.drives(); ++d)
          s.drive_force[d] *= is_rotation(c.model.drive_kind(d)) ? u(1, 2, -2) : u(1, 1, -2);
        return s;
      });
    }
}

TEST(Invariance, without_dissipation_the_reversed_motion_has_the_same_accelerations_and_wrenches) {
  Features features;
  features.dissipation = features.prescribed = false;
  for (const Case& c : random_cases(features)) {
    Case changed = c;
    for (double& v : changed.state.v) v = -v;
    expect_law("time reversal", c, changed, [](const Solution<double>& s) { return s; });
  }
}

}  // namespace
}  // namespace lanc::test
