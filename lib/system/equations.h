// Eq. 14 used row by row: accelerations outward (8), wrenches inward (3), and the residual of any solution.
#pragma once

#include "lib/system/system.h"

namespace lanc {

/// â from η̇ by eq. 8, root to leaf. O(n).
template <class S>
void accelerations(const System<S>& system, const RightHandSide<S>& rhs, Solution<S>& solution);

/// ā, the accelerations at η̇ = 0 (eq. 10), into solution.acceleration. O(n).
template <class S>
void bias_accelerations(const System<S>& system, const RightHandSide<S>& rhs, Solution<S>& solution);

/// f̂ from â and λ by eq. 3 with (4), leaf to root. O(n).
template <class S>
void wrenches(const System<S>& system, const RightHandSide<S>& rhs, Solution<S>& solution);

/// Both: â at these η̇ and under these λ, and the f̂ that go with it, in two sweeps. O(n).
template <class S>
void newton_euler(const System<S>& system, const RightHandSide<S>& rhs, Solution<S>& solution);

/// The same at η̇ = 0 and λ = 0: ā, and what the joints then have to bear.
template <class S>
void newton_euler_at_rest(const System<S>& system, const RightHandSide<S>& rhs, Solution<S>& solution);

/// Adds what multipliers λ do, G_sᵀ λ on bodies and G_ηᵀ λ on velocities, to the loads of eq. 14.
template <class S>
void add_closure_reactions(const System<S>& system, const std::vector<S>& lambda, RightHandSide<S>& rhs);

/// G_s â + G_η η̇ + γ̿ of every closure row: zero for a solution.
template <class S>
void closure_accelerations(const System<S>& system, const RightHandSide<S>& rhs, const Solution<S>& solution,
                           std::vector<S>& result);

/// Forces of the prescribed freedoms from f̂.
template <class S>
void drive_forces(const System<S>& system, Solution<S>& solution);

/// Inverse dynamics: the τ beyond the passive forces in rhs.tau that makes solution.vdot the answer under the
/// multipliers solution.lambda. Fills â, f̂ and the drive forces, too. O(n).
template <class S>
void inverse_dynamics(const System<S>& system, Solution<S>& solution, std::vector<S>& tau);

/// Right-hand side minus left-hand side of eq. 14: (3), (8) with the sign of ā^rel, (12); of the closure rows the
/// accelerations that are left. The answer to the residual as right-hand side is the correction of the solution. O(n).
template <class S>
void residual(const System<S>& system, const RightHandSide<S>& rhs, const Solution<S>& solution,
              RightHandSide<S>& result);

/// Componentwise (Oettli-Prager) backward error of eq. 14: the smallest ε such that the solution solves a system whose
/// every coefficient and load differs by at most the fraction ε: max over rows of |residual| / (|A||x| + |b|), rows
/// made of rounding errors alone being compared with ‖A_row‖ ‖x‖ (Arioli, Demmel & Duff 1989). `normwise` is
/// ‖residual‖∞ / (‖A‖∞ ‖x‖∞ + ‖b‖∞). NaN when something is not finite.
struct BackwardError {
  double componentwise = 0, normwise = 0;
};
template <class S>
BackwardError backward_error(const System<S>& system, const Solution<S>& solution);

}  // namespace lanc
