#pragma once

#include <algorithm>

#include "lib/formulation/tree_formulation.h"
#include "lib/model/paths.h"
#include "lib/system/equations.h"

namespace lanc {

/// M̄ by the composite-rigid-body recursion, factored M̄ = LᵀDL along the tree, without fill. O(n d²) for depth d.
/// Nothing here compares scalars, so packs and dual numbers can run it.
template <class S>
class Composite final : public TreeFormulation<S> {
 public:
  explicit Composite(const Model& model)
      : TreeFormulation<S>(model),
        paths_(model),
        preorder_(paths_.preorder()),
        composite_(model.bodies()),
        inverse_diagonal_(model.nv()) {
    start_.reserve(model.nv() + 1);
    start_.push_back(0);
    for (int k = 0; k < model.nv(); ++k) start_.push_back(start_.back() + paths_.depth(k));
    H_.resize(start_.back());
    int deepest = 0;
    for (int k = 0; k < model.nv(); ++k) deepest = std::max(deepest, paths_.depth(k));
    from_below_.assign(deepest, S(0.0));
    on_path_.resize(deepest);
  }

  void assemble(const System<S>& system) override;

 private:
  Outcome factorise_tree(const System<S>& system) override;
  void substitute_tree(const System<S>& system, const RightHandSide<S>& rhs, Solution<S>& solution) override;

  void assemble_rows(const System<S>& system, int body);
  /// Row k of M̄, then of L: one entry for every coordinate on the path of k, root first, k last.
  S* row(int k) { return H_.data() + start_[k]; }
  const S* row(int k) const { return H_.data() + start_[k]; }

  /// Σ a_e b_e in two sums, since one would wait for each addition, and one by one: what has just been written number
  /// by number is late for a wide load.
  static S inner_product(const S* a, const S* b, int n) {
    S even(0.0), odd(0.0);
    int e = 0;
    for (; e + 1 < n; e += 2) even += a[e] * b[e], odd += a[e + 1] * b[e + 1];
    if (e < n) even += a[e] * b[e];
    return even + odd;
  }

  VelocityPaths paths_;
  std::vector<int> preorder_;
  std::vector<std::size_t> start_;
  std::vector<S> H_;
  std::vector<RigidInertia<S>> composite_;  // M^c_i: body i and all it carries, as one rigid body
  std::vector<S> inverse_diagonal_;         // of D
  // By depth, along the path of the present coordinate: Lᵀ y of those below, zero when all is done; and η̇.
  std::vector<S> from_below_, on_path_;
};

template <class S>
void Composite<S>::assemble(const System<S>& system) {
  const std::span<const Link> links = this->model().links();
  const int n = this->model().bodies();
  for (int i = 0; i < n; ++i) composite_[i] = system.bodies[i].inertia;
  for (int i = n - 1; i >= 0; --i) {
    assemble_rows(system, i);
    if (links[i].parent != ground) composite_[links[i].parent] += moved_inward(system.bodies[i].r, composite_[i]);
  }
}

/// M^c C_k of the columns of body i, moved towards the root, meets the columns of every joint on the way.
template <class S>
void Composite<S>::assemble_rows(const System<S>& system, int i) {
  const Model& model = this->model();
  const std::span<const Link> links = model.links();
  const Link& own = links[i];
  for (int k = own.v; k < own.v + own.nv; ++k) {
    Wrench<S> F = times_column(composite_[i], model.column_kind(k), system.columns[k]);
    S* const begin = row(k);
    S* entry = begin + paths_.depth(k);
    for (int l = k; l >= own.v; --l) *--entry = project(model.column_kind(l), system.columns[l], F);
    if (model.has_armature()) begin[paths_.depth(k) - 1] += S(model.armature()[k]);
    for (int body = i; entry != begin;) {
      F = moved_inward(system.bodies[body].r, F);
      body = links[body].parent;
      const Link& link = links[body];
      for (int l = link.v + link.nv - 1; l >= link.v; --l)
        *--entry = project(model.column_kind(l), system.columns[l], F);
    }
  }
}

/// LᵀDL from the leaves to the root: eliminating coordinate k touches only rows of coordinates on its path.
template <class S>
Outcome Composite<S>::factorise_tree(const System<S>&) {
  for (int k = this->model().nv() - 1; k >= 0; --k) {
    S* const __restrict L = row(k);
    const int last = paths_.depth(k) - 1;
    inverse_diagonal_[k] = S(1.0) / L[last];
    for (int d = last - 1, i = paths_.before(k); d >= 0; --d, i = paths_.before(i)) {
      S* const __restrict H = row(i);
      const S factor = L[d] * inverse_diagonal_[k];
      for (int e = 0; e <= d; ++e) H[e] -= factor * L[e];
      L[d] = factor;
    }
  }
  return {};
}

template <class S>
void Composite<S>::substitute_tree(const System<S>& system, const RightHandSide<S>& rhs, Solution<S>& solution) {
  const Model& model = this->model();
  std::vector<S>& x = solution.vdot;
  // τ + Jᵀ (f̂^tc − M ā)
  newton_euler_at_rest(system, rhs, solution);
  for (int k = 0; k < model.nv(); ++k)
    x[k] = rhs.tau[k] - project(model.column_kind(k), system.columns[k], solution.wrench[model.body_of_velocity(k)]);
  // Lᵀ y = x, then L η̇ = D⁻¹ y
  S* const from_below = from_below_.data();
  S* const on_path = on_path_.data();
  for (auto k = preorder_.rbegin(); k != preorder_.rend(); ++k) {
    const S* const L = row(*k);
    const int d = paths_.depth(*k) - 1;
    const S y = x[*k] - from_below[d];
    from_below[d] = S(0.0);
    for (int e = 0; e < d; ++e) from_below[e] += L[e] * y;
    x[*k] = y;
  }
  for (const int k : preorder_) {
    const int d = paths_.depth(k) - 1;
    x[k] = on_path[d] = x[k] * inverse_diagonal_[k] - inner_product(row(k), on_path, d);
  }
  newton_euler(system, rhs, solution);
}

extern template class Composite<double>;
extern template class Composite<long double>;
extern template class Composite<Count>;

}  // namespace lanc
