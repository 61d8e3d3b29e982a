// The one place that says how near is near enough.
//
// Every numerical comparison of the tests is |error| <= c · ε · size · ‖reference‖ with c below. The environment
// variable LANC_TOLERANCE_SCALE multiplies all of them; 0 accepts everything and prints each residual instead, so that
// one sees how much of its tolerance every check uses.
#pragma once

#include <gtest/gtest.h>

#include <string>

namespace lanc::test {

/// c. Rounding errors of a recursion over `size` bodies stay below this many ε · size · ‖reference‖ unless the
/// mechanism is ill-conditioned; a wrong sign or a missing term is 12 decades away.
constexpr double safety = 4096;

/// ε of the arithmetic under test.
constexpr double epsilon = 2.220446049250313e-16;

/// LANC_TOLERANCE_SCALE, 1 if it is not set.
double tolerance_scale();

/// |error| <= scale · c · ε · size · norm; NaN never passes. The message tells the error in units of the tolerance.
::testing::AssertionResult within(const std::string& what, double error, double size, double norm);

/// The same with a relative tolerance of its own: truncation errors of finite differences, digits of a printed number,
/// a figure of the specification.
::testing::AssertionResult within_relative(const std::string& what, double error, double relative, double norm);

}  // namespace lanc::test
