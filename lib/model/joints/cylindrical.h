#pragma once
#include "lib/model/joints/joint.h"

namespace lanc::joints {

/// Turns about and slides along one axis: q = (angle, travel), v = their rates.
struct Cylindrical {
  static constexpr JointTraits traits{
      .name = "cylindrical",
      .nq = 2,
      .nv = 2,
      .axes = JointAxes::one,
      .moves_origin = true,
      .columns = {ColumnKind::rotation, ColumnKind::translation},
      .q_names = {"angle", "travel"},
      .q_units = {"rad", "m"},
      .v_names = {"angle_rate", "travel_rate"},
      .v_units = {"rad/s", "m/s"},
      .closure = {4, {conditions::x, conditions::y, conditions::tilt_x, conditions::tilt_y}, "z"}};
  static constexpr bool has_column_rate = false;

  template <class S, class W>
  static void move(const S* q, const SinCos<S>* turn, const S* v, JointStep<W>& step, Motion<W>* C) {
    step.R = turned_about_z(step.F, turn[0]);
    step.displacement = step.F.z * q[1];
    C[0].angular = step.F.z;
    C[1].linear = step.F.z;
    step.angular = step.F.z * v[0];
    step.linear = step.F.z * v[1];
  }
};

}  // namespace lanc::joints
