// Derivatives of inverse dynamics on a tree by an analytic recursion.
// Private to lib/derivatives.
#pragma once

#include <vector>

#include "lib/derivatives/coordinate_order.h"
#include "lib/derivatives/six_rows.h"
#include "lib/derivatives/turned_vectors.h"
#include "lib/system/evaluator.h"

namespace lanc {

/// Joints with Euler parameters: their columns are fixed in the successor, and none moves another. Of all other kinds
/// a column moves with the freedoms before it in the joint, as if these were joints of their own.
inline bool moves_as_one(const Link& link) { return link.kind.traits().quaternion >= 0; }

/// ∂r/∂q and ∂r/∂η of r = Cᵀ f̂ + A η̇ − τ at constant η̇: Carpentier & Mansard 2018 ("Analytical derivatives of rigid
/// body dynamics algorithms"), in the form of Singh, Russell & Wensing 2022 ("Efficient analytical derivatives of
/// rigid-body dynamics using spatial vector algebra"); here in world axes, each body about its own reference point. A
/// q-derivative is one along q̇ = H(q) e_k (eq. 1): column k belongs to velocity coordinate k.
///
/// Direction k, of joint j on the body p, moves all that body j carries as one rigid body, by the twist C_k. Seen from
/// there (δ′x = δx − C_k × x) columns, inertias and the joints' velocities stay, and for every body i carried, with
/// the spatial acceleration A = [ω̇; v̇ − ω × v − g],
///   δ′v̂_i = Ψ̇_k,                 Ψ̇_k = v̂_p × C_k        (v̂_p, A_p at j's reference point)
///   δ′A_i = Ψ̈_k − v̂_i × Ψ̇_k,     Ψ̈_k = A_p × C_k + v̂_p × Ψ̇_k.
/// A velocity η_k does the same with C_k for Ψ̇_k and Ψ̇_k + Ċ_k for Ψ̈_k. A body's force M A + v̂ ×* M v̂ changes by
/// M Ψ̈ + 2 K(Ψ̇) with the Coriolis forces 2 K(s) = ∫ [ρ; 1] × 2 (s × u) dm of its points' velocities u, which only
/// the angular part s of Ψ̇ enters (TurnedVectors). Wrenches with directions fixed in the world turn back: + W(s).
/// With M, K, W summed over all that a joint carries (composite, leaf to root) and f̂ its wrench:
///   body i carried by j:   ∂r_i/∂q_k = (M_i C_i)·Ψ̈_k + (2 K_iᵀ C_i)·Ψ̇_k + (W_iᵀ C_i)·s_k
///   i further inward:      ∂r_i/∂q_k = C_i · [M_j Ψ̈_k + 2 K_j Ψ̇_k + W_j s_k + C_k ×* f̂_j]
/// so M_i C_i, 2 K_iᵀ C_i and the brackets travel towards the root, and meet there each joint's C, Ψ̇ and Ψ̈ once: 45
/// multiplications a pair of coordinates. Joints of several freedoms are chains of massless ones, but those with Euler
/// parameters, whose columns are fixed in the successor: they move as one. O(nv · depth), in vectors over coordinates.
///
/// Springs and closures between two bodies are left to pair_derivatives.h. Allocates in the constructor only. Tested by
/// tests/derivatives/.
class InverseDynamicsDerivatives {
 public:
  InverseDynamicsDerivatives(const Model& model, const CoordinateOrder& order);

  /// What the directions of a velocity coordinate do to the body of its joint and all it carries.
  struct Direction {
    Motion<double> C, velocity, acceleration, rate;  // C_k, Ψ̇_k, Ψ̈_k, Ψ̇_k + Ċ_k
  };

  /// At the evaluator's last state. solution: an answer there, with joint wrenches as if nothing acted between two
  /// bodies (PairDerivatives::without_pairs).
  void evaluate(Evaluator<double>& evaluator, const System<double>& system, const State<double>& state,
                const Loads<double>& loads, const Solution<double>& solution);

  std::vector<double> position, velocity;  // ∂r/∂q and ∂r/∂η, nv × nv, row after row
  const Direction& direction(int k) const { return directions_[k]; }

 private:
  struct Carried {  // sums over a body and all it carries, about its reference point
    RigidInertia<double> inertia;
    TurnedVectors momenta, loads;
  };
  void outward(Evaluator<double>& evaluator, const System<double>& system, const State<double>& state,
               const Solution<double>& solution);
  void sum_loads(const Loads<double>& loads);
  void begin_columns(int body, const System<double>& system, const Wrench<double>& wrench);
  void meet(int k, ColumnKind kind, const Vec3<double>& arm, int end);
  void turn_wrench(int k, const Wrench<double>& wrench);
  SixRows columns() { return {columns_.data(), padded(model_.nv())}; }
  void add_passive(const State<double>& state);

  Model model_;
  const CoordinateOrder& order_;
  bool loaded_ = false;
  std::vector<Direction> directions_;
  std::vector<Motion<double>> spatial_acceleration_;
  std::vector<Carried> carried_;
  AlignedRows columns_, met_;  // what travels, and what one coordinate got: rows of nv numbers
};

}  // namespace lanc
