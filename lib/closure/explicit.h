// Explicit closure conditions: all velocities from independent ones, and the choice of these (theory, section 3).
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "lib/closure/rank.h"
#include "lib/model/model.h"
#include "lib/system/system.h"

namespace lanc {

/// η = J* s + η̄ and η̇ = J* ṡ + η̿ at one state, s the independent velocities.
struct ExplicitConditions {
  std::vector<int> independent, dependent;  // velocities, ascending; f and rank G of them
  Eigen::MatrixXd J;                        // J*, nv × f: [1; −(G^d)⁻¹ Gⁱ], so that G J* = 0
  Eigen::VectorXd eta;                      // η̄, nv: [0; −(G^d)⁻¹ γ̄]
  Eigen::VectorXd eta_bias;                 // η̿, nv: [0; −(G^d)⁻¹ γ̿]
  /// σ_max / σ_min of the scaled G^d, or the longest row of G over σ_min where that is more, so that a G^d of one small
  /// number is told, too; infinite where it is singular.
  double condition = 1;
};

/// A change of the independent velocities.
struct IndependentChange {
  double t;
  std::vector<int> before, after;
  double condition_before, condition_after;
};

struct ExplicitOptions {
  /// The independent velocities are taken from these; empty: from all.
  std::vector<int> candidates;
  /// A choice is left when the condition of its G^d exceeds `leave`, for one that is better by the factor `gain` at
  /// least: hysteresis, so that it is not changed to and fro.
  double leave = 1e3, gain = 4;
};

/// Chooses independent velocities by a QR factorisation of the scaled G with column pivoting, the pivots being the
/// dependent ones, keeps the choice while it is good, and logs each change. Bound to a model; keeps history.
/// Tested by tests/lib/explicit_test.cpp.
class ExplicitClosures {
 public:
  explicit ExplicitClosures(const Model& model, ExplicitOptions options = {});

  /// At the state of `system`, with the rows of G that the decision calls independent. Throws InputError when the
  /// candidates leave more velocities to be dependent than there are conditions.
  const ExplicitConditions& at(const System<double>& system, const ClosureDecision& decision);
  /// The choice alone, kept or changed: independent velocities for the independent rows of the scaled G at time t.
  const std::vector<int>& choice(const Eigen::MatrixXd& G, double t);
  /// Of the G^d of that choice.
  double condition() const { return conditions_.condition; }
  /// The next state starts with a choice of its own. The log is kept.
  void forget() { chosen_ = false; }
  /// The user's choice, to begin with; f velocities.
  void choose(std::vector<int> independent);
  const std::vector<IndependentChange>& changes() const { return changes_; }

 private:
  std::vector<int> best_choice(const Eigen::MatrixXd& G) const;
  double condition_of(const Eigen::MatrixXd& G, const std::vector<int>& independent) const;

  Model model_;
  ExplicitOptions options_;
  ExplicitConditions conditions_;
  std::vector<IndependentChange> changes_;
  bool chosen_ = false;
};

/// β^d(q, t): moves the dependent coordinates until g = 0 while the independent ones keep their values (19). Newton's
/// method with the rank and the split of `conditions`; nothing when it does not converge to 1e-12 (scaled) in 30 steps.
/// Where a joint has a ball, its coordinates are moved as a whole.
std::optional<State<double>> solve_dependent(const Model& model, State<double> guess,
                                             const ExplicitConditions& conditions);

}  // namespace lanc
