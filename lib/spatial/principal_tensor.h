// Symmetric tensors in the form that is turned with the fewest operations.
#pragma once

#include <Eigen/Eigenvalues>
#include <cmath>

#include "lib/spatial/eigen.h"

namespace lanc {

/// c 1 + u uᵀ + w wᵀ: with principal values c ≤ b ≤ a along the unit axes e_c, e_b and e_a, u = √(a − c) e_a and
/// w = √(b − c) e_b. Where c ≥ 0, as of inertias, nothing cancels.
template <class S>
struct PrincipalTensor {
  S c{};
  Vec3<S> u, w;
};

/// Of any symmetric matrix of finite numbers, to rounding. Tested by tests/lib/spatial_test.cpp.
inline PrincipalTensor<double> principal_tensor(const Sym3<double>& m) {
  Eigen::Matrix3d dense;
  dense << m.xx, m.xy, m.xz, m.xy, m.yy, m.yz, m.xz, m.yz, m.zz;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> principal(dense);
  const Eigen::Vector3d& value = principal.eigenvalues();
  const auto along = [&](int k) {
    return from_eigen(Eigen::Vector3d(std::sqrt(value[k] - value[0]) * principal.eigenvectors().col(k)));
  };
  return {value[0], along(2), along(1)};
}

/// R m Rᵀ: a tensor given in the axes of R, in the axes R itself is given in. 51 operations, 75 for six entries: a
/// fiftieth of the time of packs, which spend half of it multiplying. Always inlined: a result returned through memory
/// costs the kinematics a tenth.
template <class S, class T>
[[gnu::always_inline]] inline Sym3<S> rotated(const Mat3<S>& R, const PrincipalTensor<T>& m) {
  const Vec3<S> u = R * cast<S>(m.u), w = R * cast<S>(m.w);
  const S c(m.c);
  return {c + u.x * u.x + w.x * w.x, c + u.y * u.y + w.y * w.y, c + u.z * u.z + w.z * w.z,
          u.x * u.y + w.x * w.y,     u.x * u.z + w.x * w.z,     u.y * u.z + w.y * w.z};
}

}  // namespace lanc
