// Small motions about a state, in independent coordinates, and states of rest.
#pragma once

#include <complex>
#include <string>
#include <vector>

#include "lib/formulation/outcome.h"
#include "lib/model/model.h"

namespace lanc {

/// M δs̈ + C δṡ + K δs = 0 for departures δs from the motion through a state, row after row, f × f. Coordinates are the
/// independent velocities, integrated; of joints with Euler parameters small rotations about body axes.
struct LinearisedMotion {
  std::vector<int> independent;                   // velocities
  std::vector<double> M, C, K;                    // kg m², kg m, kg and per s, per s²
  std::vector<std::complex<double>> eigenvalues;  // 1/s, by imaginary, then real part; infinite ones left out
  double condition = 1;                           // of G^d
  std::vector<double> vdot;                       // η̇ of the motion itself, all velocities; zero at rest
};

/// By exact derivatives (dual numbers) of the equations of motion, closure conditions eliminated; multipliers by the
/// recursive formulation. `chosen`: the independent velocities; empty: the best. The state must be consistent.
/// An outcome other than solved and redundant says why there is no answer. O(nv³). Tested by
/// tests/integrate/linearise_test.cpp.
Outcome linearise(const Model& model, const State<double>& state, const std::vector<int>& chosen,
                  LinearisedMotion& result);

struct EquilibriumOptions {
  bool stable = false;  // seek a minimum of the potential: directions of negative stiffness are followed downwards
  int steps = 200;
};

/// The state at rest near `state` (velocities zero) in which all generalized forces balance, closed loops assembled.
/// Newton's method with exact stiffness, steps at most a fifth of a radian or of the model's length; with `stable`
/// along the eigenvectors of the stiffness, each downhill. Accepted at 1e-12 of the forces at work. Not converged:
/// says what is left. Tested by tests/integrate/linearise_test.cpp.
Outcome equilibrium(const Model& model, State<double>& state, const EquilibriumOptions& options = {});

}  // namespace lanc
