// Differential-algebraic equations by SUNDIALS' IDA.
// Private to lib/integrate.
#pragma once

#include "lib/integrate/stepper.h"

namespace lanc {
std::unique_ptr<Stepper> create_ida(MotionForm& form, const StepperOptions& options);
}
