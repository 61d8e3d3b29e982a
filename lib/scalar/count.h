// Count: a double that counts the floating-point operations done on it.
//
// Running the same source on Count instead of double gives exact operation counts (design: flops are counted, never
// estimated). Every counter is thread local. A change of sign and a comparison are no operation; a conversion is none.
// Tested by tests/lib/scalar_test.cpp.
#pragma once

#include <cmath>
#include <cstdint>

namespace lanc {

/// Operations done since the thread started; differences of two snapshots are what one measures.
struct Tally {
  std::int64_t add = 0, sub = 0, mul = 0, div = 0, sqrt = 0, trig = 0;

  /// + − × ÷ and square roots: what this project calls "flops". Trigonometric functions are reported apart.
  std::int64_t flops() const { return add + sub + mul + div + sqrt; }

  friend Tally operator-(Tally a, const Tally& b) {
    a.add -= b.add, a.sub -= b.sub, a.mul -= b.mul, a.div -= b.div, a.sqrt -= b.sqrt, a.trig -= b.trig;
    return a;
  }
};

class Count {
 public:
  Count() = default;
  constexpr Count(double value) : value_(value) {}  // NOLINT: implicit, as int to double is
  explicit operator double() const { return value_; }
  double value() const { return value_; }

  static Tally& tally() {
    thread_local Tally counters;
    return counters;
  }

  Count operator-() const { return -value_; }
  Count& operator+=(Count b) { return *this = *this + b; }
  Count& operator-=(Count b) { return *this = *this - b; }
  Count& operator*=(Count b) { return *this = *this * b; }
  Count& operator/=(Count b) { return *this = *this / b; }

  friend Count operator+(Count a, Count b) { return ++tally().add, Count(a.value_ + b.value_); }
  friend Count operator-(Count a, Count b) { return ++tally().sub, Count(a.value_ - b.value_); }
  friend Count operator*(Count a, Count b) { return ++tally().mul, Count(a.value_ * b.value_); }
  friend Count operator/(Count a, Count b) { return ++tally().div, Count(a.value_ / b.value_); }
  friend Count sqrt(Count a) { return ++tally().sqrt, Count(std::sqrt(a.value_)); }
  friend Count sin(Count a) { return ++tally().trig, Count(std::sin(a.value_)); }
  friend Count cos(Count a) { return ++tally().trig, Count(std::cos(a.value_)); }
  friend Count abs(Count a) { return std::abs(a.value_); }

  friend bool operator==(Count a, Count b) { return a.value_ == b.value_; }
  friend bool operator!=(Count a, Count b) { return a.value_ != b.value_; }
  friend bool operator<(Count a, Count b) { return a.value_ < b.value_; }
  friend bool operator>(Count a, Count b) { return a.value_ > b.value_; }
  friend bool operator<=(Count a, Count b) { return a.value_ <= b.value_; }
  friend bool operator>=(Count a, Count b) { return a.value_ >= b.value_; }

 private:
  double value_ = 0;
};

}  // namespace lanc
