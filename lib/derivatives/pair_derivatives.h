// Derivatives of what acts between two bodies: point springs, closure reactions and closure accelerations.
// Private to lib/derivatives.
#pragma once

#include <vector>

#include "lib/derivatives/inverse_dynamics_derivatives.h"

namespace lanc {

/// What a spring or a closure does depends on poses and twists of its two bodies: differentiated by dual numbers in
/// these 24 directions, pair by pair, and taken to the coordinates by the bodies' own motions. A displacement C_k of
/// body a, with twist v̂ = [ω; v], acceleration â = [ω̇; a] and s the angular part of C_k, changes, at a's reference
/// point as it moves along,
///   along q_k:  v̂ by [s × ω + Ψ̇ᵃ; s × v + Ψ̇ˡ],  â by [s × ω̇ + Ψ̈ᵃ − ω × Ψ̇ᵃ; s × a + Ψ̈ˡ + 2 Ψ̇ᵃ × v]
///   along η_k:  v̂ by C_k,                          â by [Ċᵃ + Ψ̇ᵃ − ω × s; Ċˡ + Ψ̇ˡ + 2 s × v]
/// (ᵃ, ˡ: angular and linear part, Ψ̈ without gravity). Coordinates that carry both bodies change nothing between
/// them: only those on the loop count. O(bodies + pairs + Σ loop²). Allocates in the constructor only.
class PairDerivatives {
 public:
  explicit PairDerivatives(const Model& model);

  bool any() const { return !springs_.empty() || !closures_.empty(); }
  /// The answer with joint wrenches as if nothing acted between two bodies: what `dynamics` below has to start from.
  const Solution<double>& without_pairs(Evaluator<double>& evaluator, const System<double>& system,
                                        const Solution<double>& solution);

  /// Of springs, to the derivatives of r in `dynamics`.
  void add_springs(const Evaluator<double>& evaluator, InverseDynamicsDerivatives& dynamics);
  /// Of −Gᵀλ, to the derivatives of r in `dynamics`; and into `position` and
  /// `velocity`, rows × nv column after column, those of G η̇ + γ̿ at the constant η̇ of the answer.
  void add_closures(const Evaluator<double>& evaluator, const System<double>& system, double t,
                    const Solution<double>& solution, const std::vector<double>& lambda,
                    InverseDynamicsDerivatives& dynamics, std::vector<double>& position, std::vector<double>& velocity);

 private:
  enum Side { on_a, on_b };
  /// A coordinate on the loop, on the way from one of the bodies inward. Motions at this body's reference point.
  struct Step {
    int k;
    Side side;
    bool as_one;                                  // with the other freedoms of its joint
    Motion<double> C, twist;                      // displacement, and change of v̂ along q_k
    Motion<double> acceleration, acceleration_v;  // changes of â along q_k and η_k
    WrenchPair<double> wrench, wrench_v;          // changes of the pair's wrenches along q_k and η_k
  };
  struct Pair {
    int body_a, body_b, begin, end;  // its steps
  };
  /// Derivatives in the 24 directions: of each body 6 displacements, then 6 changes of its twist.
  struct Sensitivity;

  Pair add_pair(int body_a, int body_b);
  void walk(const Pair& pair, const Evaluator<double>& evaluator, const InverseDynamicsDerivatives& dynamics,
            const Solution<double>* solution);
  void add_wrenches(const Pair& pair, const Sensitivity& sensitivity, InverseDynamicsDerivatives& dynamics);
  void add_rows(const Pair& pair, const Sensitivity& sensitivity, const Closure& closure, const System<double>& system,
                std::vector<double>& position, std::vector<double>& velocity) const;

  Model model_;
  std::vector<Pair> springs_, closures_;
  std::vector<Step> steps_;
  RightHandSide<double> rhs_;
  Solution<double> alone_;
};

}  // namespace lanc
