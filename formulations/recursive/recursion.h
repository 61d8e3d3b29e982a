// Eq. 18 on any scalar.
#pragma once

#include <vector>

#include "lib/system/system.h"

namespace lanc {

/// Eq. 18 and the lecture's four steps, joint freedoms released column by column. O(n).
/// Nothing here compares scalars, so packs and dual numbers can run it.
template <class S>
class Recursion {
 public:
  explicit Recursion(const Model& model);
  void factorise(const System<S>& system);
  void substitute(const System<S>& system, const RightHandSide<S>& rhs, Solution<S>& solution);
  /// Both, with the right-hand side of the system. Loads climb along with the inertias, and what a body consists of is
  /// fetched once: on packs 0.86 (100 bodies) to 0.91 (6) of the time of the two.
  void solve(const System<S>& system, Solution<S>& solution);

  /// M*_i: what body i and all it carries weigh at its reference point. Valid after factorise() or solve().
  const ArticulatedInertia<S>& articulated_inertia(int body) const { return star_[body]; }

 private:
  struct Freedom {
    Wrench<S> D;  // M* C / N
    S inverse;    // 1 / N, N = Cᵀ M* C + A
    S start;      // N⁻¹ (τ + Cᵀ (f* − M* ā^rel)): η̇ were the parent at rest
  };
  template <class Then>
  void climb(const System<S>& system, Then then);
  void take_load(int body, const System<S>& system, const RightHandSide<S>& rhs, std::vector<Wrench<S>>& load);
  void accelerate(const System<S>& system, const RightHandSide<S>& rhs, Solution<S>& solution);

  Model model_;
  std::vector<ArticulatedInertia<S>> star_;  // M*
  std::vector<Freedom> freedoms_;
};

template <class S>
Recursion<S>::Recursion(const Model& model) : model_(model), star_(model.bodies()), freedoms_(model.nv()) {}

/// Step 2, inertia: leaf to root, eq. 18. What a body hands down waits in star_[parent], or in M where the parent is
/// next: memory would answer late, a quarter of the time of this sweep on a chain.
template <class S>
template <class Then>
[[gnu::always_inline]] inline void Recursion<S>::climb(const System<S>& system, Then then) {
  const std::span<const Link> links = model_.links();
  const double* const armature = model_.has_armature() ? model_.armature().data() : nullptr;
  ArticulatedInertia<S> M;
  bool handed = false;  // by body i + 1: M
  for (int i = model_.bodies() - 1; i >= 0; --i) {
    const Link& link = links[i];
    const auto& body = system.bodies[i];
    if (link.leaf) {
      M = expanded(body.inertia);
    } else {
      if (!handed) M = star_[i];
      add(M, body.inertia);
    }
    star_[i] = M;

    for (int k = link.v; k < link.v + link.nv; ++k) {  // (1 − M* C N⁻¹ Cᵀ) M*, one column after the other
      const ColumnKind kind = model_.column_kind(k);
      const Wrench<S> U = times_column(M, kind, system.columns[k]);
      S N = project(kind, system.columns[k], U);
      if (armature) N += S(armature[k]);
      Freedom& freedom = freedoms_[k];
      freedom.inverse = S(1.0) / N;
      freedom.D = U * freedom.inverse;
      subtract_outer(M, freedom.D, U);
    }
    then(i);
    handed = link.parent == i - 1;
    if (link.parent == ground) continue;
    M = moved_inward(body.r, M);
    if (!link.last_sibling) add(M, star_[link.parent]);
    if (!handed) star_[link.parent] = M;
  }
}

/// Step 2, load of body i: f* − M* ā^rel, and what of it goes on to the parent. `load` has both until f̂ takes its
/// place.
template <class S>
[[gnu::always_inline]] inline void Recursion<S>::take_load(int i, const System<S>& system, const RightHandSide<S>& rhs,
                                                           std::vector<Wrench<S>>& load) {
  const Link& link = model_.link(i);
  Wrench<S> f = plus_product(rhs.force[i], star_[i], -rhs.bias[i]);
  if (!link.leaf) f += load[i];
  load[i] = f;
  if (link.parent == ground && link.nv == 0) return;
  for (int k = link.v; k < link.v + link.nv; ++k) {
    const S torque = rhs.tau[k] + project(model_.column_kind(k), system.columns[k], f);
    freedoms_[k].start = torque * freedoms_[k].inverse;
    f -= freedoms_[k].D * torque;
  }
  if (link.parent == ground) return;
  if (link.last_sibling)
    load[link.parent] = moved_inward(system.bodies[i].r, f);
  else
    load[link.parent] += moved_inward(system.bodies[i].r, f);
}

/// Steps 3 and 4: root to leaf; solution.wrench: f* − M* ā^rel on entry, f̂ on return. A joint's columns are taken in
/// reverse, the last released one first.
template <class S>
void Recursion<S>::accelerate(const System<S>& system, const RightHandSide<S>& rhs, Solution<S>& solution) {
  const Model& model = model_;
  for (int i = 0; i < model.bodies(); ++i) {
    const Link& link = model.link(i);
    Motion<S> a{};  // B_ip â_p + C η̇ of the columns done
    const bool at_rest = link.parent == ground;
    if (!at_rest) a = moved_outward(system.bodies[i].r, solution.acceleration[link.parent]);
    for (int k = link.v + link.nv - 1; k >= link.v; --k) {
      S vdot = freedoms_[k].start;
      if (!at_rest || k != link.v + link.nv - 1) vdot -= dot(a, freedoms_[k].D);
      solution.vdot[k] = vdot;
      add_along(model.column_kind(k), system.columns[k], vdot, a);
    }
    solution.wrench[i] = plus_product(-solution.wrench[i], star_[i], a);
    solution.acceleration[i] = a + rhs.bias[i];
  }
}

template <class S>
void Recursion<S>::factorise(const System<S>& system) {
  climb(system, [](int) {});
}

template <class S>
void Recursion<S>::substitute(const System<S>& system, const RightHandSide<S>& rhs, Solution<S>& solution) {
  for (int i = model_.bodies() - 1; i >= 0; --i) take_load(i, system, rhs, solution.wrench);
  accelerate(system, rhs, solution);
}

template <class S>
void Recursion<S>::solve(const System<S>& system, Solution<S>& solution) {
  climb(
      system, [&](int i) __attribute__((always_inline)) { take_load(i, system, system.rhs, solution.wrench); });
  accelerate(system, system.rhs, solution);
}

}  // namespace lanc
