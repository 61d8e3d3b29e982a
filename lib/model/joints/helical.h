#pragma once
#include "lib/model/joints/joint.h"

namespace lanc::joints {

/// Screw: q = angle (rad, turns are counted, not wrapped), v = its rate; travel = pitch × angle, C = [z; pitch z].
struct Helical {
  static constexpr JointTraits traits{.name = "helical",
                                      .nq = 1,
                                      .nv = 1,
                                      .axes = JointAxes::one,
                                      .has_pitch = true,
                                      .moves_origin = true,
                                      .columns = {ColumnKind::screw},
                                      .q_names = {"angle"},
                                      .q_units = {"rad"},
                                      .v_names = {"angle_rate"},
                                      .v_units = {"rad/s"},
                                      .closure = {5,
                                                  {conditions::x, conditions::y, conditions::tilt_x, conditions::tilt_y,
                                                   Condition{ConditionKind::screw, 0, 0, "screw"}},
                                                  "z"}};
  static constexpr bool has_column_rate = false;

  template <class S, class W>
  static void move(const S* q, const SinCos<S>* turn, const S* v, JointStep<W>& step, Motion<W>* C) {
    step.R = turned_about_z(step.F, turn[0]);
    const Vec3<W> along = step.F.z * S(step.pitch);
    step.displacement = along * q[0];
    C[0] = {step.F.z, along};
    step.angular = step.F.z * v[0];
    step.linear = along * v[0];
  }
};

}  // namespace lanc::joints
