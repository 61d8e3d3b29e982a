// Through a configuration in which branches of motion cross, on the branch that the user names.
// Private to lib/integrate.
#pragma once

#include <optional>

#include "lib/integrate/motion_solver.h"

namespace lanc {

/// Where a motion goes on after a crossing of branches.
struct BranchStart {
  State<double> state;       // a little way behind the crossing, consistent
  double crossing = 0;       // s, when it was passed
  double energy_change = 0;  // J, of the velocities' jump onto the tangent: 0 for the branch that goes straight on
  int branches = 0;          // that cross there
};

/// `near`: a state next to the crossing, with the velocities there. `choice` counts the branches from 1 by how well
/// their tangents go on with these velocities, the straightest first. The velocities jump to the chosen tangent as in
/// an impact without loss along it: their part along it in the kinetic-energy metric is kept. The way behind the
/// crossing, 1e-3 in scaled velocities, is gone at the speed that energy prescribes. For mechanisms with one freedom in
/// which one more rank is lost; nothing where branches do not cross like that, or there are fewer.
std::optional<BranchStart> choose_branch(MotionSolver& solver, const State<double>& near, int choice);

}  // namespace lanc
