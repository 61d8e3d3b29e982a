// Rheonomic joints: the motion of a one-freedom joint prescribed in time (theory, eq. 5-10).
#pragma once

#include <memory>
#include <string>
#include <variant>
#include <vector>

namespace lanc {

/// Value and its first two derivatives with respect to time.
struct MotionSample {
  double position = 0, velocity = 0, acceleration = 0;  // rad or m, and per s, per s²
};

/// start + rate t.
struct ConstantSpeed {
  double start = 0, rate = 0;
};
/// Σ coefficients[k] tᵏ.
struct Polynomial {
  std::vector<double> coefficients;
};
/// offset + amplitude sin(frequency t + phase), frequency in rad/s.
struct Sine {
  double offset = 0, amplitude = 0, frequency = 0, phase = 0;
};
/// Cubic spline (twice continuously differentiable) through (times, values); not finite outside the table.
struct SplineTable {
  std::vector<double> times, values;
};
/// A formula in t, for example "0.3*sin(2*t) + t^2"; differentiated exactly (lib/model/expression.h).
struct Formula {
  std::string text;
};

using MotionSpec = std::variant<ConstantSpeed, Polynomial, Sine, SplineTable, Formula>;

/// A prescribed motion, ready to be evaluated.
class PrescribedMotion {
 public:
  virtual ~PrescribedMotion() = default;
  /// Not a number where the motion is not defined (outside a table, a formula's pole); callers get status `not_finite`.
  virtual MotionSample at(double t) const = 0;

  /// Throws InputError with the mend when the specification cannot be used. Tested by tests/lib/motion_test.cpp.
  static std::shared_ptr<const PrescribedMotion> create(const MotionSpec& spec);
};

}  // namespace lanc
