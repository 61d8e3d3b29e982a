// Lets Eigen's dense and sparse decompositions run on Count, so that their operations are counted, too.
#pragma once

#include <Eigen/Core>

#include "lib/scalar/count.h"

namespace lanc {
// what Eigen looks up by argument-dependent lookup on a real scalar
inline Count conj(Count a) { return a; }
inline Count real(Count a) { return a; }
inline Count imag(Count) { return 0.0; }
inline Count abs2(Count a) { return a * a; }
inline bool isfinite(Count a) { return std::isfinite(a.value()); }
}  // namespace lanc

template <>
struct Eigen::NumTraits<lanc::Count> : Eigen::NumTraits<double> {
  using Real = lanc::Count;
  using NonInteger = lanc::Count;
  using Nested = lanc::Count;
  enum {
    IsComplex = 0,
    IsInteger = 0,
    IsSigned = 1,
    RequireInitialization = 1,
    ReadCost = 1,
    AddCost = 3,
    MulCost = 3
  };
  static lanc::Count epsilon() { return NumTraits<double>::epsilon(); }
  static lanc::Count dummy_precision() { return NumTraits<double>::dummy_precision(); }
  static lanc::Count highest() { return NumTraits<double>::highest(); }
  static lanc::Count lowest() { return NumTraits<double>::lowest(); }
};
