// Several bodies side by side in the lanes of a pack, for work on each of which its neighbours do not matter.
#pragma once

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
};
template <>
struct PackedScalar<double> {
  using type = Pack<double, 8>;
  using Constant = type;
  static constexpr int lanes = type::lanes;
  static double get(const type& block, int lane) { return block[lane]; }
  static void set(type& block, int lane, double x) { block.set(lane, x); }
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

}  // namespace lanc
