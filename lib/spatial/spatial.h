// Six-vectors of motion and force, their transport between reference points, and spatial inertia.
//
// All in world axes; each body has a reference point of its own (the origin of its joint's frame). Angular part first:
//   twist v̂ = [ω; v], acceleration â = d/dt [ω; v], wrench f̂ = [τ; f].
// With r from the parent's to the body's reference point, B_ip = [[1, 0], [−[r]×, 1]] moves accelerations outward and
// B_ipᵀ = [[1, [r]×], [0, 1]] moves wrenches inward.
#pragma once

#include "lib/spatial/vector3.h"

namespace lanc {

/// Twist, acceleration, or column of a motion subspace.
template <class S>
struct Motion {
  Vec3<S> angular{}, linear{};

  Motion& operator+=(const Motion& b) { return angular += b.angular, linear += b.linear, *this; }
  friend Motion operator+(const Motion& a, const Motion& b) { return {a.angular + b.angular, a.linear + b.linear}; }
  friend Motion operator-(const Motion& a) { return {-a.angular, -a.linear}; }
  friend Motion operator-(const Motion& a, const Motion& b) { return {a.angular - b.angular, a.linear - b.linear}; }
  friend Motion operator*(const Motion& a, const S& s) { return {a.angular * s, a.linear * s}; }
};

/// Wrench: moment about a body's reference point, and force.
template <class S>
struct Wrench {
  Vec3<S> moment{}, force{};

  Wrench& operator+=(const Wrench& b) { return moment += b.moment, force += b.force, *this; }
  Wrench& operator-=(const Wrench& b) { return moment -= b.moment, force -= b.force, *this; }
  friend Wrench operator+(const Wrench& a, const Wrench& b) { return {a.moment + b.moment, a.force + b.force}; }
  friend Wrench operator-(const Wrench& a) { return {-a.moment, -a.force}; }
  friend Wrench operator-(const Wrench& a, const Wrench& b) { return {a.moment - b.moment, a.force - b.force}; }
  friend Wrench operator*(const Wrench& a, const S& s) { return {a.moment * s, a.force * s}; }
};

/// Power of a wrench on a motion (both at the same point).
template <class S>
inline S dot(const Motion<S>& a, const Wrench<S>& f) {
  return dot(a.angular, f.moment) + dot(a.linear, f.force);
}

/// B_ip a: acceleration (or column) of the parent, moved by r to the body's reference point. 12 operations.
template <class S>
inline Motion<S> moved_outward(const Vec3<S>& r, const Motion<S>& a) {
  return {a.angular, plus_cross(a.linear, a.angular, r)};
}

/// B_ipᵀ f: wrench on the body, moved by r to the parent's reference point. 12 operations. A sum on purpose: where a
/// wrench climbs a path, its force stays, and the moment waits for an addition only.
template <class S>
inline Wrench<S> moved_inward(const Vec3<S>& r, const Wrench<S>& f) {
  return {f.moment + cross(r, f.force), f.force};
}

template <class S, class T>
inline Motion<S> cast(const Motion<T>& a) {
  return {cast<S>(a.angular), cast<S>(a.linear)};
}
template <class S, class T>
inline Wrench<S> cast(const Wrench<T>& f) {
  return {cast<S>(f.moment), cast<S>(f.force)};
}

/// Which part of a motion-subspace column is not zero by structure. A revolute column is [a; 0], a prismatic one [0;
/// a]. Structure is data of the model, so using it costs no comparison on the scalar and saves half of the operations.
enum class ColumnKind : unsigned char { rotation, translation, screw };

/// Cᵀ f for one column.
template <class S>
inline S project(ColumnKind kind, const Motion<S>& column, const Wrench<S>& f) {
  if (kind == ColumnKind::rotation) return dot(column.angular, f.moment);
  if (kind == ColumnKind::translation) return dot(column.linear, f.force);
  return dot(column, f);
}

/// a += C s for one column.
template <class S, class W>
inline void add_along(ColumnKind kind, const Motion<W>& column, const S& s, Motion<W>& a) {
  if (kind != ColumnKind::translation) a.angular += column.angular * s;
  if (kind != ColumnKind::rotation) a.linear += column.linear * s;
}

/// Spatial inertia M_i of a rigid body about its reference point: [[J, [h]×], [−[h]×, m 1]].
template <class S>
struct RigidInertia {
  S mass{};     // kg
  Vec3<S> h{};  // mass × vector from the reference point to the centre of mass, kg m
  Sym3<S> J{};  // about the reference point, kg m²

  RigidInertia& operator+=(const RigidInertia& b) { return mass += b.mass, h += b.h, J += b.J, *this; }
  /// M a. 42 operations.
  friend Wrench<S> operator*(const RigidInertia& M, const Motion<S>& a) {
    return {M.J * a.angular + cross(M.h, a.linear), a.linear * M.mass + cross(a.angular, M.h)};
  }
};

/// f + M a. 48 operations.
template <class S>
inline Wrench<S> plus_product(const Wrench<S>& f, const RigidInertia<S>& M, const Motion<S>& a) {
  return {plus_cross(plus_product(f.moment, M.J, a.angular), M.h, a.linear),
          plus_cross(f.force + a.linear * M.mass, a.angular, M.h)};
}

/// M C for one column; 24 operations when the column is a pure rotation, 12 when it is a pure translation.
template <class S>
inline Wrench<S> times_column(const RigidInertia<S>& M, ColumnKind kind, const Motion<S>& column) {
  if (kind == ColumnKind::rotation) return {M.J * column.angular, cross(column.angular, M.h)};
  if (kind == ColumnKind::translation) return {cross(M.h, column.linear), column.linear * M.mass};
  return M * column;
}

/// B_ipᵀ M B_ip of a rigid inertia, which stays one: moved by r to the parent's reference point. 36 operations.
template <class S>
inline RigidInertia<S> moved_inward(const Vec3<S>& r, const RigidInertia<S>& M) {
  const Vec3<S> mr = r * M.mass;
  const Vec3<S> s = M.h + mr * S(0.5);  // J' = J + 2 (r·s) 1 − r sᵀ − s rᵀ
  const S x = r.x * s.x, y = r.y * s.y, z = r.z * s.z;
  const S xx = x + x, yy = y + y, zz = z + z;
  return {M.mass,
          M.h + mr,
          {M.J.xx + (yy + zz), M.J.yy + (xx + zz), M.J.zz + (xx + yy), M.J.xy - (r.x * s.y + r.y * s.x),
           M.J.xz - (r.x * s.z + r.z * s.x), M.J.yz - (r.y * s.z + r.z * s.y)}};
}

/// Articulated inertia M*: symmetric 6×6, [[J, H], [Hᵀ, M]].
template <class S>
struct ArticulatedInertia {
  Sym3<S> J{};
  Mat3<S> H{};  // moment per linear acceleration
  Sym3<S> M{};

  /// M* a. 66 operations.
  friend Wrench<S> operator*(const ArticulatedInertia& I, const Motion<S>& a) {
    return {plus_product(I.J * a.angular, I.H, a.linear), plus_product(transpose_times(I.H, a.angular), I.M, a.linear)};
  }
};

/// f + M* a. 72 operations.
template <class S>
inline Wrench<S> plus_product(const Wrench<S>& f, const ArticulatedInertia<S>& I, const Motion<S>& a) {
  return {plus_product(plus_product(f.moment, I.J, a.angular), I.H, a.linear),
          plus_product(plus_transpose_product(f.force, I.H, a.angular), I.M, a.linear)};
}

/// M* C for one column; 30 operations when the column is a pure rotation or translation.
template <class S>
inline Wrench<S> times_column(const ArticulatedInertia<S>& I, ColumnKind kind, const Motion<S>& column) {
  if (kind == ColumnKind::rotation) return {I.J * column.angular, transpose_times(I.H, column.angular)};
  if (kind == ColumnKind::translation) return {I.H * column.linear, I.M * column.linear};
  return I * column;
}

/// The rigid inertia written out as a full 6×6; no operation.
template <class S>
inline ArticulatedInertia<S> expanded(const RigidInertia<S>& R) {
  const S o(0.0);
  return {R.J, {{o, R.h.z, -R.h.y}, {-R.h.z, o, R.h.x}, {R.h.y, -R.h.x, o}}, {R.mass, R.mass, R.mass, o, o, o}};
}

/// M* += M. 15 operations, the zeros of M being known.
template <class S>
inline void add(ArticulatedInertia<S>& I, const RigidInertia<S>& R) {
  I.J += R.J;
  I.H.x.y += R.h.z, I.H.x.z -= R.h.y;
  I.H.y.x -= R.h.z, I.H.y.z += R.h.x;
  I.H.z.x += R.h.y, I.H.z.y -= R.h.x;
  I.M.xx += R.mass, I.M.yy += R.mass, I.M.zz += R.mass;
}

template <class S>
inline void add(ArticulatedInertia<S>& I, const ArticulatedInertia<S>& K) {
  I.J += K.J, I.M += K.M;
  I.H.x += K.H.x, I.H.y += K.H.y, I.H.z += K.H.z;
}

/// M* −= D Uᵀ with D = U / N: what is left when one freedom is released. 42 operations.
template <class S>
inline void subtract_outer(ArticulatedInertia<S>& I, const Wrench<S>& D, const Wrench<S>& U) {
  const auto symmetric = [](Sym3<S>& m, const Vec3<S>& d, const Vec3<S>& u) {
    m.xx -= d.x * u.x, m.yy -= d.y * u.y, m.zz -= d.z * u.z;
    m.xy -= d.x * u.y, m.xz -= d.x * u.z, m.yz -= d.y * u.z;
  };
  symmetric(I.J, D.moment, U.moment);
  symmetric(I.M, D.force, U.force);
  I.H.x -= D.moment * U.force.x;
  I.H.y -= D.moment * U.force.y;
  I.H.z -= D.moment * U.force.z;
}

/// B_ipᵀ M* B_ip: moved by r from the body's to the parent's reference point. 84 operations.
template <class S>
inline ArticulatedInertia<S> moved_inward(const Vec3<S>& r, const ArticulatedInertia<S>& I) {
  const Mat3<S>& H = I.H;
  // X = H + [r]× M, the block that couples moment and linear acceleration about the new point
  const Mat3<S> X = {plus_cross(H.x, r, Vec3<S>{I.M.xx, I.M.xy, I.M.xz}),
                     plus_cross(H.y, r, Vec3<S>{I.M.xy, I.M.yy, I.M.yz}),
                     plus_cross(H.z, r, Vec3<S>{I.M.xz, I.M.yz, I.M.zz})};
  // J' = J + [r]× Hᵀ − X [r]×, symmetric: six entries
  const Sym3<S>& J = I.J;
  return {{J.xx + r.y * H.z.x - r.z * H.y.x - r.z * X.y.x + r.y * X.z.x,
           J.yy + r.z * H.x.y - r.x * H.z.y - r.x * X.z.y + r.z * X.x.y,
           J.zz + r.x * H.y.z - r.y * H.x.z - r.y * X.x.z + r.x * X.y.z,
           J.xy + r.y * H.z.y - r.z * H.y.y - r.x * X.z.x + r.z * X.x.x,
           J.xz + r.y * H.z.z - r.z * H.y.z - r.y * X.x.x + r.x * X.y.x,
           J.yz + r.z * H.x.z - r.x * H.z.z - r.y * X.x.y + r.x * X.y.y},
          X,
          I.M};
}

}  // namespace lanc
