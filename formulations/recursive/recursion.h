// Eq. 18 on any scalar.
#pragma once

#include <algorithm>
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
  /// Both, with the right-hand side of the system, but for f̂, for which MomentumBalance needs fewer numbers a body
  /// than M* has: what is kept of M* and f* here is what waits for a parent. Packs have to fetch less. substitute()
  /// asks for factorise() again afterwards, and solution.wrench is scratch.
  void solve(const System<S>& system, Solution<S>& solution);

  /// M*_i: what body i and all it carries weigh at its reference point. Valid after factorise().
  const ArticulatedInertia<S>& articulated_inertia(int body) const { return star_[body]; }

 private:
  struct Freedom {
    Wrench<S> D;  // M* C / N
    S inverse;    // 1 / N, N = Cᵀ M* C + A
    S start;      // N⁻¹ (τ + Cᵀ (f* − M* ā^rel)): η̇ were the parent at rest
  };
  template <class Before, class After>
  void climb(const System<S>& system, Before before, After after);
  Wrench<S> load_of(int body, const RightHandSide<S>& rhs, const ArticulatedInertia<S>& M, const Wrench<S>& from) const;
  void hand_on(int body, Wrench<S> f, const System<S>& system, const RightHandSide<S>& rhs, const Wrench<S>& with,
               Wrench<S>& to);
  template <bool with_wrenches>
  void accelerate(const System<S>& system, const RightHandSide<S>& rhs, Solution<S>& solution);

  Model model_;
  std::vector<ArticulatedInertia<S>> star_;  // M*
  std::vector<Freedom> freedoms_;
};

template <class S>
Recursion<S>::Recursion(const Model& model) : model_(model), star_(model.bodies()), freedoms_(model.nv()) {}

/// Step 2, inertia: leaf to root, eq. 18. `before` sees M* before its freedoms are released, `after` D and 1 / N of
/// what was. What a body hands down waits in star_[parent], or in M where the parent is next: memory would answer late,
/// a quarter of the time of this sweep on a chain.
template <class S>
template <class Before, class After>
[[gnu::always_inline]] inline void Recursion<S>::climb(const System<S>& system, Before before, After after) {
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
    before(i, M);

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
    after(i);
    handed = link.parent == i - 1;
    if (link.parent == ground) continue;
    M = moved_inward(body.r, M);
    if (!link.last_sibling) add(M, star_[link.parent]);
    if (!handed) star_[link.parent] = M;
  }
}

/// Step 2, load of body i: f* − M* ā^rel, `from` being what its children hand down.
template <class S>
[[gnu::always_inline]] inline Wrench<S> Recursion<S>::load_of(int i, const RightHandSide<S>& rhs,
                                                              const ArticulatedInertia<S>& M,
                                                              const Wrench<S>& from) const {
  Wrench<S> f = plus_product(rhs.force[i], M, -rhs.bias[i]);
  if (!model_.link(i).leaf) f += from;
  return f;
}

/// What of it goes on to the parent when the freedoms of body i are released: `to`, what siblings have handed on being
/// in `with`.
template <class S>
[[gnu::always_inline]] inline void Recursion<S>::hand_on(int i, Wrench<S> f, const System<S>& system,
                                                         const RightHandSide<S>& rhs, const Wrench<S>& with,
                                                         Wrench<S>& to) {
  const Link& link = model_.link(i);
  for (int k = link.v; k < link.v + link.nv; ++k) {
    const S torque = rhs.tau[k] + project(model_.column_kind(k), system.columns[k], f);
    freedoms_[k].start = torque * freedoms_[k].inverse;
    f -= freedoms_[k].D * torque;
  }
  if (link.parent == ground) return;
  if (link.last_sibling)
    to = moved_inward(system.bodies[i].r, f);
  else
    to = with + moved_inward(system.bodies[i].r, f);
}

/// Steps 3 and 4: root to leaf; solution.wrench: f* − M* ā^rel on entry, f̂ on return. A joint's columns are taken in
/// reverse, the last released one first.
template <class S>
template <bool with_wrenches>
void Recursion<S>::accelerate(const System<S>& system, const RightHandSide<S>& rhs, Solution<S>& solution) {
  const Model& model = model_;
  Motion<S> before;  // of the body before, often the parent
  for (int i = 0; i < model.bodies(); ++i) {
    const Link& link = model.link(i);
    Motion<S> a{};  // B_ip â_p + C η̇ of the columns done
    const bool at_rest = link.parent == ground;
    if (!at_rest) {
      if (link.parent != i - 1) before = solution.acceleration[link.parent];
      a = moved_outward(system.bodies[i].r, before);
    }
    for (int k = link.v + link.nv - 1; k >= link.v; --k) {
      S vdot = freedoms_[k].start;
      if (!at_rest || k != link.v + link.nv - 1) vdot -= dot(a, freedoms_[k].D);
      solution.vdot[k] = vdot;
      add_along(model.column_kind(k), system.columns[k], vdot, a);
    }
    if constexpr (with_wrenches) solution.wrench[i] = plus_product(-solution.wrench[i], star_[i], a);
    solution.acceleration[i] = before = a + rhs.bias[i];
  }
}

template <class S>
void Recursion<S>::factorise(const System<S>& system) {
  climb(
      system, [this](int i, const ArticulatedInertia<S>& M) __attribute__((always_inline)) { star_[i] = M; },
      [](int) {});
}

template <class S>
void Recursion<S>::substitute(const System<S>& system, const RightHandSide<S>& rhs, Solution<S>& solution) {
  std::vector<Wrench<S>>& load = solution.wrench;
  for (int i = model_.bodies() - 1; i >= 0; --i) {
    load[i] = load_of(i, rhs, star_[i], load[i]);
    Wrench<S>& waiting = load[std::max(model_.link(i).parent, 0)];
    hand_on(i, load[i], system, rhs, waiting, waiting);
  }
  accelerate<true>(system, rhs, solution);
}

template <class S>
void Recursion<S>::solve(const System<S>& system, Solution<S>& solution) {
  std::vector<Wrench<S>>& load = solution.wrench;
  Wrench<S> f, handed;
  bool by_next = false;
  climb(
      system,
      [&](int i, const ArticulatedInertia<S>& M)
          __attribute__((always_inline)) { f = load_of(i, system.rhs, M, by_next ? handed : load[i]); },
      [&](int i) __attribute__((always_inline)) {
        const int p = model_.link(i).parent;
        by_next = p == i - 1;
        Wrench<S>& waiting = load[std::max(p, 0)];
        hand_on(i, f, system, system.rhs, waiting, by_next ? handed : waiting);
      });
  accelerate<false>(system, system.rhs, solution);
}

}  // namespace lanc
