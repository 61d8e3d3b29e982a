// Dual: a double with its derivatives in N directions, carried through + − × ÷ sin cos sqrt by the chain rule.
#pragma once

#include <cmath>

namespace lanc {

/// Derivatives exact to rounding, at about N + 1 times the cost of a double. Tested by tests/lib/dual_test.cpp.
template <int N>
struct Dual {
  double value = 0;
  double d[N] = {};

  Dual() = default;
  constexpr Dual(double x) : value(x) {}  // NOLINT: implicit, as int to double is

  /// The variable with derivative 1 in direction k.
  static Dual variable(double x, int k) {
    Dual result(x);
    result.d[k] = 1;
    return result;
  }

  Dual operator-() const { return scaled(-value, -1, *this); }
  Dual& operator+=(const Dual& b) { return *this = *this + b; }
  Dual& operator-=(const Dual& b) { return *this = *this - b; }
  Dual& operator*=(const Dual& b) { return *this = *this * b; }
  Dual& operator/=(const Dual& b) { return *this = *this / b; }

  friend Dual operator+(const Dual& a, const Dual& b) { return combined(a.value + b.value, 1, a, 1, b); }
  friend Dual operator-(const Dual& a, const Dual& b) { return combined(a.value - b.value, 1, a, -1, b); }
  friend Dual operator*(const Dual& a, const Dual& b) { return combined(a.value * b.value, b.value, a, a.value, b); }
  friend Dual operator/(const Dual& a, const Dual& b) {
    const double quotient = a.value / b.value;
    return combined(quotient, 1 / b.value, a, -quotient / b.value, b);
  }
  friend Dual sqrt(const Dual& a) {
    const double root = std::sqrt(a.value);
    return scaled(root, 0.5 / root, a);
  }
  friend Dual sin(const Dual& a) { return scaled(std::sin(a.value), std::cos(a.value), a); }
  friend Dual cos(const Dual& a) { return scaled(std::cos(a.value), -std::sin(a.value), a); }

 private:
  static Dual scaled(double value, double factor, const Dual& a) {
    Dual result(value);
    for (int k = 0; k < N; ++k) result.d[k] = factor * a.d[k];
    return result;
  }
  static Dual combined(double value, double p, const Dual& a, double q, const Dual& b) {
    Dual result(value);
    for (int k = 0; k < N; ++k) result.d[k] = p * a.d[k] + q * b.d[k];
    return result;
  }
};

}  // namespace lanc
