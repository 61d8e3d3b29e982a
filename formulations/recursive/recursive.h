#pragma once

#include "formulations/recursive/recursion.h"
#include "lib/formulation/tree_formulation.h"

namespace lanc {

/// Eq. 18, recursion.h, as a formulation.
template <class S>
class Recursive final : public TreeFormulation<S> {
 public:
  explicit Recursive(const Model& model) : TreeFormulation<S>(model), recursion_(model) {}
  void assemble(const System<S>&) override {}

  const ArticulatedInertia<S>& articulated_inertia(int body) const { return recursion_.articulated_inertia(body); }

 private:
  Outcome factorise_tree(const System<S>& system) override {
    recursion_.factorise(system);
    return {};
  }
  void substitute_tree(const System<S>& system, const RightHandSide<S>& rhs, Solution<S>& solution) override {
    recursion_.substitute(system, rhs, solution);
  }

  Recursion<S> recursion_;
};

extern template class Recursive<double>;
extern template class Recursive<long double>;
extern template class Recursive<Count>;

}  // namespace lanc
