// A motion as the integrators see it: numbers y(t) with a rate ẏ(t, y), and how they are made of a mechanism's state.
#pragma once

#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "lib/closure/explicit.h"
#include "lib/formulation/outcome.h"
#include "lib/model/model.h"

namespace lanc {

/// Where a motion is: the state, and the work that drives, loads, dampers and friction have done on the mechanism.
struct MotionPoint {
  State<double> state;
  double work = 0;  // J
};

/// What became of an evaluation. `retry`: nearer to where the step began it may succeed.
enum class Evaluation : unsigned char { fine, retry, stop };

/// What settling did to y: brought it back, made it mean something else (other independent coordinates), or failed.
enum class Settled : unsigned char { kept, renewed, failed };

/// How often what was called, for comparisons of cost that do not depend on the machine.
struct MotionCounts {
  long rates = 0;            // η̇ by a formulation, or residuals of eq. 3, 8, 12
  long jacobians = 0;        // derivatives of these
  long kinematics = 0;       // passes over all joints, those on dual numbers included
  long dual_kinematics = 0;  // of these, those on dual numbers

  void add_derivatives(int passes) { ++jacobians, kinematics += passes, dual_kinematics += passes; }
};

/// One way to write the equations of motion as numbers. Bound to a model; keeps history (the rank, chosen coordinates).
class MotionForm {
 public:
  virtual ~MotionForm() = default;
  virtual int size() const = 0;
  virtual void pack(const MotionPoint& point, double* y) const = 0;
  /// Euler parameters come out normalised (eq. 2).
  virtual MotionPoint unpack(double t, const double* y) const = 0;
  /// What one unit of tolerance means for each number: lengths in the model's length.
  virtual const std::vector<double>& scale() const = 0;

  /// Of forms that choose independent velocities: the condition of G^d for the present choice, the choice, and what
  /// was changed so far.
  virtual double condition() const { return std::numeric_limits<double>::quiet_NaN(); }
  virtual std::vector<int> independent() const { return {}; }
  virtual std::span<const IndependentChange> changes() const { return {}; }

  /// Why the last evaluation was not fine.
  const Outcome& outcome() const { return outcome_; }

 protected:
  Outcome outcome_;
};

/// ẏ = f(t, y).
class OdeForm : public MotionForm {
 public:
  virtual Evaluation rate(double t, const double* y, double* ydot) = 0;
  /// ∂f/∂y, column after column, exact to rounding (dual numbers, no differences).
  virtual Evaluation jacobian(double t, const double* y, double* J) = 0;
  /// After each step: y as the next one should begin with it, Euler parameters on eq. 2, and on the closure conditions
  /// where that is the stabilisation. Methods with memory do without it unless it is `renewed`.
  virtual Settled settle(double t, std::span<double> y) = 0;
};

}  // namespace lanc
