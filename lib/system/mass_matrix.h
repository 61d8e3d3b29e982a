// The mass matrix M̄ = JᵀMJ (+ armature), for inspection and export; formulations form it their own way.
#pragma once

#include <vector>

#include "lib/system/system.h"

namespace lanc {

/// M̄, nv × nv, column after column: column k is the inverse dynamics of η̇ = e_k without loads and bias. O(n nv).
/// Tested by tests/cli/cli_test.cpp against eq. 14.
template <class S>
std::vector<double> mass_matrix(const System<S>& system);

/// 2-norm condition number of a symmetric matrix scaled to unit diagonal, so that units do not matter; infinite when it
/// is not positive definite. O(size³).
double equilibrated_condition(const std::vector<double>& matrix);

/// Whether M̄ has an inverse to working precision and is not positive definite. It can be so only where bodies have
/// inertias that no body has. O(n nv + nv³). Tested by tests/contract/nonphysical_test.cpp.
template <class S>
bool regular_but_indefinite(const System<S>& system);

}  // namespace lanc
