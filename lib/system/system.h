// The coefficients of eq. 14 at one instant, and its solution.
//
//   [  M   −Bᵀ   0 ] [ â ]   [ f̂^tc  ]        (3) with (4): momentum balance of all bodies
//   [ −B    0    C ] [ f̂ ] = [ −ā^rel ]       (8): accelerations across the joints
//   [  0    Cᵀ   A ] [ η̇ ]   [  τ     ]        (12) with drives; A is the armature
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

  RightHandSide() = default;
  explicit RightHandSide(const Model& model) : force(model.bodies()), bias(model.bodies()), tau(model.nv()) {}
};

/// Everything eq. 14 is made of. Written by Evaluator only; the structure (parents, column kinds) is that of the model.
template <class S>
struct System {
  struct Body {
    Vec3<S> r;                // from the parent's to this body's reference point; defines B_ip
    RigidInertia<S> inertia;  // M_i
  };
  Model model;
  std::vector<Body> bodies;
  std::vector<Motion<S>> columns;  // C_i, one per velocity coordinate
  RightHandSide<S> rhs;
  // Prescribed freedoms: their columns, and the passive torque and rotor inertia force the drive has to overcome
  // besides f̂.
  std::vector<Motion<S>> drive_columns;
  std::vector<S> drive_load;  // drive force = C_dᵀ f̂ + drive_load

  explicit System(const Model& m)
      : model(m), bodies(m.bodies()), columns(m.nv()), rhs(m), drive_columns(m.drives()), drive_load(m.drives()) {}
};

/// The lecture's whole task: η̇, every â_i, every joint wrench f̂_i, and the forces of prescribed freedoms.
template <class S>
struct Solution {
  std::vector<S> vdot;                  // η̇
  std::vector<Motion<S>> acceleration;  // â
  std::vector<Wrench<S>> wrench;        // f̂
  std::vector<S> drive_force;

  Solution() = default;
  explicit Solution(const Model& m)
      : vdot(m.nv()), acceleration(m.bodies()), wrench(m.bodies()), drive_force(m.drives()) {}
};

}  // namespace lanc
