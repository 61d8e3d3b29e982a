// Multistep methods of SUNDIALS' CVODE.
// Private to lib/integrate.
#pragma once

#include "lib/integrate/stepper.h"

namespace lanc {
std::unique_ptr<Stepper> create_adams(MotionForm& form, const StepperOptions& options);
std::unique_ptr<Stepper> create_bdf(MotionForm& form, const StepperOptions& options);
}  // namespace lanc
