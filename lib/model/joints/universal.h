#pragma once
#include "lib/model/joints/joint.h"

namespace lanc::joints {

/// Cardan joint: first angle about the predecessor's axis z, second about the successor's axis x (perpendicular to it).
struct Universal {
  static constexpr JointTraits traits{
      .name = "universal",
      .nq = 2,
      .nv = 2,
      .axes = JointAxes::two,
      .columns = {ColumnKind::rotation, ColumnKind::rotation},
      .q_names = {"first_angle", "second_angle"},
      .q_units = {"rad", "rad"},
      .v_names = {"first_angle_rate", "second_angle_rate"},
      .v_units = {"rad/s", "rad/s"},
      .closure = {4,
                  {conditions::x, conditions::y, conditions::z, Condition{ConditionKind::perpendicular, 2, 0, "ry"}}}};
  static constexpr bool has_column_rate = true;

  template <class S, class W>
  static void move(const S*, const SinCos<S>* turn, const S* v, JointStep<W>& step, Motion<W>* C) {
    const Mat3<W> cross_piece = turned_about_z(step.F, turn[0]);
    const auto& [s, c] = turn[1];
    const Vec3<W>&x = cross_piece.x, &y = cross_piece.y, &z = cross_piece.z;
    step.R = {x, y * c + z * s, z * c - y * s};
    C[0].angular = z;
    C[1].angular = x;
    const Vec3<W> first = z * v[0], second = x * v[1];
    step.angular = first + second;
    step.angular_rate = cross(first, second);  // the second axis turns with the cross piece
  }
};

}  // namespace lanc::joints
