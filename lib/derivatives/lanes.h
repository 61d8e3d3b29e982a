// Columns by vectors of the processor: std::experimental::simd, the parallelism TS in libstdc++. g++ vectorises few of
// these loops by itself, and takes the columns left over one by one.
// Private to lib/derivatives.
#pragma once

#include <experimental/simd>

namespace lanc {

using Lanes = std::experimental::native_simd<double>;

/// All columns of a vector.
struct AllLanes {
  Lanes load(const double* at) const { return Lanes(at, std::experimental::element_aligned); }
  void store(double* at, const Lanes& x) const { x.copy_to(at, std::experimental::element_aligned); }
};

/// The first columns of a vector: the others are neither read nor written.
struct SomeLanes {
  Lanes::mask_type mask;
  explicit SomeLanes(int count) : mask(Lanes([](int i) { return double(i); }) < double(count)) {}
  Lanes load(const double* at) const {
    Lanes x = 0;
    where(mask, x).copy_from(at, std::experimental::element_aligned);
    return x;
  }
  void store(double* at, const Lanes& x) const { where(mask, x).copy_to(at, std::experimental::element_aligned); }
};

/// body(first column, lanes) for vectors of columns up to `count`.
template <class Body>
[[gnu::always_inline]] inline void for_columns(int count, Body&& body) {
  constexpr int width = static_cast<int>(Lanes::size());
  int i = 0;
  for (; i + width <= count; i += width) body(i, AllLanes());
  if (i < count) body(i, SomeLanes(count - i));
}

}  // namespace lanc
