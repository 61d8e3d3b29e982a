// Pack: N numbers in the lanes of SIMD registers, as one scalar.
#pragma once

#include <cmath>
#include <cstdint>
#include <type_traits>

#include "lib/scalar/sines.h"

namespace lanc {

/// Bytes of the widest register of the processor that is compiled for.
#if defined(__AVX512F__)
inline constexpr int register_bytes = 64;
#elif defined(__AVX__)
inline constexpr int register_bytes = 32;
#else
inline constexpr int register_bytes = 16;
#endif

/// Lane by lane + − × ÷ sqrt sin cos, by the compiler's vector types: whatever the target has is used, wider packs take
/// several registers. There is no comparison; a NaN stays in its lane. T: double or float. N: a power of two.
/// Tested by tests/lib/pack_test.cpp.
template <class T, int N>
class Pack {
 public:
  static constexpr int lanes = N;

  Pack() = default;
  constexpr Pack(T x) : v_(x - Vector{}) {}  // NOLINT: implicit, as int to double is; the same in every lane

  template <class... More>
  constexpr Pack(T first, T second, More... more) : v_{first, second, static_cast<T>(more)...} {
    static_assert(sizeof...(More) + 2 == N, "one number a lane");
  }

  T operator[](int lane) const { return v_[lane]; }
  void set(int lane, T x) { v_[lane] = x; }
  /// With another number in one lane: in registers, where set() goes through memory if the lane is a variable.
  Pack with_lane(int lane, T x) const {
    Vector number;
    for (int k = 0; k < N; ++k) number[k] = static_cast<T>(k);
    return of(number == static_cast<T>(lane) + Vector{} ? x + Vector{} : v_);
  }
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
  /// Is every lane 0?
  friend bool vanishes(const Pack& a) {
    for (int k = 0; k < N; ++k)
      if (a.v_[k] != 0) return false;
    return true;
  }
  /// The first `count` lanes of a, 0 in the others, whatever stands there.
  friend Pack first_lanes(const Pack& a, int count) {
    Vector lane;
    for (int k = 0; k < N; ++k) lane[k] = static_cast<T>(k);
    return of(lane < static_cast<T>(count) ? a.v_ : Vector{});
  }
  template <int... from>
  [[gnu::always_inline]] static auto shuffle(const Pack& a, const Pack& b) {
    return Pack<T, sizeof...(from)>::of(__builtin_shufflevector(a.v_, b.v_, from...));
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
  template <class, int>
  friend class Pack;
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

/// Wider than a register: two halves. Left to g++ 12, vectors that no register holds are taken apart number by number;
/// `composite` took five times as long without AVX-512.
template <class T, int N>
requires(N* static_cast<int>(sizeof(T)) > register_bytes) class alignas(N * sizeof(T)) Pack<T, N> {
  using Half = Pack<T, N / 2>;

 public:
  static constexpr int lanes = N;

  Pack() = default;
  constexpr Pack(T x) : low_(x), high_(x) {}  // NOLINT: implicit

  T operator[](int lane) const { return lane < N / 2 ? low_[lane] : high_[lane - N / 2]; }
  void set(int lane, T x) { lane < N / 2 ? low_.set(lane, x) : high_.set(lane - N / 2, x); }
  Pack with_lane(int lane, T x) const { return {low_.with_lane(lane, x), high_.with_lane(lane - N / 2, x)}; }
  static Pack load(const T* from) { return {Half::load(from), Half::load(from + N / 2)}; }
  void store(T* to) const { low_.store(to), high_.store(to + N / 2); }

  Pack operator-() const { return {-low_, -high_}; }
  Pack& operator+=(const Pack& b) { return low_ += b.low_, high_ += b.high_, *this; }
  Pack& operator-=(const Pack& b) { return low_ -= b.low_, high_ -= b.high_, *this; }
  Pack& operator*=(const Pack& b) { return low_ *= b.low_, high_ *= b.high_, *this; }
  Pack& operator/=(const Pack& b) { return low_ /= b.low_, high_ /= b.high_, *this; }
  friend Pack operator+(const Pack& a, const Pack& b) { return {a.low_ + b.low_, a.high_ + b.high_}; }
  friend Pack operator-(const Pack& a, const Pack& b) { return {a.low_ - b.low_, a.high_ - b.high_}; }
  friend Pack operator*(const Pack& a, const Pack& b) { return {a.low_ * b.low_, a.high_ * b.high_}; }
  friend Pack operator/(const Pack& a, const Pack& b) { return {a.low_ / b.low_, a.high_ / b.high_}; }
  friend Pack sqrt(const Pack& a) { return {sqrt(a.low_), sqrt(a.high_)}; }
  friend Pack sin(const Pack& a) { return {sin(a.low_), sin(a.high_)}; }
  friend Pack cos(const Pack& a) { return {cos(a.low_), cos(a.high_)}; }
  friend Pack magnitude(const Pack& a) { return {magnitude(a.low_), magnitude(a.high_)}; }
  friend Pack larger(const Pack& a, const Pack& b) { return {larger(a.low_, b.low_), larger(a.high_, b.high_)}; }
  friend bool vanishes(const Pack& a) { return vanishes(a.low_) && vanishes(a.high_); }
  friend Pack first_lanes(const Pack& a, int count) {
    return {first_lanes(a.low_, count), first_lanes(a.high_, count - N / 2)};
  }

 private:
  Pack(const Half& low, const Half& high) : low_(low), high_(high) {}
  Half low_, high_;
};

/// Lane k of the result is lane from_k of a, or lane from_k − N of b. For packs that fit into a register.
template <int... from, class T, int N>
[[gnu::always_inline]] inline Pack<T, sizeof...(from)> shuffled(const Pack<T, N>& a, const Pack<T, N>& b) {
  return Pack<T, N>::template shuffle<from...>(a, b);
}

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
