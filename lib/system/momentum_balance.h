// Joint wrenches from accelerations, body by body and not kept.
#pragma once

#include "lib/system/system.h"

namespace lanc {

/// f̂ by eq. 3 with (4) from the accelerations in `solution`, leaf to root: then(i, f̂_i). Of open mechanisms.
/// solution.wrench is where wrenches wait for a parent that is not next; then() may put f̂_i into its place i. O(n).
template <class S, class Then>
[[gnu::always_inline]] inline void momentum_balance(const System<S>& system, Solution<S>& solution, Then then) {
  const std::span<const Link> links = system.model.links();
  std::vector<Wrench<S>>& waiting = solution.wrench;
  Wrench<S> handed;
  bool by_next = false;  // by body i + 1: handed
  for (int i = system.model.bodies() - 1; i >= 0; --i) {
    const Link& link = links[i];
    const auto& body = system.bodies[i];
    Wrench<S> f = plus_product(-system.rhs.force[i], body.inertia, solution.acceleration[i]);
    if (!link.leaf) f += by_next ? handed : waiting[i];
    by_next = link.parent == i - 1;
    if (link.parent != ground) {
      handed = moved_inward(body.r, f);
      if (!link.last_sibling) handed += waiting[link.parent];
      if (!by_next) waiting[link.parent] = handed;
    }
    then(i, f);
  }
}

}  // namespace lanc
