// Vectors fixed at points, and what turning them does: the operator that Coriolis forces and dead loads have in common.
// Private to lib/derivatives.
#pragma once

#include "lib/spatial/spatial.h"

namespace lanc {

/// Vectors u at points ρ (from a reference point): when each turns, u becomes s × u, they change as a wrench by
///   moment Σ ρ × (s × u) = K s, K = Σ (ρ·u) 1 − u ρᵀ,    force s × Σ u.
/// Composite: that of a body and all it carries is their sum about one point. Tested with the derivatives.
struct TurnedVectors {
  Mat3<double> K;
  Vec3<double> sum;

  Wrench<double> operator()(const Vec3<double>& s) const { return {K * s, cross(s, sum)}; }
  /// The transposed operator: t with t·s = motion · (*this)(s) for all s.
  Vec3<double> transposed(const Motion<double>& motion) const {
    return transpose_times(K, motion.angular) + cross(sum, motion.linear);
  }
  TurnedVectors& operator+=(const TurnedVectors& b) {
    K.x += b.K.x, K.y += b.K.y, K.z += b.K.z, sum += b.sum;
    return *this;
  }
};

/// About the parent's reference point: ρ + r in place of ρ.
inline TurnedVectors moved_inward(const Vec3<double>& r, const TurnedVectors& t) {
  const double along = dot(r, t.sum);
  const Vec3<double>&u = t.sum, &x = t.K.x, &y = t.K.y, &z = t.K.z;
  return {{{x.x + along - u.x * r.x, x.y - u.y * r.x, x.z - u.z * r.x},
           {y.x - u.x * r.y, y.y + along - u.y * r.y, y.z - u.z * r.y},
           {z.x - u.x * r.z, z.y - u.y * r.z, z.z + along - u.z * r.z}},
          u};
}

/// The momenta u dm of a body with twist v = [ω; v] at its reference point: K = (h·v) 1 − v hᵀ − [ω]× (½ tr J 1 − J).
inline TurnedVectors momenta(const RigidInertia<double>& M, const Motion<double>& v) {
  const Vec3<double>&w = v.angular, &u = v.linear, &h = M.h;
  const double half = 0.5 * (M.J.xx + M.J.yy + M.J.zz), along = dot(h, u);
  const Mat3<double> second{{half - M.J.xx, -M.J.xy, -M.J.xz},
                            {-M.J.xy, half - M.J.yy, -M.J.yz},
                            {-M.J.xz, -M.J.yz, half - M.J.zz}};  // ∫ ρ ρᵀ dm
  const auto column = [&](const Vec3<double>& s, double hk) { return -(u * hk) - cross(w, s); };
  TurnedVectors t{{column(second.x, h.x), column(second.y, h.y), column(second.z, h.z)}, u * M.mass + cross(w, h)};
  t.K.x.x += along, t.K.y.y += along, t.K.z.z += along;
  return t;
}

/// A wrench that keeps its direction in the world while its body turns: it seems to turn the other way. Its moment is a
/// free vector: s × τ.
inline TurnedVectors dead_load(const Wrench<double>& w) {
  const Vec3<double>& t = w.moment;
  return {{{0, -t.z, t.y}, {t.z, 0, -t.x}, {-t.y, t.x, 0}}, w.force};
}

}  // namespace lanc
