// The rows of one closure side by side.
// Private to formulations/recursive-loops.
#pragma once

#include <algorithm>
#include <array>

#include "lib/spatial/block.h"

namespace lanc {

/// `width` numbers, one per closure row. Where they are double and more than one, they are lanes of a pack, whose other
/// lanes are zero: 0.7 of the time of a ladder's factors, 0.87 of a solution's, against one row after the other.
template <class S, int width>
struct StripOf {
  static_assert(width == 1);
  using type = S;
};
template <>
struct StripOf<double, 3> {
  using type = Pack<double, 4>;
};
template <>
struct StripOf<double, 6> {
  using type = Pack<double, 8>;
};
template <class S, int width>
using Strip = typename StripOf<S, width>::type;

/// The width for closures that have so many rows each (0: they differ); a plan with others is in strips of 1.
template <class S>
constexpr int strip_width(int rows_each) {
  return std::is_same_v<S, double> && (rows_each == 3 || rows_each == 6) ? rows_each : 1;
}

constexpr int most_rows = 6;  // of a closure
template <int width>
constexpr int most_strips = width > 1 ? 1 : most_rows;
/// Where a strip is a closure, a loop over its strips is none.
template <int width>
constexpr int count(int strips) {
  return width > 1 ? 1 : strips;
}

template <int width, class L>
inline auto lane(const L& strip, int k) {
  if constexpr (width == 1)
    return strip;
  else
    return strip[k];
}
template <int width, class L, class S>
inline void set_lane(L& strip, int k, const S& x) {
  if constexpr (width == 1)
    strip = x;
  else
    strip.set(k, x);
}
template <int width, class L>
inline auto sum_of_lanes(const L& strip) {
  if constexpr (width == 1)
    return strip;
  else if constexpr (width == 3)
    return (strip[0] + strip[1]) + strip[2];
  else
    return ((strip[0] + strip[1]) + (strip[2] + strip[3])) + (strip[4] + strip[5]);
}
template <int width, class L>
inline auto sum_of_lanes(const Wrench<L>& w) {
  using S = decltype(lane<width>(w.moment.x, 0));
  return Wrench<S>{{sum_of_lanes<width>(w.moment.x), sum_of_lanes<width>(w.moment.y), sum_of_lanes<width>(w.moment.z)},
                   {sum_of_lanes<width>(w.force.x), sum_of_lanes<width>(w.force.y), sum_of_lanes<width>(w.force.z)}};
}
template <int width, class L>
inline auto lane(const Wrench<L>& w, int k) {
  using S = decltype(lane<width>(w.moment.x, 0));
  return Wrench<S>{{lane<width>(w.moment.x, k), lane<width>(w.moment.y, k), lane<width>(w.moment.z, k)},
                   {lane<width>(w.force.x, k), lane<width>(w.force.y, k), lane<width>(w.force.z, k)}};
}
template <int width, class L, class S>
inline void set_lane(Wrench<L>& w, int k, const Wrench<S>& x) {
  set_lane<width>(w.moment.x, k, x.moment.x), set_lane<width>(w.moment.y, k, x.moment.y);
  set_lane<width>(w.moment.z, k, x.moment.z), set_lane<width>(w.force.x, k, x.force.x);
  set_lane<width>(w.force.y, k, x.force.y), set_lane<width>(w.force.z, k, x.force.z);
}

/// A square matrix of `m` rows, each in strips, transposed. Six rows take the lanes of a register at once: a tenth of
/// the time of their factors.
template <int width, class L>
inline void transpose_rows(const L* from, L* to, int m) {
  if constexpr (width == 6) {
    std::array<L, 8> rows;
    rows.fill(L(0.0));
    std::copy_n(from, width, rows.begin());
    transpose(rows);
    std::copy_n(rows.begin(), width, to);
  } else {
    const int strips = m / width;
    for (int r = 0; r < m; ++r)
      for (int s = 0; s < strips; ++s) {
        L column(0.0);
        for (int k = 0; k < width; ++k)
          set_lane<width>(column, k, lane<width>(from[(s * width + k) * strips + r / width], r % width));
        to[r * strips + s] = column;
      }
  }
}

/// The same in every lane.
template <class L, class S>
inline Vec3<L> in_every_lane(const Vec3<S>& a) {
  return {L(a.x), L(a.y), L(a.z)};
}
template <class L, class S>
inline Motion<L> in_every_lane(const Motion<S>& a) {
  return {in_every_lane<L>(a.angular), in_every_lane<L>(a.linear)};
}
template <class L, class S>
inline Wrench<L> in_every_lane(const Wrench<S>& f) {
  return {in_every_lane<L>(f.moment), in_every_lane<L>(f.force)};
}

}  // namespace lanc
