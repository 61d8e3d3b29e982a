// Runge-Kutta methods of SUNDIALS' ARKODE.
// Private to lib/integrate.
#pragma once

#include "lib/integrate/stepper.h"

namespace lanc {
std::unique_ptr<Stepper> create_erk5(MotionForm& form, const StepperOptions& options);
std::unique_ptr<Stepper> create_erk6(MotionForm& form, const StepperOptions& options);
std::unique_ptr<Stepper> create_erk8(MotionForm& form, const StepperOptions& options);
std::unique_ptr<Stepper> create_dirk(MotionForm& form, const StepperOptions& options);
}  // namespace lanc
