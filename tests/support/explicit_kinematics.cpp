#include "tests/support/explicit_kinematics.h"

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <stdexcept>

namespace lanc::test {
namespace {

Real33 turn(const Real3& axis, Real angle) {
  const Real3 a = axis.normalized();
  Real33 K;
  K << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return Real33::Identity() + std::sin(angle) * K + (1 - std::cos(angle)) * K * K;
}

/// exp([φ]×).
Real33 turn(const Real3& phi) {
  const Real angle = phi.norm();
  return angle == 0 ? Real33(Real33::Identity()) : turn(phi, angle);
}

Real33 from_euler_parameters(const Real* e) {
  return Eigen::Quaternion<Real>(e[0], e[1], e[2], e[3]).normalized().toRotationMatrix();
}

Real3 first_axis(const JointSpec& joint) {
  return joint.axis ? Real3(joint.axis->cast<Real>().normalized()) : Real3(0, 0, 1);
}

/// As the specification says: `axis2`, or the coordinate axis least along the first one, made perpendicular.
Real3 second_axis(const JointSpec& joint) {
  if (joint.axis2) return joint.axis2->cast<Real>().normalized();
  const Real3 a = first_axis(joint);
  int least = 0;
  for (int k = 1; k < 3; ++k)
    if (std::abs(a[k]) < std::abs(a[least])) least = k;
  const Real3 e = Real3::Unit(least);
  return (e - a * a.dot(e)).normalized();
}

/// Coordinate k of a joint whose velocities are rates, at s.
struct Rates {
  const Real *q, *v, *vdot;
  Real s;
  Real operator()(int k) const { return q[k] + v[k] * s + vdot[k] * s * s / 2; }
};

/// Relative rotation along a curve with angular velocity w and its rate in successor axes at s = 0.
Real33 turning(const Real* e, const Real* w, const Real* w_dot, Real s) {
  const Real3 phi = Real3(w[0], w[1], w[2]) * s + Real3(w_dot[0], w_dot[1], w_dot[2]) * (s * s / 2);
  return from_euler_parameters(e) * turn(phi);
}

/// Pose of the successor in the joint's frame.
Pose relative_pose(const JointSpec& joint, const Rates& x) {
  const std::string_view name = joint.kind.traits().name;
  const Real3 a = first_axis(joint), zero = Real3::Zero();
  const Real33 one = Real33::Identity();
  const Real pitch = joint.pitch;
  if (name == "fixed") return {one, zero};
  if (name == "revolute") return {turn(a, x(0)), zero};
  if (name == "prismatic") return {one, a * x(0)};
  if (name == "helical") return {turn(a, x(0)), a * (pitch * x(0))};
  if (name == "cylindrical") return {turn(a, x(0)), a * x(1)};
  if (name == "universal") return {turn(a, x(0)) * turn(second_axis(joint), x(1)), zero};
  if (name == "planar") {
    const Real3 b = second_axis(joint);
    return {turn(a, x(2)), b * x(0) + a.cross(b) * x(1)};
  }
  if (name == "spherical") return {turning(x.q, x.v, x.vdot, x.s), zero};
  if (name == "free") {
    const Real33 R = from_euler_parameters(x.q + 3);
    const Real3 w(x.v[0], x.v[1], x.v[2]), u(x.v[3], x.v[4], x.v[5]), u_dot(x.vdot[3], x.vdot[4], x.vdot[5]);
    const Real3 p = Real3(x.q[0], x.q[1], x.q[2]) + R * u * x.s + R * (w.cross(u) + u_dot) * (x.s * x.s / 2);
    return {turning(x.q + 3, x.v, x.vdot, x.s), p};
  }
  throw std::runtime_error("the explicit kinematics of the tests do not know the joint kind '" + std::string(name) +
                           "'");
}

}  // namespace

std::vector<Pose> poses(const Model& model, const Curve& curve, Real s) {
  std::vector<Pose> result;
  for (int i = 0; i < model.bodies(); ++i) {
    const Link& link = model.link(i);
    const JointSpec& joint = model.spec().joints[i];
    const Pose carrier = link.parent == ground ? Pose{Real33::Identity(), Real3::Zero()} : result[link.parent];
    const Real33 R = carrier.R * joint.frame.rotation.cast<Real>();
    const Real3 r = carrier.r + carrier.R * joint.frame.position.cast<Real>();
    Pose step;
    if (link.drive >= 0) {
      const double t = curve.state.t + (curve.clock_runs ? static_cast<double>(s) : 0.0);  // both dyadic: exact
      const Real q = model.motion(link.drive).at(t).position, nothing = 0;
      step = relative_pose(joint, {&q, &nothing, &nothing, 0});
    } else {
      step = relative_pose(
          joint, {curve.state.q.data() + link.q, curve.state.v.data() + link.v, curve.vdot.data() + link.v, s});
    }
    result.push_back({R * step.R, r + R * step.r});
  }
  return result;
}

State<Real> state_on(const Model& model, const Curve& curve, Real s) {
  State<Real> result = curve.state;
  if (curve.clock_runs) result.t += static_cast<double>(s);
  for (int k = 0; k < model.nv(); ++k) result.v[k] += curve.vdot[k] * s;
  for (int i = 0; i < model.bodies(); ++i) {
    const Link& link = model.link(i);
    const Real *q = curve.state.q.data() + link.q, *v = curve.state.v.data() + link.v,
               *vdot = curve.vdot.data() + link.v;
    Real* out = result.q.data() + link.q;
    if (const int w = link.kind.traits().quaternion; w < 0) {
      for (int k = 0; k < link.nq; ++k) out[k] = Rates{q, v, vdot, s}(k);
    } else {
      const Eigen::Quaternion<Real> e(turning(q + w, v, vdot, s));
      out[w] = e.w(), out[w + 1] = e.x(), out[w + 2] = e.y(), out[w + 3] = e.z();
      if (w == 3) {  // free
        const Real3 p = relative_pose(model.spec().joints[i], {q, v, vdot, s}).r;
        for (int k = 0; k < 3; ++k) out[k] = p[k];
      }
    }
  }
  return result;
}

std::vector<BodyMotion> body_motions(const Model& model, const Curve& curve) {
  constexpr int reach = 4;
  const Real h = Real(1) / 64;
  const std::array<Real, reach + 1> first = {0, Real(4) / 5, -Real(1) / 5, Real(4) / 105, -Real(1) / 280};
  const std::array<Real, reach + 1> second = {-Real(205) / 72, Real(8) / 5, -Real(1) / 5, Real(8) / 315,
                                              -Real(1) / 560};
  std::array<std::vector<Pose>, 2 * reach + 1> samples;
  for (int k = -reach; k <= reach; ++k) samples[k + reach] = poses(model, curve, k * h);
  std::vector<BodyMotion> result;
  for (int i = 0; i < model.bodies(); ++i) {
    Real33 dR = Real33::Zero(), ddR = second[0] * samples[reach][i].R;
    Real3 dr = Real3::Zero(), ddr = second[0] * samples[reach][i].r;
    for (int k = 1; k <= reach; ++k) {
      const Pose &ahead = samples[reach + k][i], &behind = samples[reach - k][i];
      dR += first[k] * (ahead.R - behind.R), dr += first[k] * (ahead.r - behind.r);
      ddR += second[k] * (ahead.R + behind.R), ddr += second[k] * (ahead.r + behind.r);
    }
    dR /= h, dr /= h, ddR /= h * h, ddr /= h * h;
    const Pose& pose = samples[reach][i];
    const Real33 W = dR * pose.R.transpose();                             // [ω]×
    const Real33 W_dot = ddR * pose.R.transpose() + dR * dR.transpose();  // d/dt of it
    const auto vee = [](const Real33& m) {
      return Real3((m(2, 1) - m(1, 2)) / 2, (m(0, 2) - m(2, 0)) / 2, (m(1, 0) - m(0, 1)) / 2);
    };
    result.push_back({pose, vee(W), dr, vee(W_dot), ddr});
  }
  return result;
}

}  // namespace lanc::test
