// Are the coefficients of eq. 14 numbers one can compute with, and if not, whose fault is it?
#pragma once

#include <string>

#include "lib/system/system.h"

namespace lanc {

/// Coefficients and loads are numbers, and small enough (1e100) for their products to be ones. O(n).
template <class S>
bool finite(const System<S>& system);

/// What makes them unusable, in words that name the joint, motion, body, spring or coordinate and the mend; nothing
/// when they are finite. O(n), allocates. Tested by tests/lib/finite_test.cpp.
template <class S>
std::string not_finite_because(const System<S>& system);

}  // namespace lanc
