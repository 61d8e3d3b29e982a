// Vectors of space in one register each.
// Private to lib: what uses it differs between objects compiled for different processors.
#pragma once

#include <array>
#include <type_traits>

#include "lib/scalar/pack.h"
#include "lib/spatial/spatial.h"

namespace lanc {

#if defined(__AVX__)

/// In place of a scalar: a Vec3<Wide> has its three doubles side by side in a register, hence so have matrices and
/// motions of Wide. Where body follows body, each waiting for the one before, this is what SIMD can do.
/// Tested by tests/lib/spatial_test.cpp.
struct Wide {};

template <>
struct Vec3<Wide> {
  Pack<double, 4> v{};

  Vec3() = default;
  explicit Vec3(const Pack<double, 4>& numbers) : v(numbers) {}
  Vec3& operator+=(const Vec3& b) { return v += b.v, *this; }
  friend Vec3 operator+(const Vec3& a, const Vec3& b) { return Vec3(a.v + b.v); }
  friend Vec3 operator-(const Vec3& a, const Vec3& b) { return Vec3(a.v - b.v); }
  friend Vec3 operator*(const Vec3& a, double s) { return Vec3(a.v * Pack<double, 4>(s)); }
};

[[gnu::always_inline]] inline Vec3<Wide> cross(const Vec3<Wide>& a, const Vec3<Wide>& b) {
  const auto yzx = [](const Pack<double, 4>& v) { return shuffled<1, 2, 0, 3>(v, v); };
  return Vec3<Wide>(yzx(a.v * yzx(b.v) - yzx(a.v) * b.v));
}

[[gnu::always_inline]] inline Vec3<Wide> operator*(const Mat3<Wide>& m, const Vec3<double>& a) {
  return m.x * a.x + m.y * a.y + m.z * a.z;
}
[[gnu::always_inline]] inline Mat3<Wide> operator*(const Mat3<Wide>& m, const Mat3<double>& n) {
  return {m * n.x, m * n.y, m * n.z};
}

/// What vectors of S are made of while a body is computed: Wide where registers have room for it. Together with
/// body_lanes.h, open chains and trees take 0.72 of the time of kinematics on AVX-512, 0.71 to 0.83 on AVX2.
template <class S>
using Widest = std::conditional_t<std::is_same_v<S, double>, Wide, S>;

#else

template <class S>
using Widest = S;

#endif

/// The same vector or matrix, differently laid out; no operation. A place of a Wide vector has four numbers, the fourth
/// of no meaning.
template <class W, class S>
inline Vec3<W> widened(const Vec3<S>& a) {
  if constexpr (std::is_same_v<W, S>)
    return a;
  else
    return Vec3<W>(Pack<double, 4>(a.x, a.y, a.z, 0));
}
template <class W, class S>
inline Mat3<W> widened(const Mat3<S>& m) {
  return {widened<W>(m.x), widened<W>(m.y), widened<W>(m.z)};
}
template <class W, class S, std::size_t n>
inline Vec3<W> load(const std::array<S, n>& from) {
  if constexpr (std::is_same_v<W, S>)
    return {from[0], from[1], from[2]};
  else
    return Vec3<W>(Pack<double, 4>::load(from.data()));
}
template <class W, class S, std::size_t n>
inline void store(const Vec3<W>& a, std::array<S, n>& to) {
  if constexpr (std::is_same_v<W, S>)
    to[0] = a.x, to[1] = a.y, to[2] = a.z;
  else
    a.v.store(to.data());
}
template <class W, class S>
inline void store(const Vec3<W>& a, Vec3<S>& to) {
  if constexpr (std::is_same_v<W, S>)
    to = a;
  else
    shuffled<0, 1>(a.v, a.v).store(&to.x), to.z = a.v[2];
}

}  // namespace lanc
