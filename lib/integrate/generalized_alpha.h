// Private to lib/integrate.
#pragma once

#include "lib/integrate/stepper.h"

namespace lanc {
std::unique_ptr<Stepper> create_generalized_alpha(MotionForm& form, const StepperOptions& options);
}
