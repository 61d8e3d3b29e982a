// Sines and cosines of many angles at once.
#pragma once

#include "lib/scalar/scalar.h"

namespace lanc {

/// Sine and cosine of one angle.
template <class S>
struct SinCos {
  S sin, cos;
};

template <class S>
inline SinCos<S> sine_and_cosine(const S& angle) {
  return {sin(angle), cos(angle)};
}

/// sine[k] and cosine[k] of angle[k] (rad) for k < n.
template <class S>
inline void sines_and_cosines(const S* angle, S* sine, S* cosine, int n) {
  for (int k = 0; k < n; ++k) sine[k] = sin(angle[k]), cosine[k] = cos(angle[k]);
}
/// To one unit in the last place (0.9 at worst, with fused multiply-add 0.84), several at once. NaN and infinity give
/// NaN. Tested by tests/lib/pack_test.cpp.
void sines_and_cosines(const double* angle, double* sine, double* cosine, int n);
void sines_and_cosines(const float* angle, float* sine, float* cosine, int n);

}  // namespace lanc
