// Kinetic and potential energy of a state, for laws of conservation: tests, and the drift of trajectories.
#pragma once

#include "lib/system/evaluator.h"

namespace lanc {

/// In J. Kinetic: ½ v̂ᵀ M v̂ over all bodies and ½ A q̇² of rotors (armature), those of prescribed joints included.
/// Potential: of gravity (zero at the world's origin), of joint springs and of point springs. Constant torques,
/// wrenches and loads are no part of it; their power changes the sum.
template <class S>
struct Energy {
  S kinetic{}, potential{};
  S total() const { return kinetic + potential; }
};

/// Evaluates the coefficients at the state first, so `evaluator` is left there. O(n). Scalars: double, long double,
/// Count. Tested by tests/lib/energy_test.cpp and, as power = dE/dt, by tests/contract/power_test.cpp.
template <class S>
Energy<S> energy(Evaluator<S>& evaluator, const State<S>& state);

}  // namespace lanc
