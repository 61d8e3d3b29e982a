#pragma once
#include "lib/model/joints/joint.h"

namespace lanc::joints {

/// Slider: q = travel (m), v = its rate; C = [0; z].
struct Prismatic {
  static constexpr JointTraits traits{
      .name = "prismatic",
      .nq = 1,
      .nv = 1,
      .axes = JointAxes::one,
      .moves_origin = true,
      .columns = {ColumnKind::translation},
      .q_names = {"travel"},
      .q_units = {"m"},
      .v_names = {"travel_rate"},
      .v_units = {"m/s"},
      .closure = {
          5, {conditions::x, conditions::y, conditions::turn_x, conditions::turn_y, conditions::turn_z}, "xyz"}};
  static constexpr bool has_column_rate = false;

  template <class S, class W>
  static void move(const S* q, const SinCos<S>*, const S* v, JointStep<W>& step, Motion<W>* C) {
    step.R = step.F;
    step.displacement = step.F.z * q[0];
    C[0].linear = step.F.z;
    step.linear = step.F.z * v[0];
  }
};

}  // namespace lanc::joints
