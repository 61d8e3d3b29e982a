// Formulas in t for prescribed motions, with exact first and second derivatives.
//
// Own code because no packaged library of a permissive licence differentiates exactly, and exact-arithmetic algebra
// systems can be made to hang by a short formula such as 9^9^9^9 (README, Decisions).
#pragma once

#include <array>
#include <string_view>
#include <vector>

#include "lib/model/motion.h"

namespace lanc {

/// A parsed formula: numbers, t, pi, + − * / ^ (constant exponent), parentheses, sin cos tan
/// asin acos atan exp log sqrt abs tanh.
/// Evaluated in truncated Taylor arithmetic (value and two derivatives at once). Tested by tests/lib/motion_test.cpp.
class Expression {
 public:
  /// Throws InputError with the position of the first thing that cannot be read.
  explicit Expression(std::string_view text);
  /// Value, first and second derivative; not finite at poles and outside the domain of a function.
  MotionSample at(double t) const;

 private:
  enum class Code : unsigned char {
    number,
    time,
    add,
    subtract,
    multiply,
    divide,
    power,
    negate,
    sin,
    cos,
    tan,
    asin,
    acos,
    atan,
    exp,
    log,
    sqrt,
    abs,
    tanh
  };
  struct Step {
    Code code;
    double number = 0;
  };
  class Parser;
  std::vector<Step> steps_;  // reverse Polish
  int depth_ = 0;            // of the evaluation stack
};

}  // namespace lanc
