// Pack: N numbers in the lanes of SIMD registers, as one scalar.
#pragma once

#include <cmath>
#include <cstdint>
#include <type_traits>

#include "lib/scalar/sines.h"

namespace lanc {

/// Lane by lane + − × ÷ sqrt sin cos, by the compiler's vector types: whatever the target has is used, wider packs take
/// several registers. There is no comparison; a NaN stays in its lane. T: double or float. N: a power of two.
/// Tested by tests/lib/pack_test.cpp.
template <class T, int N>
class Pack {
 public:
  static constexpr int lanes = N;

  Pack() = default;
  constexpr Pack(T x) : v_(x - Vector{}) {}  // NOLINT: implicit, as int to double is; the same in every lane

  T operator[](int lane) const { return v_[lane]; }
  void set(int lane, T x) { v_[lane] = x; }
  /// N numbers that follow one another in memory.
  static Pack load(const T* from) {
    Pack p;
    __builtin_memcpy(&p.v_, from, sizeof p.v_);
    return p;
  }
  void store(T* to) const { __builtin_memcpy(to, &v_, sizeof v_); }

  Pack operator-() const { return of(-v_); }
  Pack& operator+=(const Pack& b) { return v_ += b.v_, *this; }
  Pack& operator-=(const Pack& b) { return v_ -= b.v_, *this; }
  Pack& operator*=(const Pack& b) { return v_ *= b.v_, *this; }
  Pack& operator/=(const Pack& b) { return v_ /= b.v_, *this; }
  friend Pack operator+(const Pack& a, const Pack& b) { return of(a.v_ + b.v_); }
  friend Pack operator-(const Pack& a, const Pack& b) { return of(a.v_ - b.v_); }
  friend Pack operator*(const Pack& a, const Pack& b) { return of(a.v_ * b.v_); }
  friend Pack operator/(const Pack& a, const Pack& b) { return of(a.v_ / b.v_); }
  friend Pack sqrt(const Pack& a) {
    Pack r;
    for (int k = 0; k < N; ++k) r.v_[k] = std::sqrt(a.v_[k]);
    return r;
  }
  /// |a|, and the larger of two (b where it is NaN), lane by lane: for bounds on answers, not for mechanics, which
  /// compares nothing.
  friend Pack magnitude(const Pack& a) {  // the sign's bit off: one instruction
    return of(reinterpret_cast<Vector>(reinterpret_cast<Bits>(a.v_) & ~(Bits{} + (Bit{1} << (8 * sizeof(T) - 1)))));
  }
  friend Pack larger(const Pack& a, const Pack& b) { return of(a.v_ > b.v_ ? a.v_ : b.v_); }
  /// The first `count` lanes of a, 0 in the others, whatever stands there.
  friend Pack first_lanes(const Pack& a, int count) {
    Vector lane;
    for (int k = 0; k < N; ++k) lane[k] = static_cast<T>(k);
    return of(lane < static_cast<T>(count) ? a.v_ : Vector{});
  }
  friend Pack sin(const Pack& a) {
    T x[N], s[N], c[N];
    a.store(x);
    sines_and_cosines(x, s, c, N);
    return load(s);
  }
  friend Pack cos(const Pack& a) {
    T x[N], s[N], c[N];
    a.store(x);
    sines_and_cosines(x, s, c, N);
    return load(c);
  }

 private:
  // g++ 12 ignores the attribute in an alias
  typedef T Vector __attribute__((vector_size(N * sizeof(T))));
  using Bit = std::conditional_t<sizeof(T) == 8, std::uint64_t, std::uint32_t>;
  typedef Bit Bits __attribute__((vector_size(N * sizeof(T))));
  static Pack of(const Vector& v) {
    Pack p;
    p.v_ = v;
    return p;
  }
  Vector v_;
};

/// Numbers below 10⁻³⁸ are zero.
template <class S>
constexpr bool is_single_precision = false;
template <int N>
constexpr bool is_single_precision<Pack<float, N>> = true;

template <class T, int N>
inline void sines_and_cosines(const Pack<T, N>* angle, Pack<T, N>* sine, Pack<T, N>* cosine, int n) {
  static_assert(sizeof(Pack<T, N>) == N * sizeof(T));
  sines_and_cosines(reinterpret_cast<const T*>(angle), reinterpret_cast<T*>(sine), reinterpret_cast<T*>(cosine), N * n);
}

}  // namespace lanc
