// Private to lib/derivatives.
#pragma once

#include "lib/closure/rank.h"
#include "lib/formulation/outcome.h"

namespace lanc {

/// What the decision on the closure conditions leaves to differentiate.
Outcome closure_outcome(const ClosureDecision& decision);

}  // namespace lanc
