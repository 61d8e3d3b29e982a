// One step after another: the integrators, behind one interface.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "lib/integrate/motion_form.h"

namespace lanc {

struct StepperOptions {
  double tolerance = 1e-8;  // relative, and absolute in the scales of MotionForm; of methods that choose their steps
  double step = 1e-3;       // s, of methods with fixed steps
  double spectral_radius = 0.8;  // at infinite frequency, 0 to 1, of generalized-alpha
  double first_step = 0;         // s, of methods that choose theirs; 0: they find one
};

struct StepperCounts {
  long steps = 0, rejected = 0;  // rejected: by the error estimate, or because an evaluation failed
  long newton_iterations = 0;
};

/// Takes steps on a MotionForm, which must outlive it.
class Stepper {
 public:
  virtual ~Stepper() = default;

  /// Forgets everything before.
  virtual void start(double t, std::span<const double> y) = 0;
  /// One step, not beyond `limit` > t(). False when there is none; message() says why.
  virtual bool step(double limit) = 0;

  double t() const { return t_; }
  const std::vector<double>& y() const { return y_; }
  /// What the method would take for its next step; fixed steps: the step.
  virtual double next_step() const = 0;
  const StepperCounts& counts() const { return counts_; }
  const std::string& message() const { return message_; }

 protected:
  double t_ = 0;
  std::vector<double> y_;
  StepperCounts counts_;
  std::string message_;
};

/// What an integrator is, for lists, messages and the choice of a form.
struct IntegratorInfo {
  std::string_view name;  // as on the command line and in CSV files
  std::string_view idea;
  std::string_view source;
  bool fixed_step = false;
  bool implicit = false;        // needs derivatives
  bool memory = false;          // several steps: cannot be disturbed after each
  bool holds_closures = false;  // solves with the closure conditions itself, from the equations, not from η̇
  std::unique_ptr<Stepper> (*create)(MotionForm& form, const StepperOptions& options) = nullptr;
};

/// Those that were built, sorted by name: all, or without SUNDIALS those with fixed steps.
std::span<const IntegratorInfo> integrators();
/// Throws InputError with the list when there is none of that name.
const IntegratorInfo& find_integrator(std::string_view name);

}  // namespace lanc
