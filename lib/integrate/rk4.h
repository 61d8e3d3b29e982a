// Private to lib/integrate.
#pragma once

#include "lib/integrate/stepper.h"

namespace lanc {
std::unique_ptr<Stepper> create_rk4(MotionForm& form, const StepperOptions& options);
}
