#pragma once
#include "lib/model/joints/joint.h"

namespace lanc::joints {

/// Ball joint: q = Euler parameters (w, x, y, z) that take successor axes to predecessor axes (eq. 2: qᵀq = 1),
/// v = relative angular velocity in successor axes.
struct Spherical {
  static constexpr JointTraits traits{.name = "spherical",
                                      .nq = 4,
                                      .nv = 3,
                                      .quaternion = 0,
                                      .columns = {ColumnKind::rotation, ColumnKind::rotation, ColumnKind::rotation},
                                      .q_names = {"qw", "qx", "qy", "qz"},
                                      .q_units = {"1", "1", "1", "1"},
                                      .v_names = {"wx", "wy", "wz"},
                                      .v_units = {"rad/s", "rad/s", "rad/s"},
                                      .closure = {3, {conditions::x, conditions::y, conditions::z}}};
  static constexpr bool has_column_rate = false;  // Ċ η = ω_rel × ω_rel = 0

  template <class S, class W>
  static void move(const S* q, const SinCos<S>*, const S* v, JointStep<W>& step, Motion<W>* C) {
    step.R = turned_by_quaternion(step.F, q);
    C[0].angular = step.R.x;
    C[1].angular = step.R.y;
    C[2].angular = step.R.z;
    step.angular = step.R * Vec3<S>{v[0], v[1], v[2]};
  }

  template <class S>
  static void rate(const S* q, const S* v, S* qdot) {
    quaternion_rate(q, v, qdot);
  }
};

}  // namespace lanc::joints
