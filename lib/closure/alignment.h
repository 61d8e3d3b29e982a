// Flipped loops: closure conditions hold, but half a turn away from where the joint is.
#pragma once

#include <vector>

#include "lib/system/evaluator.h"

namespace lanc {

/// Indices of the closures whose frames stand the wrong way round at the state last evaluated: an axis that ought to be
/// aligned points against its partner (Conditions::aligned), or a screw is half a turn out of its thread. O(closures).
/// Tested by tests/lib/assembly_test.cpp.
std::vector<int> flipped_closures(const Model& model, double t, const Evaluator<double>& evaluator,
                                  const std::vector<Vec3<double>>& positions);

}  // namespace lanc
