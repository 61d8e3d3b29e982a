// Between Eigen's types, which users and loaders speak, and the plain ones of the inner loops.
#pragma once

#include <Eigen/Core>

#include "lib/spatial/spatial.h"

namespace lanc {

inline Vec3<double> from_eigen(const Eigen::Vector3d& a) { return {a.x(), a.y(), a.z()}; }
inline Mat3<double> from_eigen(const Eigen::Matrix3d& m) {
  return {from_eigen(Eigen::Vector3d(m.col(0))), from_eigen(Eigen::Vector3d(m.col(1))),
          from_eigen(Eigen::Vector3d(m.col(2)))};
}
inline Sym3<double> symmetric_from_eigen(const Eigen::Matrix3d& m) {
  return {m(0, 0), m(1, 1), m(2, 2), m(0, 1), m(0, 2), m(1, 2)};
}
inline Eigen::Vector3d to_eigen(const Vec3<double>& a) { return {a.x, a.y, a.z}; }
inline Eigen::Matrix3d to_eigen(const Mat3<double>& m) {
  Eigen::Matrix3d result;
  result << to_eigen(m.x), to_eigen(m.y), to_eigen(m.z);
  return result;
}

}  // namespace lanc
