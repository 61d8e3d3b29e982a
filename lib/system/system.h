// The coefficients of eq. 14 at one instant, and its solution.
//
//   [  M   −Bᵀ   0 ] [ â ]   [ f̂^tc  ]        (3) with (4): momentum balance of all bodies
//   [ −B    0    C ] [ f̂ ] = [ −ā^rel ]       (8): accelerations across the joints
//   [  0    Cᵀ   A ] [ η̇ ]   [  τ     ]        (12) with drives; A is the armature
//
// With closed loops (theory, section 4) a block row and column more:
//
//   [  M    −Bᵀ   0    −G_sᵀ ] [ â ]   [ f̂^tc  ]
//   [ −B     0    C     0    ] [ f̂ ] = [ −ā^rel ]
//   [  0     Cᵀ   A    −G_ηᵀ ] [ η̇ ]   [  τ     ]
//   [ −G_s   0   −G_η   0    ] [ λ ]   [  γ̿     ]   closures act on bodies (G_s), couplers on velocities (G_η)
//
// Conventions: SI; world axes; reference point of a body = origin of its joint's frame on the body; â is the true
// acceleration d/dt [ω; v]; gravity is a load in f̂^tc; f̂_i acts on body i from its parent.
#pragma once

#include <vector>

#include "lib/model/model.h"

namespace lanc {

/// The right-hand side of eq. 14.
template <class S>
struct RightHandSide {
  std::vector<Wrench<S>> force;  // f̂^tc per body: applied (gravity, springs, wrenches) and gyroscopic
  std::vector<Motion<S>> bias;   // ā^rel per body: velocity products and prescribed accelerations
  std::vector<S> tau;            // τ per velocity coordinate
  std::vector<S> closure;        // γ̿ per closure row: G_s â + G_η η̇ + γ̿ = 0

  RightHandSide() = default;
  explicit RightHandSide(const Model& model)
      : force(model.bodies()), bias(model.bodies()), tau(model.nv()), closure(model.closures().rows()) {}

  void set_zero() {
    const S o(0.0);
    const Vec3<S> none{o, o, o};
    for (Wrench<S>& f : force) f = {none, none};
    for (Motion<S>& a : bias) a = {none, none};
    for (S& t : tau) t = o;
    for (S& c : closure) c = o;
  }
};

/// Everything eq. 14 is made of. Written by Evaluator only; the structure (parents, column kinds) is that of the model.
template <class S>
struct System {
  struct Body {
    Vec3<S> r;                // from the parent's to this body's reference point; defines B_ip
    RigidInertia<S> inertia;  // M_i
  };
  /// One closure condition g = 0 (rows of couplers have g and ġ only; their G_η is in the model).
  struct ClosureRow {
    Wrench<S> a, b;  // rows of G_a and G_b: what a unit multiplier does to the bodies, about their reference points
    S g;             // m, or a pure number
    S rate;          // ġ = Gη + γ̄ at the velocities of the state
  };
  Model model;
  std::vector<Body> bodies;
  std::vector<Motion<S>> columns;  // C_i, one per velocity coordinate
  RightHandSide<S> rhs;
  // Prescribed freedoms: their columns, and the passive torque and rotor inertia force the drive has to overcome
  // besides f̂.
  std::vector<Motion<S>> drive_columns;
  std::vector<S> drive_load;  // drive force = C_dᵀ f̂ + drive_load
  std::vector<ClosureRow> closure_rows;
  State<S> state;  // where this was evaluated; kept where loops are closed, for the decision on their rank

  explicit System(const Model& m)
      : model(m),
        bodies(m.bodies()),
        columns(m.nv()),
        rhs(m),
        drive_columns(m.drives()),
        drive_load(m.drives()),
        closure_rows(m.closures().rows()) {}
};

/// The lecture's whole task: η̇, every â_i, every joint wrench f̂_i, and the forces of prescribed freedoms.
template <class S>
struct Solution {
  std::vector<S> vdot;                  // η̇
  std::vector<Motion<S>> acceleration;  // â
  std::vector<Wrench<S>> wrench;        // f̂
  std::vector<S> drive_force;
  std::vector<S> lambda;  // λ per closure row: N where the row is a length, N m where it is an angle

  Solution() = default;
  explicit Solution(const Model& m)
      : vdot(m.nv()),
        acceleration(m.bodies()),
        wrench(m.bodies()),
        drive_force(m.drives()),
        lambda(m.closures().rows()) {}
};

}  // namespace lanc
