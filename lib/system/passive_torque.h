// Springs, dampers, Coulomb friction and constant torques in joints.
#pragma once

#include "lib/model/spec.h"
#include "lib/scalar/scalar.h"

namespace lanc {

/// What they do together on one velocity coordinate, at position q (where the coordinate has a spring) and velocity v.
template <class S>
S passive_torque(const CoordinateSpec& c, const S& q, const S& v) {
  S torque(c.torque);
  if (c.stiffness != 0) torque -= S(c.stiffness) * (q - S(c.rest));
  if (c.damping != 0) torque -= S(c.damping) * v;
  if (c.friction_positive != 0 || c.friction_negative != 0) {
    // s → ±1 for |v| ≫ friction_speed; the even part carries the difference between the two directions
    const S speed(c.friction_speed);
    const S s = v / sqrt(v * v + speed * speed);
    torque -= s * (S((c.friction_positive + c.friction_negative) / 2) +
                   s * S((c.friction_positive - c.friction_negative) / 2));
  }
  return torque;
}

}  // namespace lanc
