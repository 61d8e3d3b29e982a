// Derivatives of forward dynamics: ∂η̇/∂q, ∂η̇/∂η, ∂η̇/∂τ of open and closed mechanisms.
#pragma once

#include <memory>
#include <vector>

#include "lib/closure/rank.h"
#include "lib/formulation/outcome.h"
#include "lib/system/evaluator.h"

namespace lanc {

struct CoordinateOrder;
class Differentiator;
class InverseDynamicsDerivatives;
class MassInverse;
class PairDerivatives;

/// Matrices row after row, SI units; rows: velocity coordinates (η̇) or closure rows (λ). Columns of `position`:
/// derivatives along q̇ = H(q) e_k (eq. 1), so that every joint has as many as it has velocities, those with Euler
/// parameters, too: for them a turn of the successor about its own axis k. `force` is M̄⁻¹ on a tree; with closures the
/// part of it that keeps the conditions; symmetric.
///
/// Closed loops: the answer of M̄ η̇ − Gᵀλ = b, G η̇ + γ̿ = 0 with a fixed set of independent rows (ClosureDecision) and
/// multipliers of these alone. Derivatives are those of these equations, off the conditions, too; along motions that
/// keep the conditions (q̇ = H w with G w = 0, and the change of η that keeps G η + γ̄ = 0) they are those of the
/// mechanism, whatever rows were chosen.
struct ForwardDerivatives {
  std::vector<double> position, velocity, force;                                   // nv × nv
  std::vector<int> independent;                                                    // the closure rows
  std::vector<double> multiplier_position, multiplier_velocity, multiplier_force;  // of their λ: as many rows × nv
};

/// By the analytic recursion of inverse_dynamics_derivatives.h: ∂η̇ = −M̄⁻¹ ∂r, r = M̄ η̇ − b − Gᵀλ. On a tree O(nv²)
/// for ∂r and M̄⁻¹, and two products of nv × nv matrices, which take most of the time from some 50 velocities on; closed
/// loops with m independent rows add O(m nv²). Bound to a model; allocates here and never again, but for closures the
/// decision on their rank, and Eigen's scratch for products above 128 KiB.
/// Tested by tests/derivatives/forward_derivatives_test.cpp.
class AnalyticDerivatives {
 public:
  explicit AnalyticDerivatives(const Model& model);
  ~AnalyticDerivatives();

  /// At the evaluator's last state: `system` is what it returned for state and loads, `solution` the answer of any
  /// formulation there (η̇, â, f̂, λ). Status, beside `solved` and `redundant`:
  ///   objection     M̄ of the tree that is left without its loops is singular, or nearly so compared with the whole:
  ///                 the derivatives are made by its inverse. DualDerivatives does without
  ///   singular      the rank of the closure conditions changes here, so that η̇ has no derivative
  ///   inconsistent  the state violates the closure conditions, unless the rank is given
  ///   not_finite    some derivative is not: two ends of a spring meet, say
  /// forward_error, where loops are closed: what rounding of M̄⁻¹ leaves in ∂η̇/∂τ, relative.
  Outcome at(Evaluator<double>& evaluator, const System<double>& system, const State<double>& state,
             const Loads<double>& loads, const Solution<double>& solution, RankPolicy policy = {});

  /// Of the last at() that was usable.
  const ForwardDerivatives& derivatives() const { return result_; }

 private:
  class Loops;
  Model model_;
  std::unique_ptr<CoordinateOrder> order_;
  std::unique_ptr<InverseDynamicsDerivatives> dynamics_;
  std::unique_ptr<MassInverse> mass_inverse_;
  std::unique_ptr<PairDerivatives> pairs_;
  std::unique_ptr<Loops> loops_;  // where loops are closed
  ForwardDerivatives result_;
};

/// The same by dual numbers through inverse dynamics, and LU factors of [M̄ −Gᵀ; G 0]: nothing in common with
/// AnalyticDerivatives but the evaluator and the choice of rows. O((nq + nv) n) passes over the bodies and O(nv³).
class DualDerivatives {
 public:
  DualDerivatives(const Model& model, const Loads<double>& loads);
  ~DualDerivatives();

  /// As AnalyticDerivatives::at, under the loads of the constructor; `singular` where [M̄ −Gᵀ; G 0] is.
  Outcome at(const System<double>& system, const State<double>& state, const Solution<double>& solution,
             RankPolicy policy = {});

  const ForwardDerivatives& derivatives() const { return result_; }

 private:
  Model model_;
  std::unique_ptr<Differentiator> differentiator_;
  std::unique_ptr<ClosureRank<double>> rank_;
  ForwardDerivatives result_;
};

}  // namespace lanc
