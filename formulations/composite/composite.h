#pragma once

#include "formulations/composite/path_factor.h"
#include "lib/formulation/tree_formulation.h"
#include "lib/system/equations.h"

namespace lanc {

/// M̄ by the composite-rigid-body recursion, factored M̄ = LᵀDL along the tree, without fill. O(n d²) for depth d.
/// Nothing here compares scalars, so packs and dual numbers can run it.
template <class S>
class Composite final : public TreeFormulation<S> {
 public:
  explicit Composite(const Model& model) : TreeFormulation<S>(model), composite_(model.bodies()), factor_(model) {}

  void assemble(const System<S>& system) override;

 private:
  Outcome factorise_tree(const System<S>& system) override;
  void substitute_tree(const System<S>& system, const RightHandSide<S>& rhs, Solution<S>& solution) override;
  void assemble_rows(const System<S>& system, int body);

  std::vector<RigidInertia<S>> composite_;  // M^c_i: body i and all it carries, as one rigid body
  PathFactor<S> factor_;
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
    S* const begin = factor_.begin_row(k);
    S* entry = begin + factor_.depth(k);
    for (int l = k; l >= own.v; --l) *--entry = project(model.column_kind(l), system.columns[l], F);
    if (model.has_armature()) begin[factor_.depth(k) - 1] += S(model.armature()[k]);
    for (int body = i; entry != begin;) {
      F = moved_inward(system.bodies[body].r, F);
      body = links[body].parent;
      const Link& link = links[body];
      for (int l = link.v + link.nv - 1; l >= link.v; --l)
        *--entry = project(model.column_kind(l), system.columns[l], F);
    }
  }
}

template <class S>
Outcome Composite<S>::factorise_tree(const System<S>&) {
  factor_.factorise();
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
  factor_.solve(x);
  newton_euler(system, rhs, solution);
}

extern template class Composite<double>;
extern template class Composite<long double>;
extern template class Composite<Count>;

}  // namespace lanc
