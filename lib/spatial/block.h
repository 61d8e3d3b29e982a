// Several bodies side by side in the lanes of a pack, for work on each of which its neighbours do not matter.
#pragma once

#include <array>

#include "lib/scalar/pack.h"
#include "lib/spatial/spatial.h"

namespace lanc {

/// The scalar of a block of bodies: on double a pack, on any other scalar that scalar, a block then being one body.
template <class S>
struct PackedScalar {
  using type = S;
  using Constant = double;
  static constexpr int lanes = 1;
  static S get(const S& block, int) { return block; }
  static void set(S& block, int, const S& x) { block = x; }
  static S with_lane(const S&, int, const S& x) { return x; }
};
template <>
struct PackedScalar<double> {
  using type = Pack<double, 8>;
  using Constant = type;
  static constexpr int lanes = type::lanes;
  static double get(const type& block, int lane) { return block[lane]; }
  static void set(type& block, int lane, double x) { block.set(lane, x); }
  static type with_lane(const type& block, int lane, double x) { return block.with_lane(lane, x); }
};
template <class S>
using Packed = typename PackedScalar<S>::type;
/// Of what does not change with the state: plain numbers where a block is one body, whatever its scalar.
template <class S>
using PackedConstant = typename PackedScalar<S>::Constant;
/// How many blocks hold that many bodies.
template <class S>
constexpr int blocks_of(int bodies) {
  return (bodies + PackedScalar<S>::lanes - 1) / PackedScalar<S>::lanes;
}

/// Numbers of one array as blocks; it must be allocated in whole blocks.
template <class S>
inline Packed<S> load_block(const S* from) {
  if constexpr (PackedScalar<S>::lanes == 1)
    return *from;
  else
    return Packed<S>::load(from);
}
template <class S>
inline void store_block(const Packed<S>& block, S* to) {
  if constexpr (PackedScalar<S>::lanes == 1)
    *to = block;
  else
    block.store(to);
}

/// As many blocks as a block has lanes, transposed.
template <class B, std::size_t n>
[[gnu::always_inline]] inline void transpose(std::array<B, n>& rows) {
  if constexpr (n > 1) {
    const std::array<B, n> columns = rows;
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t k = 0; k < n; ++k) rows[i].set(k, columns[k][i]);
  }
}
#if defined(__AVX512F__)
template <>
[[gnu::always_inline]] inline void transpose(std::array<Pack<double, 8>, 8>& a) {
  std::array<Pack<double, 8>, 8> b;
  for (int i = 0; i < 8; i += 2) {
    b[i] = shuffled<0, 8, 2, 10, 4, 12, 6, 14>(a[i], a[i + 1]);
    b[i + 1] = shuffled<1, 9, 3, 11, 5, 13, 7, 15>(a[i], a[i + 1]);
  }
  for (int i = 0; i < 8; i += 4)
    for (int k = i; k < i + 2; ++k) {
      a[k] = shuffled<0, 1, 8, 9, 4, 5, 12, 13>(b[k], b[k + 2]);
      a[k + 2] = shuffled<2, 3, 10, 11, 6, 7, 14, 15>(b[k], b[k + 2]);
    }
  for (int k = 0; k < 4; ++k) {
    b[k] = shuffled<0, 1, 2, 3, 8, 9, 10, 11>(a[k], a[k + 4]);
    b[k + 4] = shuffled<4, 5, 6, 7, 12, 13, 14, 15>(a[k], a[k + 4]);
  }
  a = b;
}
#endif

/// One body's part of a block. Always inlined: a matrix returned through memory costs the kinematics a tenth.
template <class S>
[[gnu::always_inline]] inline Vec3<S> lane_of(const Vec3<Packed<S>>& a, int lane) {
  using B = PackedScalar<S>;
  return {B::get(a.x, lane), B::get(a.y, lane), B::get(a.z, lane)};
}
template <class S>
[[gnu::always_inline]] inline Mat3<S> lane_of(const Mat3<Packed<S>>& m, int lane) {
  return {lane_of<S>(m.x, lane), lane_of<S>(m.y, lane), lane_of<S>(m.z, lane)};
}
template <class S>
[[gnu::always_inline]] inline Sym3<S> lane_of(const Sym3<Packed<S>>& m, int lane) {
  using B = PackedScalar<S>;
  return {B::get(m.xx, lane), B::get(m.yy, lane), B::get(m.zz, lane),
          B::get(m.xy, lane), B::get(m.xz, lane), B::get(m.yz, lane)};
}

template <class S>
[[gnu::always_inline]] inline void set_lane(Vec3<Packed<S>>& block, int lane, const Vec3<S>& a) {
  using B = PackedScalar<S>;
  B::set(block.x, lane, a.x), B::set(block.y, lane, a.y), B::set(block.z, lane, a.z);
}
template <class S>
[[gnu::always_inline]] inline void set_lane(Mat3<Packed<S>>& block, int lane, const Mat3<S>& m) {
  set_lane<S>(block.x, lane, m.x), set_lane<S>(block.y, lane, m.y), set_lane<S>(block.z, lane, m.z);
}
template <class S>
[[gnu::always_inline]] inline void set_lane(Sym3<Packed<S>>& block, int lane, const Sym3<S>& m) {
  using B = PackedScalar<S>;
  B::set(block.xx, lane, m.xx), B::set(block.yy, lane, m.yy), B::set(block.zz, lane, m.zz);
  B::set(block.xy, lane, m.xy), B::set(block.xz, lane, m.xz), B::set(block.yz, lane, m.yz);
}

/// A block of wrenches with another one in one lane, which may be a variable: without a way through memory.
template <class S>
[[gnu::always_inline]] inline Wrench<Packed<S>> with_lane(const Wrench<Packed<S>>& block, int lane,
                                                          const Wrench<S>& one) {
  const auto vector = [lane](const Vec3<Packed<S>>& a, const Vec3<S>& b) __attribute__((always_inline)) {
    using B = PackedScalar<S>;
    return Vec3<Packed<S>>{B::with_lane(a.x, lane, b.x), B::with_lane(a.y, lane, b.y), B::with_lane(a.z, lane, b.z)};
  };
  return {vector(block.moment, one.moment), vector(block.force, one.force)};
}

}  // namespace lanc
