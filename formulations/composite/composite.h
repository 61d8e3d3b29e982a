#pragma once

#include <algorithm>
#include <array>

#include "formulations/composite/path_factor.h"
#include "lib/formulation/tree_formulation.h"
#include "lib/spatial/block.h"
#include "lib/system/equations.h"

namespace lanc {

/// M̄ by the composite-rigid-body recursion, factored M̄ = LᵀDL along the tree, without fill. O(n d²) for depth d.
/// Nothing here compares scalars, so packs and dual numbers can run it.
template <class S>
class Composite final : public TreeFormulation<S> {
 public:
  explicit Composite(const Model& model);

  void assemble(const System<S>& system) override;

 private:
  Outcome factorise_tree(const System<S>& system) override;
  void substitute_tree(const System<S>& system, const RightHandSide<S>& rhs, Solution<S>& solution) override;
  /// The lowest of coordinates that follow one another on a path, as many as a block has lanes or fewer.
  struct Strand {
    int lowest, count;
  };
  void assemble_rows(const System<S>& system, const Strand& strand);
  void assemble_row(const System<S>& system, int k);

  static constexpr int lanes = PackedScalar<S>::lanes;
  /// How many rows are not worth eight lanes: with registers that hold eight numbers one is not, else a few are not.
  static constexpr int few = lanes * static_cast<int>(sizeof(double)) > register_bytes ? 3 : 1;
  std::vector<Strand> strands_;             // every coordinate is in one of them
  std::vector<RigidInertia<S>> composite_;  // M^c_i: body i and all it carries, as one rigid body
  PathFactor<S> factor_;
  std::vector<int> before_;          // the coordinate before, on the path
  std::vector<Packed<S>> by_depth_;  // entries of the rows of a strand, side by side
};

template <class S>
Composite<S>::Composite(const Model& model) : TreeFormulation<S>(model), composite_(model.bodies()), factor_(model) {
  const VelocityPaths paths(model);
  for (int k = 0; k < model.nv(); ++k) before_.push_back(paths.before(k));
  std::vector<bool> taken(model.nv(), false);
  int deepest = 0;
  for (int k = model.nv() - 1; k >= 0; --k) {
    if (taken[k]) continue;
    Strand strand{k, 0};
    for (int l = k; l >= 0 && !taken[l] && strand.count < lanes; l = before_[l]) taken[l] = true, ++strand.count;
    strands_.push_back(strand);
    deepest = std::max(deepest, paths.depth(k));
  }
  by_depth_.resize(lanes * blocks_of<S>(deepest));
}

template <class S>
void Composite<S>::assemble(const System<S>& system) {
  const std::span<const Link> links = this->model().links();
  const int n = this->model().bodies();
  for (int i = 0; i < n; ++i) composite_[i] = system.bodies[i].inertia;
  for (int i = n - 1; i >= 0; --i)
    if (links[i].parent != ground) composite_[links[i].parent] += moved_inward(system.bodies[i].r, composite_[i]);
  for (const Strand& strand : strands_) {
    if (strand.count > few)
      assemble_rows(system, strand);
    else
      for (int j = 0, k = strand.lowest; j < strand.count; ++j, k = before_[k]) assemble_row(system, k);
  }
  if (!this->model().has_armature()) return;
  for (int k = 0; k < this->model().nv(); ++k)
    factor_.begin_row(k)[factor_.depth(k) - 1] += S(this->model().armature()[k]);
}

/// M^c C_k, moved towards the root, meets the columns of every joint on the way.
template <class S>
void Composite<S>::assemble_row(const System<S>& system, int k) {
  const Model& model = this->model();
  const std::span<const Link> links = model.links();
  int body = model.body_of_velocity(k);
  Wrench<S> F = times_column(composite_[body], model.column_kind(k), system.columns[k]);
  S* const begin = factor_.begin_row(k);
  S* entry = begin + factor_.depth(k);
  for (int l = k; l >= links[body].v; --l) *--entry = project(model.column_kind(l), system.columns[l], F);
  while (entry != begin) {
    F = moved_inward(system.bodies[body].r, F);
    body = links[body].parent;
    const Link& link = links[body];
    for (int l = link.v + link.nv - 1; l >= link.v; --l) *--entry = project(model.column_kind(l), system.columns[l], F);
  }
}

/// The same for a strand, side by side: each row joins at its own joint.
template <class S>
void Composite<S>::assemble_rows(const System<S>& system, const Strand& strand) {
  using B = Packed<S>;
  const Model& model = this->model();
  std::array<S*, lanes> rows;
  Wrench<B> F{{B(0.0), B(0.0), B(0.0)}, {B(0.0), B(0.0), B(0.0)}};
  const int depth = factor_.depth(strand.lowest), blocks = blocks_of<S>(depth);
  int entry = depth, joined = 0;
  const std::span<const Link> links = model.links();
  int l = strand.lowest, body = model.body_of_velocity(l), first = links[body].v;
  for (;;) {
    const ColumnKind kind = model.column_kind(l);
    if (joined < strand.count) {
      F = with_lane<S>(F, joined, times_column(composite_[body], kind, system.columns[l]));
      rows[joined++] = factor_.begin_row(l);
    }
    by_depth_[--entry] = project(kind, cast<B>(system.columns[l]), F);
    if (entry == 0) break;
    if (l-- > first) continue;
    do {
      F = moved_inward(cast<B>(system.bodies[body].r), F);
      body = links[body].parent;
      first = links[body].v;
      l = first + links[body].nv - 1;
    } while (l < first);
  }
  // Rows end in zeros: so do these (unless something is not finite), since what has not joined yet is zero.
  std::fill(by_depth_.begin() + depth, by_depth_.begin() + lanes * blocks, B(0.0));
  for (int block = 0; block < blocks; ++block) {
    std::array<B, lanes> part;
    std::copy_n(by_depth_.begin() + lanes * block, lanes, part.begin());
    transpose(part);
    for (int j = 0; j < strand.count && block < blocks_of<S>(depth - j); ++j)
      store_block<S>(part[j], rows[j] + lanes * block);
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
