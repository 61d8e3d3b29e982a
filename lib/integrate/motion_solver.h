// Accelerations along a motion by one formulation, with the rank held, and projection on the closure conditions.
// Private to lib/integrate.
#pragma once

#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "lib/closure/scaling.h"
#include "lib/formulation/formulation.h"
#include "lib/integrate/motion_form.h"
#include "lib/system/power.h"

namespace lanc {

/// Bound to a model, a formulation and loads. The rank of the closure conditions is decided by hold() and kept: off the
/// manifold, inside a Runge-Kutta stage, redundant conditions look independent.
class MotionSolver {
 public:
  /// Throws InputError when the formulation objects to the model.
  MotionSolver(const Model& model, const FormulationInfo& formulation, Loads<double> loads);

  /// Decides the rank at a state, which is then held. With `through_singular`, singular values below
  /// `clear_singular_value` count as zero from now on, and a singular start takes the generic rank of its branch.
  Outcome hold(const State<double>& state, bool through_singular);
  void hold(RankPolicy policy) { policy_ = policy; }
  RankPolicy policy() const { return policy_; }

  /// η̇, λ and all else at a state; with Baumgarte's term where α > 0.
  Outcome solve(const State<double>& state, double alpha = 0);
  /// Moves positions, then velocities, to the nearest (in the mass metric, by the formulation's own factors) that
  /// satisfy the closure conditions. `inconsistent` where they do not get below 1e-10.
  Outcome project(State<double>& state);
  /// Largest scaled |g| and |ġ| of the last evaluation (|ġ| relative to the largest scaled speed, or 1).
  double position_violation() const;
  double velocity_violation() const;

  /// σ_r of the held rank at the last solve(), scaled; the largest number there is without loops.
  double sigma() const { return sigma_; }
  /// Of the last solve().
  const System<double>& system() const { return *system_; }
  const Solution<double>& solution() const { return solution_; }
  Power power();
  Evaluator<double>& evaluator() { return evaluator_; }
  /// Answers of the factors of the last solve() or project().
  void respond(RightHandSide<double>& rhs, Solution<double>& answer) { formulation_->respond(*system_, rhs, answer); }

  const Model& model() const { return model_; }
  const Loads<double>& loads() const { return loads_; }
  MotionCounts& counts() { return counts_; }

 private:
  void evaluate(const State<double>& state);
  Outcome move(const std::vector<double>& violation);

  Model model_;
  Loads<double> loads_;
  Evaluator<double> evaluator_;
  ClosureScaling scaling_;
  std::unique_ptr<Formulation<double>> formulation_;
  RankPolicy policy_;
  double sigma_ = std::numeric_limits<double>::max();
  const System<double>* system_ = nullptr;
  State<double> state_;
  Solution<double> solution_, change_;
  RightHandSide<double> rhs_;
  MotionCounts counts_;
};

}  // namespace lanc
