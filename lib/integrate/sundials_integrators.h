// The integrators that SUNDIALS brings, or none.
// Private to lib/integrate.
#pragma once

#include "lib/integrate/stepper.h"

namespace lanc {
std::vector<IntegratorInfo> sundials_integrators();
}
