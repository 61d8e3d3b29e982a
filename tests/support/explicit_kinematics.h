// The explicit position constraints (5), (6) written down naively: the witness of the joints' kinematics.
//
// Poses of all bodies as a function of time, straight from the specification, in the user's axes, with rotation
// matrices by Rodrigues' formula in long double. Velocities and accelerations come from it by finite differences alone,
// so nothing here knows a motion subspace, a velocity product or a canonical joint axis.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "lib/model/model.h"

namespace lanc::test {

using Real = long double;
using Real3 = Eigen::Matrix<Real, 3, 1>;
using Real33 = Eigen::Matrix<Real, 3, 3>;

/// Body axes of the user (columns) and the reference point, in the world.
struct Pose {
  Real33 R;
  Real3 r;
};

/// A curve of states through `state` with velocities state.v and accelerations vdot at s = 0, in which the clock shows
/// t + s, or stands still.
struct Curve {
  State<Real> state;
  std::vector<Real> vdot;
  bool clock_runs = true;
};

/// Coordinates, velocities (to first order) and time on the curve at s.
State<Real> state_on(const Model& model, const Curve& curve, Real s);

/// (5), (6) at s, body by body.
std::vector<Pose> poses(const Model& model, const Curve& curve, Real s);

/// ω, v, ω̇, v̇ of a body at s = 0: eighth-order central differences of its pose.
struct BodyMotion {
  Pose pose;
  Real3 omega, velocity, omega_dot, acceleration;
};
std::vector<BodyMotion> body_motions(const Model& model, const Curve& curve);

/// First derivative at 0 of a scalar function, eighth order. The step is smaller than that of the poses, so that
/// accelerations of thousands do no harm: nothing is divided by its square.
template <class Function>
Real derivative(Function f) {
  const Real h = Real(1) / 1024;
  return (Real(4) / 5 * (f(h) - f(-h)) - Real(1) / 5 * (f(2 * h) - f(-2 * h)) + Real(4) / 105 * (f(3 * h) - f(-3 * h)) -
          Real(1) / 280 * (f(4 * h) - f(-4 * h))) /
         h;
}

/// What those differences can tell: h⁸ of smooth motions, ε / h² of motions known in double precision only.
constexpr double difference_accuracy = 1e-9;

}  // namespace lanc::test
