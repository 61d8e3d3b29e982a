#include "lib/solve/dense_algebra_templates.h"

namespace lanc {

LANC_DENSE_ALGEBRA(Count)

}  // namespace lanc
