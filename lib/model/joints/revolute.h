#pragma once
#include "lib/model/joints/joint.h"

namespace lanc::joints {

/// Hinge: q = angle (rad), v = its rate; C = [z; 0].
struct Revolute {
  static constexpr JointTraits traits{
      .name = "revolute",
      .nq = 1,
      .nv = 1,
      .axes = JointAxes::one,
      .columns = {ColumnKind::rotation},
      .q_names = {"angle"},
      .q_units = {"rad"},
      .v_names = {"angle_rate"},
      .v_units = {"rad/s"},
      .closure = {5, {conditions::x, conditions::y, conditions::z, conditions::tilt_x, conditions::tilt_y}, "z"}};
  static constexpr bool has_column_rate = false;

  template <class S, class W>
  static void move(const S*, const SinCos<S>* turn, const S* v, JointStep<W>& step, Motion<W>* C) {
    step.R = turned_about_z(step.F, turn[0]);
    C[0].angular = step.R.z;
    step.angular = step.R.z * v[0];
  }
};

}  // namespace lanc::joints
