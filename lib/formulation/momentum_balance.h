// The first look at accelerations, joint wrenches being found on the way.
// Private to lib/formulation.
#pragma once

#include <vector>

#include "lib/formulation/judgement.h"

namespace lanc {

/// f̂ of an open mechanism by eq. 3 with (4) from accelerations that are known, leaf to root, looked at as first_look()
/// does but for one thing: rounding errors of all that a body carries add up in its f̂, so that the numbers it is made
/// of are those of all these bodies. Tested by tests/contract/judgement_test.cpp.
template <class S>
class MomentumBalance {
 public:
  explicit MomentumBalance(const Model& model) : made_of_(model.bodies()) {}

  /// By how much eq. 12 is violated. solution.wrench is f̂ afterwards if `keep_wrenches`, scratch otherwise. O(n).
  auto look(const System<S>& system, Solution<S>& solution, bool keep_wrenches) {
    return keep_wrenches ? sweep<true>(system, solution) : sweep<false>(system, solution);
  }

 private:
  using Real = judgement::Real<S>;

  template <bool keep_wrenches>
  Real sweep(const System<S>& system, Solution<S>& solution) {
    judgement::ViolationOfEq12<S, judgement::MeanNumber> violation(system, solution, {});
    const std::span<const Link> links = system.model.links();
    std::vector<Wrench<S>>& waiting = solution.wrench;  // for a parent that is not next
    Wrench<S> handed;                                   // by body i + 1 to its parent, if that is i
    Real sum_handed;
    bool by_next = false;
    for (int i = system.model.bodies() - 1; i >= 0; --i) {
      const Link& link = links[i];
      const auto& body = system.bodies[i];
      Wrench<S> f = plus_product(-system.rhs.force[i], body.inertia, solution.acceleration[i]);
      Real sum = judgement::made_of(system, i, f);
      if (!link.leaf) {
        f += by_next ? handed : waiting[i];
        sum += by_next ? sum_handed : made_of_[i];
      }
      by_next = link.parent == i - 1;
      if (link.parent != ground) {
        handed = moved_inward(body.r, f);
        sum_handed = sum;
        if (!link.last_sibling) handed += waiting[link.parent], sum_handed += made_of_[link.parent];
        if (!by_next) waiting[link.parent] = handed, made_of_[link.parent] = sum_handed;
      }
      if constexpr (keep_wrenches) waiting[i] = f;
      violation.add_body(i, f, sum);
    }
    return violation.excess();
  }

  std::vector<Real> made_of_;  // what waits beside wrenches
};

}  // namespace lanc
