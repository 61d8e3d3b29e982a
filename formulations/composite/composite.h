#pragma once

#include "lib/formulation/tree_formulation.h"
#include "lib/model/paths.h"
#include "lib/system/equations.h"

namespace lanc {

/// M̄ by the composite-rigid-body recursion, factored M̄ = LᵀL along the tree, without fill. O(n d²) for depth d.
/// Nothing here compares scalars, so packs and dual numbers can run it.
template <class S>
class Composite final : public TreeFormulation<S> {
 public:
  explicit Composite(const Model& model)
      : TreeFormulation<S>(model),
        paths_(model),
        composite_(model.bodies()),
        load_(model.bodies()),
        inverse_diagonal_(model.nv()) {
    start_.reserve(model.nv() + 1);
    start_.push_back(0);
    for (int k = 0; k < model.nv(); ++k) start_.push_back(start_.back() + paths_.depth(k));
    H_.resize(start_.back());
  }

  void assemble(const System<S>& system) override;

 private:
  Outcome factorise_tree(const System<S>& system) override;
  void substitute_tree(const System<S>& system, const RightHandSide<S>& rhs, Solution<S>& solution) override;

  /// Row k of M̄, then of L: one entry for every coordinate on the path of k, root first, k last.
  S* row(int k) { return H_.data() + start_[k]; }
  const S* row(int k) const { return H_.data() + start_[k]; }

  VelocityPaths paths_;
  std::vector<std::size_t> start_;
  std::vector<S> H_;
  std::vector<RigidInertia<S>> composite_;  // M^c_i: body i and all it carries, as one rigid body
  std::vector<Wrench<S>> load_;
  std::vector<S> inverse_diagonal_;
};

template <class S>
void Composite<S>::assemble(const System<S>& system) {
  const Model& model = this->model();
  for (int i = 0; i < model.bodies(); ++i) composite_[i] = system.bodies[i].inertia;
  for (int i = model.bodies() - 1; i >= 0; --i) {
    const Link& link = model.link(i);
    for (int k = link.v; k < link.v + link.nv; ++k) {
      // M^c C_k moved towards the root meets the columns of every joint on the way.
      Wrench<S> F = times_column(composite_[i], model.column_kind(k), system.columns[k]);
      S* entry = row(k) + paths_.depth(k) - 1;
      int body = i;
      for (int l = k; l >= 0; l = paths_.before(l), --entry) {
        for (const int target = model.body_of_velocity(l); body != target; body = model.link(body).parent)
          F = moved_inward(system.bodies[body].r, F);
        *entry = project(model.column_kind(l), system.columns[l], F);
      }
      if (model.has_armature()) row(k)[paths_.depth(k) - 1] += S(model.armature()[k]);
    }
    if (link.parent != ground) composite_[link.parent] += moved_inward(system.bodies[i].r, composite_[i]);
  }
}

/// LᵀL from the leaves to the root: eliminating coordinate k touches only rows of coordinates on its path.
template <class S>
Outcome Composite<S>::factorise_tree(const System<S>&) {
  for (int k = this->model().nv() - 1; k >= 0; --k) {
    S* L = row(k);
    const int depth = paths_.depth(k);
    inverse_diagonal_[k] = S(1.0) / sqrt(L[depth - 1]);
    for (int d = 0; d < depth - 1; ++d) L[d] *= inverse_diagonal_[k];
    int i = paths_.before(k);
    for (int d = depth - 2; d >= 0; --d, i = paths_.before(i)) {
      S* H = row(i);
      for (int e = 0; e <= d; ++e) H[e] -= L[d] * L[e];
    }
  }
  return {};
}

template <class S>
void Composite<S>::substitute_tree(const System<S>& system, const RightHandSide<S>& rhs, Solution<S>& solution) {
  const Model& model = this->model();
  std::vector<S>& x = solution.vdot;
  // Jᵀ (f̂^tc − M ā) + τ, leaf to root
  bias_accelerations(system, rhs, solution);
  for (int i = 0; i < model.bodies(); ++i)
    load_[i] = rhs.force[i] - system.bodies[i].inertia * solution.acceleration[i];
  for (int i = model.bodies() - 1; i >= 0; --i) {
    const Link& link = model.link(i);
    for (int k = link.v; k < link.v + link.nv; ++k)
      x[k] = rhs.tau[k] + project(model.column_kind(k), system.columns[k], load_[i]);
    if (link.parent != ground) load_[link.parent] += moved_inward(system.bodies[i].r, load_[i]);
  }
  // Lᵀ y = b, then L η̇ = y
  for (int k = model.nv() - 1; k >= 0; --k) {
    x[k] *= inverse_diagonal_[k];
    const S* L = row(k);
    for (int i = paths_.before(k), d = paths_.depth(k) - 2; i >= 0; i = paths_.before(i), --d) x[i] -= L[d] * x[k];
  }
  for (int k = 0; k < model.nv(); ++k) {
    const S* L = row(k);
    for (int i = paths_.before(k), d = paths_.depth(k) - 2; i >= 0; i = paths_.before(i), --d) x[k] -= L[d] * x[i];
    x[k] *= inverse_diagonal_[k];
  }
  accelerations(system, rhs, solution);
  wrenches(system, rhs, solution);
}

extern template class Composite<double>;
extern template class Composite<long double>;
extern template class Composite<Count>;

}  // namespace lanc
