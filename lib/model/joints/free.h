#pragma once
#include "lib/model/joints/joint.h"

namespace lanc::joints {

/// No constraint: q = (position in predecessor axes, Euler parameters w, x, y, z), v = (angular, linear) velocity of
/// the successor relative to the predecessor, in successor axes.
struct Free {
  static constexpr JointTraits traits{
      .name = "free",
      .nq = 7,
      .nv = 6,
      .moves_origin = true,
      .quaternion = 3,
      .columns = {ColumnKind::rotation, ColumnKind::rotation, ColumnKind::rotation, ColumnKind::translation,
                  ColumnKind::translation, ColumnKind::translation},
      .q_names = {"x", "y", "z", "qw", "qx", "qy", "qz"},
      .q_units = {"m", "m", "m", "1", "1", "1", "1"},
      .v_names = {"wx", "wy", "wz", "vx", "vy", "vz"},
      .v_units = {"rad/s", "rad/s", "rad/s", "m/s", "m/s", "m/s"}};
  static constexpr bool has_column_rate = true;

  template <class S, class W>
  static void move(const S* q, const SinCos<S>*, const S* v, JointStep<W>& step, Motion<W>* C) {
    step.R = turned_by_quaternion(step.F, q + 3);
    step.displacement = step.F * Vec3<S>{q[0], q[1], q[2]};
    C[0].angular = C[3].linear = step.R.x;
    C[1].angular = C[4].linear = step.R.y;
    C[2].angular = C[5].linear = step.R.z;
    step.angular = step.R * Vec3<S>{v[0], v[1], v[2]};
    step.linear = step.R * Vec3<S>{v[3], v[4], v[5]};
    step.linear_rate = cross(step.angular, step.linear);  // the translation columns turn with the successor
  }

  template <class S>
  static void rate(const S* q, const S* v, S* qdot) {
    const Mat3<S> R = turned_by_quaternion(identity3<S>(), q + 3);
    const Vec3<S> u = R * Vec3<S>{v[3], v[4], v[5]};
    qdot[0] = u.x, qdot[1] = u.y, qdot[2] = u.z;
    quaternion_rate(q + 3, v, qdot + 3);
  }
};

}  // namespace lanc::joints
