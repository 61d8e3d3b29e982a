#pragma once
#include "lib/model/joints/joint.h"

namespace lanc::joints {

/// Slides in the x–y plane of the predecessor and turns about its normal z: q = (x, y, angle), v = their rates.
struct Planar {
  static constexpr JointTraits traits{
      .name = "planar",
      .nq = 3,
      .nv = 3,
      .axes = JointAxes::two,
      .moves_origin = true,
      .columns = {ColumnKind::translation, ColumnKind::translation, ColumnKind::rotation},
      .q_names = {"x", "y", "angle"},
      .q_units = {"m", "m", "rad"},
      .v_names = {"x_rate", "y_rate", "angle_rate"},
      .v_units = {"m/s", "m/s", "rad/s"},
      .closure = {3, {conditions::z, conditions::tilt_x, conditions::tilt_y}, "z"}};
  static constexpr bool has_column_rate = false;

  template <class S, class W>
  static void move(const S* q, const SinCos<S>* turn, const S* v, JointStep<W>& step, Motion<W>* C) {
    step.R = turned_about_z(step.F, turn[0]);
    step.displacement = step.F.x * q[0] + step.F.y * q[1];
    C[0].linear = step.F.x;
    C[1].linear = step.F.y;
    C[2].angular = step.F.z;
    step.linear = step.F.x * v[0] + step.F.y * v[1];
    step.angular = step.F.z * v[2];
  }
};

}  // namespace lanc::joints
