// What a joint kind is: one file each beside this one, listed once in list.h.
//
// A joint kind is a struct with
//   static constexpr JointTraits traits            its facts: name, sizes, columns, coordinates, which axes it takes
//   template <class S, class W> static void move(...)
//                                                  pose, relative twist and columns of C_i, from q, sines and cosines
//                                                  of its angles, and v (the only place a kind shows). W is S, or Wide:
//                                                  vectors of three S in one register (lib/spatial/wide.h)
// and, when its velocities are not the rates of its coordinates, rate() (eq. 1) and normalise() (eq. 2).
//
// Frames: everything is written in the *joint axes*: a frame K_F fixed on the predecessor and a frame fixed on the
// successor that coincide when all coordinates are zero, z along the joint's (first) axis, x along its second one.
// The model brings every joint into these axes once (lib/model/model.cpp), so no kind carries an arbitrary axis.
#pragma once

#include <array>
#include <string_view>

#include "lib/model/closures/condition.h"
#include "lib/scalar/sines.h"
#include "lib/spatial/spatial.h"

namespace lanc {

/// Which axes a joint kind takes from the user.
enum class JointAxes : unsigned char { none, one, two };

struct JointTraits {
  std::string_view name;
  int nq = 0, nv = 0;
  JointAxes axes = JointAxes::none;
  bool has_pitch = false;
  bool moves_origin = false;  // can displace the successor's origin against the predecessor
  int quaternion = -1;        // index of w among the position coordinates (eq. 2), or −1
  std::array<ColumnKind, 6> columns{};
  std::array<std::string_view, 7> q_names{}, q_units{};
  std::array<std::string_view, 6> v_names{}, v_units{};
  Conditions closure{};  // what it takes away, for joints that close a loop (frames A and B: those of the joint)

  /// Velocities are the rates of the coordinates: β̇ = η, so that springs, rest positions and motions make sense.
  bool rates_are_velocities() const { return quaternion < 0; }
};

/// The angles among the position coordinates are those in rad. Sines and cosines are handed to move() in their order,
/// so that those of a whole mechanism can be taken at once.
constexpr bool is_angle(const JointTraits& traits, int coordinate) { return traits.q_units[coordinate] == "rad"; }
constexpr int angle_count(const JointTraits& traits) {
  int count = 0;
  for (int k = 0; k < traits.nq; ++k) count += is_angle(traits, k);
  return count;
}

template <class Joint, class S>
using Turns = std::array<SinCos<S>, angle_count(Joint::traits)>;

/// Sines and cosines of one joint's angles.
template <class Joint, class S>
Turns<Joint, S> turns_of(const S* q) {
  Turns<Joint, S> turns;
  for (int k = 0, a = 0; k < Joint::traits.nq; ++k)
    if (is_angle(Joint::traits, k)) turns[a++] = sine_and_cosine(q[k]);
  return turns;
}

/// What a joint does at one instant, in world axes. `F` holds the axes of K_F; the kind fills the rest.
template <class W>
struct JointStep {
  Mat3<W> F;                // in: axes of the predecessor's joint frame
  double pitch = 0;         // in: m/rad, helical joints
  Mat3<W> R;                // out: axes of the successor
  Vec3<W> displacement;     // out: from K_F's to the successor's origin   (only if traits.moves_origin)
  Vec3<W> angular, linear;  // out: relative twist C η                     (linear only if traits.moves_origin)
  Vec3<W> angular_rate, linear_rate;  // out: Ċ η seen from the predecessor    (only if the kind has_column_rate)
};

/// Rotation of the frame F about its z axis.
template <class S, class W>
[[gnu::always_inline]] inline Mat3<W> turned_about_z(const Mat3<W>& F, const SinCos<S>& angle) {
  const auto& [s, c] = angle;
  return {F.x * c + F.y * s, F.y * c - F.x * s, F.z};
}

/// Rotation of the frame F by unit Euler parameters (w, x, y, z) that take successor axes to predecessor axes.
template <class S, class W>
inline Mat3<W> turned_by_quaternion(const Mat3<W>& F, const S* e) {
  const S x2 = e[1] + e[1], y2 = e[2] + e[2], z2 = e[3] + e[3];
  const S xx = x2 * e[1], yy = y2 * e[2], zz = z2 * e[3], xy = x2 * e[2], xz = x2 * e[3], yz = y2 * e[3];
  const S wx = x2 * e[0], wy = y2 * e[0], wz = z2 * e[0], one(1.0);
  const Mat3<S> R = {
      {one - (yy + zz), xy + wz, xz - wy}, {xy - wz, one - (xx + zz), yz + wx}, {xz + wy, yz - wx, one - (xx + yy)}};
  return F * R;
}

/// eq. 1 for Euler parameters: ė = ½ e ∘ (0, ω), ω in successor axes; the 4×3 half-quaternion matrix times ω.
template <class S>
inline void quaternion_rate(const S* e, const S* w, S* rate) {
  const S half(0.5);
  rate[0] = -(e[1] * w[0] + e[2] * w[1] + e[3] * w[2]) * half;
  rate[1] = (e[0] * w[0] + e[2] * w[2] - e[3] * w[1]) * half;
  rate[2] = (e[0] * w[1] + e[3] * w[0] - e[1] * w[2]) * half;
  rate[3] = (e[0] * w[2] + e[1] * w[1] - e[2] * w[0]) * half;
}

}  // namespace lanc
