#pragma once

#include "lib/formulation/formulation.h"

namespace lanc {

/// Eq. 18 and the lecture's four steps, joint freedoms released column by column. O(n).
/// Nothing here compares scalars, so packs and dual numbers can run it.
template <class S>
class Recursive final : public Formulation<S> {
 public:
  explicit Recursive(const Model& model);
  void assemble(const System<S>&) override {}
  Outcome factorise(const System<S>& system) override;
  void substitute(const System<S>& system, const RightHandSide<S>& rhs, Solution<S>& solution) override;

  /// M*_i: what body i and all it carries weigh at its reference point. Valid after factorise().
  const ArticulatedInertia<S>& articulated_inertia(int body) const { return star_[body]; }

 private:
  struct Freedom {
    Wrench<S> D;  // M* C / N
    S inverse;    // 1 / N, N = Cᵀ M* C + A
    S start;      // N⁻¹ (τ + Cᵀ (f* − M* ā^rel)): η̇ were the parent at rest
  };
  std::vector<ArticulatedInertia<S>> star_;  // M*
  std::vector<Wrench<S>> load_;              // f*, then f* − M* ā^rel
  std::vector<Freedom> freedoms_;
};

extern template class Recursive<double>;
extern template class Recursive<long double>;
extern template class Recursive<Count>;

}  // namespace lanc
