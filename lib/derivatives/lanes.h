// Columns by vectors of the processor: std::experimental::simd, the parallelism TS in libstdc++. g++ vectorises few of
// these loops by itself, and takes the columns left over one by one.
// Private to lib/derivatives.
#pragma once

#include <Eigen/Core>
#include <experimental/simd>
#include <vector>

namespace lanc {

using Lanes = std::experimental::native_simd<double>;

/// All columns of a vector.
struct AllLanes {
  Lanes load(const double* at) const { return Lanes(at, std::experimental::element_aligned); }
  void store(double* at, const Lanes& x) const { x.copy_to(at, std::experimental::element_aligned); }
};

/// Some columns of a vector, those from `first` to `end`: the others are neither read nor written.
struct SomeLanes {
  Lanes::mask_type mask;
  SomeLanes(int first, int end) {
    const Lanes column([](int i) { return double(i); });
    mask = column >= double(first) && column < double(end);
  }
  Lanes load(const double* at) const {
    Lanes x = 0;
    where(mask, x).copy_from(at, std::experimental::element_aligned);
    return x;
  }
  void store(double* at, const Lanes& x) const { where(mask, x).copy_to(at, std::experimental::element_aligned); }
};

/// Rows that begin at the border of a vector, `padded` apart: then vectors do not lie across lines of the cache.
using AlignedRows = std::vector<double, Eigen::aligned_allocator<double>>;
constexpr int padded(int columns) {
  constexpr int width = static_cast<int>(Lanes::size());
  return (columns + width - 1) / width * width;
}

/// body(column, lanes) for whole vectors of columns, counted from column 0, that hold columns from `first` to `end`.
template <class Body>
[[gnu::always_inline]] inline void for_columns(int first, int end, Body&& body) {
  constexpr int width = static_cast<int>(Lanes::size());
  for (int i = first / width * width; i < end; i += width)
    if (i >= first && i + width <= end)
      body(i, AllLanes());
    else
      body(i, SomeLanes(first - i, end - i));
}

}  // namespace lanc
