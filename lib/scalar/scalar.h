// What a scalar must offer, and nothing more.
//
// Kinematics and the formulations are templates on a scalar S. Code on S uses + − × ÷ sin cos sqrt and no comparison,
// so that a pack of SIMD lanes or a dual number can take S's place. Scalars offered today: double, long double, Count;
// Dual<8> for kinematics and the equations row by row; Pack for kinematics and the recursion.
#pragma once

#include <cmath>
#include <string_view>

#include "lib/scalar/count.h"
#include "lib/scalar/dual.h"

namespace lanc {

using std::cos;
using std::sin;
using std::sqrt;

/// The value as double, for outcomes and reports. An overload for a pack of lanes would name the lane.
inline double to_double(double x) { return x; }
inline double to_double(long double x) { return static_cast<double>(x); }
inline double to_double(Count x) { return x.value(); }
template <int N>
double to_double(const Dual<N>& x) {
  return x.value;
}

template <class S>
constexpr std::string_view scalar_name();
template <>
constexpr std::string_view scalar_name<double>() {
  return "double";
}
template <>
constexpr std::string_view scalar_name<long double>() {
  return "long double";
}
template <>
constexpr std::string_view scalar_name<Count>() {
  return "count";
}

}  // namespace lanc
