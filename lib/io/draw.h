// Random numbers that are equal on every machine.
#pragma once

#include <cmath>
#include <cstdint>

namespace lanc {

/// SplitMix64 (Steele, Lea & Flood 2014, OOPSLA, fig. 17): 64 bits of state, integer arithmetic only. The distributions
/// of the standard library differ between implementations, so numbers are made here, with + − × and no contraction:
/// include this header only in files compiled with -ffp-contract=off (lib/CMakeLists.txt).
class Draw {
 public:
  explicit Draw(std::uint64_t seed) : state_(seed) {}

  std::uint64_t bits() {
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
  }
  /// Uniform in [0, 1), a multiple of 2⁻⁵³.
  double unit() { return static_cast<double>(bits() >> 11) * 0x1p-53; }
  double between(double low, double high) { return low + (high - low) * unit(); }
  /// Uniform in 0 … count − 1; the bias of the remainder, count / 2⁶⁴, does not matter here.
  int index(int count) { return static_cast<int>(bits() % static_cast<std::uint64_t>(count)); }
  bool chance(double probability) { return unit() < probability; }

  /// A point of the unit sphere in `size` dimensions (at most 4), by rejection from the cube.
  void direction(double* x, int size) {
    for (;;) {
      double square = 0;
      for (int k = 0; k < size; ++k) x[k] = between(-1, 1), square += x[k] * x[k];
      if (square > 1 || square < 0.01) continue;
      const double norm = std::sqrt(square);
      for (int k = 0; k < size; ++k) x[k] /= norm;
      return;
    }
  }

 private:
  std::uint64_t state_;
};

}  // namespace lanc
