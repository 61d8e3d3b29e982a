#include "lib/scalar/sines.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "lib/scalar/pack.h"

namespace lanc {
namespace {

typedef double Doubles __attribute__((vector_size(register_bytes)));
typedef std::int64_t Integers __attribute__((vector_size(register_bytes)));
constexpr int width = sizeof(Doubles) / sizeof(double);

/// c₀ + c₁ z + …
template <class... More>
Doubles polynomial(const Doubles& z, double c0, More... more) {
  if constexpr (sizeof...(More) == 0)
    return c0 + Doubles{};
  else
    return c0 + z * polynomial(z, more...);
}

/// Angles from here on are left to libm: of those below, fewer than 2¹⁷ quarter turns are taken off.
constexpr double far = 2e5;

/// Reduced to a quarter turn about zero (Cody & Waite 1980), there minimax polynomials of relative errors 3.4e-18
/// (sine) and 4.7e-20, by Remez' algorithm.
SinCos<Doubles> sine_and_cosine(const Doubles& x) {
  constexpr double two_over_pi = 0x1.45f306dc9c883p-1, shift = 0x1.8p52;
  // The nearest multiple of π/2: the last digits of a sum that is so large that all before the point is.
  const Doubles shifted = x * two_over_pi + shift, n = shifted - shift;
  // x − n π/2 = r + rest. π/2 is in three parts; the first two have 36 bits, so that n times them is exact.
  const Doubles first = x - n * 0x1.921fb5444p+0, second = n * 0x1.68c234c4cp-39, r = first - second;
  const Doubles rest = ((first - r) - second) - n * 0x1.98a2e03707345p-77;

  const Doubles z = r * r, half = 0.5 * z, one_less = 1 - half;
  const Doubles S = polynomial(z, -0x1.5555555555549p-3, 0x1.111111110f881p-7, -0x1.a01a019c126dep-13,
                               0x1.71de35787689dp-19, -0x1.ae5e66d66f65fp-26, 0x1.5d932fb34aeedp-33);
  const Doubles C = polynomial(z, 0x1.555555555554cp-5, -0x1.6c16c16c15185p-10, 0x1.a01a019cb27b4p-16,
                               -0x1.27e4f80a7e4eep-22, 0x1.1ee9ec4ca2144p-29, -0x1.8faed18c29ce4p-37);
  const Doubles sine = r + (r * z * S + rest);                                           // r + r³ S
  const Doubles cosine = one_less + (((1 - one_less) - half) + (z * z * C - r * rest));  // 1 − r²/2 + r⁴ C

  // Back by n quarter turns: odd n exchange the two, the sign of either changes every other time.
  const Integers turns = reinterpret_cast<Integers>(shifted);
  Integers s = reinterpret_cast<Integers>(sine), c = reinterpret_cast<Integers>(cosine);
  const Integers exchange = (s ^ c) & -(turns & 1);
  s ^= exchange ^ ((turns & 2) << 62);
  c ^= exchange ^ (((turns + 1) & 2) << 62);
  return {reinterpret_cast<Doubles>(s), reinterpret_cast<Doubles>(c)};
}

template <class T>
void in_lanes(const T* angle, T* sine, T* cosine, int n) {
  typedef T Some __attribute__((vector_size(width * sizeof(T))));
  Integers near = ~Integers{};
  const auto some = [&](const T* from, T* to_sine, T* to_cosine) {
    Some x;
    std::memcpy(&x, from, sizeof x);
    const Doubles a = __builtin_convertvector(x, Doubles);
    near &= (a > -far) & (a < far);
    const SinCos<Doubles> both = sine_and_cosine(a);
    const Some s = __builtin_convertvector(both.sin, Some), c = __builtin_convertvector(both.cos, Some);
    std::memcpy(to_sine, &s, sizeof s), std::memcpy(to_cosine, &c, sizeof c);
  };
  int k = 0;
  for (; k + width <= n; k += width) some(angle + k, sine + k, cosine + k);
  if (k < n) {
    T x[width] = {}, s[width], c[width];
    std::copy(angle + k, angle + n, x);
    some(x, s, c);
    std::copy(s, s + (n - k), sine + k);
    std::copy(c, c + (n - k), cosine + k);
  }
  bool all_near = true;
  for (int lane = 0; lane < width; ++lane) all_near &= near[lane] != 0;
  if (all_near) return;
  for (k = 0; k < n; ++k)
    if (!(std::abs(angle[k]) < far)) sine[k] = std::sin(angle[k]), cosine[k] = std::cos(angle[k]);
}

}  // namespace

void sines_and_cosines(const double* angle, double* sine, double* cosine, int n) { in_lanes(angle, sine, cosine, n); }
void sines_and_cosines(const float* angle, float* sine, float* cosine, int n) { in_lanes(angle, sine, cosine, n); }

}  // namespace lanc
