// In place of sundials_integrators.cpp and what it calls, where lanc is built without SUNDIALS.
#include "lib/integrate/sundials_integrators.h"

namespace lanc {
std::vector<IntegratorInfo> sundials_integrators() { return {}; }
}  // namespace lanc
