#include "lib/scalar/sines.h"

#include <algorithm>
#include <cstring>

#ifdef LANC_WITH_SLEEF
#include <sleef.h>
#endif

namespace lanc {

#ifdef LANC_WITH_SLEEF

namespace {

#if defined(__AVX512F__)
struct Doubles {
  using Vector = __m512d;
  static auto sincos(Vector x) { return Sleef_sincosd8_u10(x); }
};
struct Floats {
  using Vector = __m512;
  static auto sincos(Vector x) { return Sleef_sincosf16_u10(x); }
};
#elif defined(__AVX__)
struct Doubles {
  using Vector = __m256d;
  static auto sincos(Vector x) { return Sleef_sincosd4_u10(x); }
};
struct Floats {
  using Vector = __m256;
  static auto sincos(Vector x) { return Sleef_sincosf8_u10(x); }
};
#else
struct Doubles {
  using Vector = decltype(Sleef_sincosd2_u10({}).x);
  static auto sincos(Vector x) { return Sleef_sincosd2_u10(x); }
};
struct Floats {
  using Vector = decltype(Sleef_sincosf4_u10({}).x);
  static auto sincos(Vector x) { return Sleef_sincosf4_u10(x); }
};
#endif

template <class Lanes, class T>
void in_lanes(const T* angle, T* sine, T* cosine, int n) {
  using Vector = typename Lanes::Vector;
  constexpr int width = sizeof(Vector) / sizeof(T);
  const auto some = [&](const T* x, T* s, T* c) {
    Vector v;
    std::memcpy(&v, x, sizeof v);
    const auto both = Lanes::sincos(v);
    std::memcpy(s, &both.x, sizeof v);
    std::memcpy(c, &both.y, sizeof v);
  };
  int k = 0;
  for (; k + width <= n; k += width) some(angle + k, sine + k, cosine + k);
  if (k == n) return;
  T x[width] = {}, s[width], c[width];
  std::copy(angle + k, angle + n, x);
  some(x, s, c);
  std::copy(s, s + (n - k), sine + k);
  std::copy(c, c + (n - k), cosine + k);
}

}  // namespace

void sines_and_cosines(const double* angle, double* sine, double* cosine, int n) {
  in_lanes<Doubles>(angle, sine, cosine, n);
}
void sines_and_cosines(const float* angle, float* sine, float* cosine, int n) {
  in_lanes<Floats>(angle, sine, cosine, n);
}

#else

void sines_and_cosines(const double* angle, double* sine, double* cosine, int n) {
  sines_and_cosines<double>(angle, sine, cosine, n);
}
void sines_and_cosines(const float* angle, float* sine, float* cosine, int n) {
  sines_and_cosines<float>(angle, sine, cosine, n);
}

#endif

}  // namespace lanc
