// Many wrenches or motions side by side, a row of numbers for each of their six components.
// Private to lib/derivatives.
#pragma once

#include "lib/derivatives/lanes.h"
#include "lib/spatial/spatial.h"

namespace lanc {

/// The arm of columns that stay where they are.
inline constexpr Vec3<double> nowhere{0, 0, 0};

/// Rows of moments or angular parts, then of forces or linear parts; `stride` from row to row.
struct SixRows {
  double* first;
  int stride;

  double* row(int i) const { return first + std::ptrdiff_t(i) * stride; }
  void set(int column, const Wrench<double>& f) const {
    double* at = first + column;
    for (const double x : {f.moment.x, f.moment.y, f.moment.z, f.force.x, f.force.y, f.force.z}) *at = x, at += stride;
  }
};

/// The columns of a vector.
struct SixLanes {
  Lanes x, y, z, u, v, w;

  template <class Where>
  [[gnu::always_inline]] SixLanes(const SixRows& rows, int column, const Where& lanes)
      : x(lanes.load(rows.row(0) + column)),
        y(lanes.load(rows.row(1) + column)),
        z(lanes.load(rows.row(2) + column)),
        u(lanes.load(rows.row(3) + column)),
        v(lanes.load(rows.row(4) + column)),
        w(lanes.load(rows.row(5) + column)) {}

  template <class Where>
  [[gnu::always_inline]] void store_upper(const SixRows& rows, int column, const Where& lanes) const {
    lanes.store(rows.row(0) + column, x), lanes.store(rows.row(1) + column, y), lanes.store(rows.row(2) + column, z);
  }
  template <class Where>
  [[gnu::always_inline]] void store(const SixRows& rows, int column, const Where& lanes) const {
    store_upper(rows, column, lanes);
    lanes.store(rows.row(3) + column, u), lanes.store(rows.row(4) + column, v), lanes.store(rows.row(5) + column, w);
  }

  /// Products of the two halves with vectors, and sums with multiples of vectors.
  Lanes upper(const Vec3<double>& a) const { return x * a.x + y * a.y + z * a.z; }
  Lanes lower(const Vec3<double>& a) const { return u * a.x + v * a.y + w * a.z; }
  void add_upper(const Vec3<double>& a, const Lanes& s) { x += a.x * s, y += a.y * s, z += a.z * s; }
  void add_lower(const Vec3<double>& a, const Lanes& s) { u += a.x * s, v += a.y * s, w += a.z * s; }
  /// B_ipᵀ of wrenches: r × force.
  void move_inward(const Vec3<double>& r) { x += r.y * w - r.z * v, y += r.z * u - r.x * w, z += r.x * v - r.y * u; }
  /// B_ip of motions: angular × r.
  void move_outward(const Vec3<double>& r) { u += r.z * y - r.y * z, v += r.x * z - r.z * x, w += r.y * x - r.x * y; }
};

/// Cᵀ f and a += C s, as project() and add_along() do for one (lib/spatial/spatial.h).
template <ColumnKind kind>
[[gnu::always_inline]] inline Lanes project(const Motion<double>& C, const SixLanes& f) {
  if constexpr (kind == ColumnKind::rotation) return f.upper(C.angular);
  if constexpr (kind == ColumnKind::translation) return f.lower(C.linear);
  return f.upper(C.angular) + f.lower(C.linear);
}
template <ColumnKind kind>
[[gnu::always_inline]] inline void add_along(const Motion<double>& C, const Lanes& s, SixLanes& a) {
  if constexpr (kind != ColumnKind::translation) a.add_upper(C.angular, s);
  if constexpr (kind != ColumnKind::rotation) a.add_lower(C.linear, s);
}

}  // namespace lanc
