// Vectors and 3×3 matrices of space, on any scalar.
//
// Plain structs instead of Eigen's fixed-size matrices: the recursion of eq. 18 on symmetric 3×3 blocks is the inner
// loop of the project, and each operation written here is one that Count counts (README, Decisions).
#pragma once

#include "lib/scalar/scalar.h"

namespace lanc {

/// A vector of space.
template <class S>
struct Vec3 {
  S x{}, y{}, z{};

  Vec3() = default;
  constexpr Vec3(const S& a, const S& b, const S& c) : x(a), y(b), z(c) {}
  // Copies are written out here and for Sym3. By wide loads they wait for the narrow stores that have just written what
  // they read, 6 % of the recursion; and vectors of packs g++ 12 copies through memory, a tenth of their kinematics.
  constexpr Vec3(const Vec3& b) : x(b.x), y(b.y), z(b.z) {}
  Vec3& operator=(const Vec3& b) { return x = b.x, y = b.y, z = b.z, *this; }
  Vec3& operator+=(const Vec3& b) { return x += b.x, y += b.y, z += b.z, *this; }
  Vec3& operator-=(const Vec3& b) { return x -= b.x, y -= b.y, z -= b.z, *this; }
  friend Vec3 operator+(const Vec3& a, const Vec3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend Vec3 operator-(const Vec3& a, const Vec3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend Vec3 operator-(const Vec3& a) { return {-a.x, -a.y, -a.z}; }
  friend Vec3 operator*(const Vec3& a, const S& s) { return {a.x * s, a.y * s, a.z * s}; }
};

template <class S>
inline S dot(const Vec3<S>& a, const Vec3<S>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

template <class S>
inline Vec3<S> cross(const Vec3<S>& a, const Vec3<S>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// c + a × b. As many operations as the sum, but in an order of which fused multiply-add takes two at a time: two
/// instructions a number, not three. So with products below.
template <class S>
inline Vec3<S> plus_cross(const Vec3<S>& c, const Vec3<S>& a, const Vec3<S>& b) {
  return {c.x + a.y * b.z - a.z * b.y, c.y + a.z * b.x - a.x * b.z, c.z + a.x * b.y - a.y * b.x};
}

/// The same vector on another scalar; no operation.
template <class S, class T>
inline Vec3<S> cast(const Vec3<T>& a) {
  return {S(a.x), S(a.y), S(a.z)};
}

/// A 3×3 matrix by its columns; as a rotation, the columns are the axes of the frame.
template <class S>
struct Mat3 {
  Vec3<S> x{}, y{}, z{};

  friend Vec3<S> operator*(const Mat3& m, const Vec3<S>& a) {
    return {m.x.x * a.x + m.y.x * a.y + m.z.x * a.z, m.x.y * a.x + m.y.y * a.y + m.z.y * a.z,
            m.x.z * a.x + m.y.z * a.y + m.z.z * a.z};
  }
  friend Mat3 operator*(const Mat3& m, const Mat3& n) { return {m * n.x, m * n.y, m * n.z}; }
};

/// c + m a.
template <class S>
inline Vec3<S> plus_product(const Vec3<S>& c, const Mat3<S>& m, const Vec3<S>& a) {
  return {c.x + m.x.x * a.x + m.y.x * a.y + m.z.x * a.z, c.y + m.x.y * a.x + m.y.y * a.y + m.z.y * a.z,
          c.z + m.x.z * a.x + m.y.z * a.y + m.z.z * a.z};
}

/// mᵀ a.
template <class S>
inline Vec3<S> transpose_times(const Mat3<S>& m, const Vec3<S>& a) {
  return {dot(m.x, a), dot(m.y, a), dot(m.z, a)};
}

/// c + mᵀ a.
template <class S>
inline Vec3<S> plus_transpose_product(const Vec3<S>& c, const Mat3<S>& m, const Vec3<S>& a) {
  return {c.x + m.x.x * a.x + m.x.y * a.y + m.x.z * a.z, c.y + m.y.x * a.x + m.y.y * a.y + m.y.z * a.z,
          c.z + m.z.x * a.x + m.z.y * a.y + m.z.z * a.z};
}

template <class S>
inline Mat3<S> transposed(const Mat3<S>& m) {
  return {{m.x.x, m.y.x, m.z.x}, {m.x.y, m.y.y, m.z.y}, {m.x.z, m.y.z, m.z.z}};
}

template <class S, class T>
inline Mat3<S> cast(const Mat3<T>& m) {
  return {cast<S>(m.x), cast<S>(m.y), cast<S>(m.z)};
}

template <class S>
inline Mat3<S> identity3() {
  return {{S(1.0), S(0.0), S(0.0)}, {S(0.0), S(1.0), S(0.0)}, {S(0.0), S(0.0), S(1.0)}};
}

/// A symmetric 3×3 matrix.
template <class S>
struct Sym3 {
  S xx{}, yy{}, zz{}, xy{}, xz{}, yz{};

  Sym3() = default;
  constexpr Sym3(const S& a, const S& b, const S& c, const S& d, const S& e, const S& f)
      : xx(a), yy(b), zz(c), xy(d), xz(e), yz(f) {}
  constexpr Sym3(const Sym3& b) : xx(b.xx), yy(b.yy), zz(b.zz), xy(b.xy), xz(b.xz), yz(b.yz) {}
  Sym3& operator=(const Sym3& b) { return xx = b.xx, yy = b.yy, zz = b.zz, xy = b.xy, xz = b.xz, yz = b.yz, *this; }
  Sym3& operator+=(const Sym3& b) {
    xx += b.xx, yy += b.yy, zz += b.zz, xy += b.xy, xz += b.xz, yz += b.yz;
    return *this;
  }
  friend Vec3<S> operator*(const Sym3& m, const Vec3<S>& a) {
    return {m.xx * a.x + m.xy * a.y + m.xz * a.z, m.xy * a.x + m.yy * a.y + m.yz * a.z,
            m.xz * a.x + m.yz * a.y + m.zz * a.z};
  }
};

/// c + m a.
template <class S>
inline Vec3<S> plus_product(const Vec3<S>& c, const Sym3<S>& m, const Vec3<S>& a) {
  return {c.x + m.xx * a.x + m.xy * a.y + m.xz * a.z, c.y + m.xy * a.x + m.yy * a.y + m.yz * a.z,
          c.z + m.xz * a.x + m.yz * a.y + m.zz * a.z};
}

template <class S, class T>
inline Sym3<S> cast(const Sym3<T>& m) {
  return {S(m.xx), S(m.yy), S(m.zz), S(m.xy), S(m.xz), S(m.yz)};
}

}  // namespace lanc
