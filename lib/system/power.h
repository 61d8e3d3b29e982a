// What puts energy into a mechanism or takes it out: the rate of T + V along a solution.
#pragma once

#include "lib/system/evaluator.h"

namespace lanc {

/// In W. Energy as in lib/system/energy.h: gravity, springs and rotors are in it, all else does work on it.
struct Power {
  double drives = 0;      // of prescribed joints, closures and couplers
  double loads = 0;       // constant torques and wrenches, τ and wrenches applied
  double dissipated = 0;  // dampers and friction: ≤ 0
  double total() const { return drives + loads + dissipated; }
};

/// At the state `evaluator` was left at by system(state, loads), for the solution there. Multipliers of conditions that
/// the state violates count with the prescribed rates, so that what drift costs shows in the balance. O(n).
/// Tested by tests/integrate/simulation_test.cpp, as the balance of energy on every model of data/models.
Power power(Evaluator<double>& evaluator, const System<double>& system, const State<double>& state,
            const Loads<double>& loads, const Solution<double>& solution);

}  // namespace lanc
