// Coefficients of eq. 14 against finite differences of the explicit position constraints, for every joint kind with
// arbitrary axes and every kind of prescribed motion.
#include "lib/system/evaluator.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "tests/support/explicit_kinematics.h"
#include "tests/support/naive.h"
#include "tests/support/tolerance.h"

namespace lanc::test {
namespace {

Real3 real3(const Vec3<Real>& a) { return {a.x, a.y, a.z}; }

/// Twists, accelerations and the momentum balance as the evaluator gives them, all for one η̇.
struct Evaluated {
  Evaluator<Real> evaluator;
  System<Real> system;
  std::vector<Motion<Real>> twist, acceleration;

  Evaluated(const Case& c, const std::vector<Real>& vdot)
      : evaluator(c.model), system(evaluator.system(cast<Real>(c.state), cast<Real>(c.loads))) {
    evaluator.positions();
    twist = evaluator.twists();
    for (int i = 0; i < c.model.bodies(); ++i) {
      const Link& link = c.model.link(i);
      Motion<Real> a = system.rhs.bias[i];
      if (link.parent != ground) {
        const Vec3<Real> r = system.bodies[i].r;
        const Motion<Real>& p = acceleration[link.parent];
        a += Motion<Real>{p.angular, p.linear + cross(p.angular, r)};
      }
      for (int k = link.v; k < link.v + link.nv; ++k) a += system.columns[k] * vdot[k];
      acceleration.push_back(a);
    }
  }
};

Curve curve_of(const Case& c, const std::vector<Real>& vdot) { return {cast<Real>(c.state), vdot, true}; }

void expect_near(const std::string& what, const Real3& a, const Real3& b, Real size) {
  EXPECT_TRUE(within_relative(what, static_cast<double>((a - b).cwiseAbs().maxCoeff()), difference_accuracy,
                              static_cast<double>(std::max(size, b.norm()))));
}

std::vector<Real> random_accelerations(const Case& c) {
  Random random(99);
  std::vector<Real> vdot;
  for (int k = 0; k < c.model.nv(); ++k) vdot.push_back(random.uniform(-2, 2));
  return vdot;
}

void check_poses_twists_accelerations(const Case& c) {
  const std::vector<Real> vdot = random_accelerations(c);
  Evaluated e(c, vdot);
  const auto positions = e.evaluator.positions();
  const auto expected = body_motions(c.model, curve_of(c, vdot));
  for (int i = 0; i < c.model.bodies(); ++i) {
    const std::string who = c.name + ", " + c.model.spec().joints[i].name + ": ";
    const BodyMotion& x = expected[i];
    const Mat3<Real> R = e.evaluator.body_rotation(i);
    expect_near(who + "position", real3(positions[i]), x.pose.r, 1);
    expect_near(who + "x axis", real3(R.x), x.pose.R.col(0), 1);
    expect_near(who + "y axis", real3(R.y), x.pose.R.col(1), 1);
    expect_near(who + "z axis", real3(R.z), x.pose.R.col(2), 1);
    expect_near(who + "angular velocity", real3(e.twist[i].angular), x.omega, 1);
    expect_near(who + "velocity", real3(e.twist[i].linear), x.velocity, 1);
    expect_near(who + "angular acceleration", real3(e.acceleration[i].angular), x.omega_dot, 1 + x.omega.squaredNorm());
    expect_near(who + "acceleration", real3(e.acceleration[i].linear), x.acceleration, 1 + x.omega.squaredNorm());
  }
}

/// Column k of C is what body (and all it carries) gets from velocity k alone: state with v = e_k and the clock
/// stopped.
void check_columns(const Case& c) {
  Evaluated e(c, std::vector<Real>(c.model.nv(), 0));
  for (int k = 0; k < c.model.nv(); ++k) {
    Curve curve{cast<Real>(c.state), std::vector<Real>(c.model.nv(), 0), false};
    std::fill(curve.state.v.begin(), curve.state.v.end(), Real(0));
    curve.state.v[k] = 1;
    const int body = c.model.body_of_velocity(k);
    const BodyMotion x = body_motions(c.model, curve)[body];
    const std::string who = c.name + ", column " + c.model.velocity_names()[k];
    expect_near(who + ", angular", real3(e.system.columns[k].angular), x.omega, 1);
    expect_near(who + ", linear", real3(e.system.columns[k].linear), x.velocity, 1);
  }
}

/// Force and moment about the reference point that the surroundings put on body i, from the specification.
void add_applied(const Case& c, const std::vector<BodyMotion>& x, std::vector<Real3>& force,
                 std::vector<Real3>& moment) {
  const ModelSpec& spec = c.model.spec();
  for (int i = 0; i < c.model.bodies(); ++i) {
    const Real3 weight = Real(spec.bodies[i].mass) * spec.gravity.cast<Real>();
    force[i] += weight;
    moment[i] += Real3(x[i].pose.R * spec.bodies[i].com.cast<Real>()).cross(weight);
  }
  for (const WrenchSpec& w : spec.wrenches) {
    const int i = *c.model.find_body(w.body);
    force[i] += w.force.cast<Real>(), moment[i] += w.moment.cast<Real>();
  }
  for (const auto& w : c.loads.wrenches) {
    force[w.body] += real3(cast<Real>(w.wrench.force)), moment[w.body] += real3(cast<Real>(w.wrench.moment));
  }
  for (const PointSpringSpec& s : spec.springs) {
    const auto end = [&](const std::string& name, const Eigen::Vector3d& point) {
      if (name.empty()) return std::array<Real3, 3>{Real3::Zero(), point.cast<Real>(), Real3::Zero()};
      const BodyMotion& b = x[*c.model.find_body(name)];
      const Real3 arm = b.pose.R * point.cast<Real>();
      return std::array<Real3, 3>{arm, b.pose.r + arm, b.velocity + b.omega.cross(arm)};
    };
    const auto a = end(s.body_a, s.point_a), b = end(s.body_b, s.point_b);
    const Real3 d = b[1] - a[1];
    const Real3 u = d.normalized();
    const Real pull = s.stiffness * (d.norm() - s.rest_length) + s.damping * u.dot(b[2] - a[2]);
    const auto act = [&](const std::string& name, const Real3& arm, const Real3& f) {
      if (name.empty()) return;
      const int i = *c.model.find_body(name);
      force[i] += f, moment[i] += arm.cross(f);
    };
    act(s.body_a, a[0], u * pull);
    act(s.body_b, b[0], -u * pull);
  }
}

/// M â − f̂^tc of (3) must be rate of momentum minus applied force, both from Newton and Euler about the mass centre.
void check_momentum_balance(const Case& c) {
  const std::vector<Real> vdot = random_accelerations(c);
  Evaluated e(c, vdot);
  const auto x = body_motions(c.model, curve_of(c, vdot));
  const int n = c.model.bodies();
  std::vector<Real3> force(n, Real3::Zero()), moment(n, Real3::Zero());
  add_applied(c, x, force, moment);
  for (int i = 0; i < n; ++i) {
    const BodySpec& body = c.model.spec().bodies[i];
    const Real3 arm = x[i].pose.R * body.com.cast<Real>();
    const Real33 I = x[i].pose.R * body.inertia.cast<Real>() * x[i].pose.R.transpose();
    const Real3& w = x[i].omega;
    const Real3 a_com = x[i].acceleration + x[i].omega_dot.cross(arm) + w.cross(w.cross(arm));
    const Real3 rate = Real(body.mass) * a_com;
    const Real3 spin = I * x[i].omega_dot + w.cross(I * w) + arm.cross(rate);
    const Wrench<Real> left = e.system.bodies[i].inertia * e.acceleration[i] - e.system.rhs.force[i];
    const Real size = 1 + rate.norm() + spin.norm();
    expect_near(c.name + ", " + body.name + ": force", real3(left.force), rate - force[i], size);
    expect_near(c.name + ", " + body.name + ": moment", real3(left.moment), spin - moment[i], size);
  }
}

void check_all(const Case& c) {
  SCOPED_TRACE(c.name);
  check_poses_twists_accelerations(c);
  check_columns(c);
  check_momentum_balance(c);
}

TEST(Evaluator, every_joint_kind_about_arbitrary_axes_is_the_derivative_of_its_explicit_constraint) {
  for (unsigned char kind = 0; kind < joint_kinds; ++kind) {
    Features features;
    features.only_joint = JointKind{kind}.traits().name;
    features.prescribed = features.singular_inertias = false;
    for (int seed = 0; seed < 5; ++seed) check_all(random_case(7100 + seed, 1 + seed, features));
  }
}

TEST(Evaluator, rheonomic_joints_carry_velocity_and_acceleration_of_every_kind_of_motion) {
  for (const char* joint : {"revolute", "prismatic", "helical"})
    for (int motion = 0; motion < 5; ++motion)
      for (int seed = 0; seed < 3; ++seed) {
        Features features;
        features.prescribed = features.singular_inertias = false;
        ModelSpec spec = random_spec(8200 + seed, 4, features);
        Random random(100 * seed + motion);
        for (const int i : {0, 2}) {  // on the ground, and on a body that moves itself
          const JointSpec old = spec.joints[i];
          spec.joints[i] = random_joint(random, *find_joint_kind(joint), old.name);
          spec.joints[i].parent = old.parent, spec.joints[i].body = old.body;
          spec.joints[i].motion = random_motion(random, motion);
        }
        Case c{std::string(joint) + " motion " + std::to_string(motion), Model::build(spec), {}, {}};
        c.state = random_state(random, c.model);
        check_all(c);
      }
}

TEST(Evaluator, random_trees_of_everything_are_derivatives_of_their_explicit_constraints) {
  for (int seed = 0; seed < 40; ++seed) check_all(random_case(9300 + seed, 1 + seed % 10));
}

TEST(Evaluator, double_and_count_give_the_coefficients_of_long_double) {
  for (int seed = 0; seed < 20; ++seed) {
    const Case c = random_case(9400 + seed, 12);
    const System<Real> wide = system_in_long_double(c);
    Evaluator<double> evaluator(c.model);
    Evaluator<Count> counting(c.model);
    const System<double>& system = evaluator.system(c.state, c.loads);
    const System<Count>& counted = counting.system(cast<Count>(c.state), cast<Count>(c.loads));
    double size = 1;
    const auto check = [&](const char* what, double x, Real y, Count z) {
      EXPECT_TRUE(within(std::string(what) + " of " + c.name, static_cast<double>(x - y), 12, size));
      EXPECT_TRUE(within(std::string(what) + " counted, of " + c.name, x - z.value(), 12, size));
    };
    for (const auto& f : wide.rhs.force)
      size = std::max(size, static_cast<double>(dot(f.moment, f.moment) + dot(f.force, f.force)));
    for (int i = 0; i < c.model.bodies(); ++i) {
      check("r.x", system.bodies[i].r.x, wide.bodies[i].r.x, counted.bodies[i].r.x);
      check("J.xy", system.bodies[i].inertia.J.xy, wide.bodies[i].inertia.J.xy, counted.bodies[i].inertia.J.xy);
      check("bias", system.rhs.bias[i].linear.z, wide.rhs.bias[i].linear.z, counted.rhs.bias[i].linear.z);
      check("force", system.rhs.force[i].moment.y, wide.rhs.force[i].moment.y, counted.rhs.force[i].moment.y);
    }
  }
}

/// τ of a joint alone, by the words of CoordinateSpec.
double passive(const CoordinateSpec& spec, double q, double v) {
  ModelSpec model;
  Random random(1);
  BodySpec body = random_body(random, "body");
  JointSpec joint;
  joint.name = "joint", joint.body = "body";
  joint.kind = *find_joint_kind("revolute");
  joint.coordinates = {spec};
  model.bodies = {body}, model.joints = {joint};
  Evaluator<double> evaluator(Model::build(model));
  return evaluator.system({0, {q}, {v}}).rhs.tau[0];
}

TEST(Evaluator, joint_springs_dampers_and_torques_enter_tau_with_their_signs) {
  EXPECT_DOUBLE_EQ(passive({.stiffness = 3, .rest = 0.5}, 2, 0), -3 * 1.5);
  EXPECT_DOUBLE_EQ(passive({.damping = 3}, 2, 0.5), -1.5);
  EXPECT_DOUBLE_EQ(passive({.torque = 0.7}, 2, 0.5), 0.7);
}

TEST(Evaluator, friction_opposes_motion_with_its_magnitude_for_either_direction_and_is_smooth_at_rest) {
  const CoordinateSpec spec{.friction_positive = 0.4, .friction_negative = 0.1, .friction_speed = 1e-3};
  EXPECT_NEAR(passive(spec, 0, 10), -0.4, 1e-7);
  EXPECT_NEAR(passive(spec, 0, -10), 0.1, 1e-7);
  EXPECT_EQ(passive(spec, 0, 0), 0);
  for (double v = -5e-3; v < 5e-3; v += 1e-4) EXPECT_LE(passive(spec, 0, v) * v, 0) << "friction drives at v = " << v;
}

TEST(Evaluator, a_motion_outside_its_table_gives_coefficients_that_are_not_finite) {
  ModelSpec spec = random_spec(1, 1, {.singular_inertias = false, .only_joint = "revolute"});
  spec.joints[0].coordinates.clear();
  spec.joints[0].motion = SplineTable{{0, 1, 2, 3}, {0, 1, 0, 1}};
  const Model model = Model::build(spec);
  Evaluator<double> evaluator(model);
  EXPECT_TRUE(std::isfinite(evaluator.system({1, {}, {}}).rhs.bias[0].angular.x));
  EXPECT_FALSE(std::isfinite(evaluator.system({4, {}, {}}).rhs.bias[0].angular.x));
}

}  // namespace
}  // namespace lanc::test
