// G, the closure conditions in joint coordinates: G η + γ̄ = 0, G η̇ + γ̿ = 0 (theory, section 2).
#pragma once

#include "lib/system/system.h"

namespace lanc {

/// G by rows, sparse: a closure row has entries for the velocities on its loop (of which the lowest common ancestor of
/// its bodies is no part), a coupler row for its terms. Allocates in the constructor only. evaluate: 12 operations a
/// body and 5 a velocity on the loop. Tested by tests/lib/closure_test.cpp.
template <class S>
class ClosureJacobian {
 public:
  explicit ClosureJacobian(const Model& model);

  void evaluate(const System<S>& system);

  int rows() const { return static_cast<int>(starts_.size()) - 1; }
  const std::vector<int>& starts() const { return starts_; }
  const std::vector<int>& columns() const { return columns_; }
  const std::vector<S>& values() const { return values_; }

  /// Row k times x.
  S times(int k, const std::vector<S>& x) const {
    S sum(0.0);
    for (int p = starts_[k]; p < starts_[k + 1]; ++p) sum += values_[p] * x[columns_[p]];
    return sum;
  }

 private:
  struct Walk {  // from a body of a closure towards the lowest common ancestor
    int body, until;
  };
  Model model_;
  std::vector<Walk> walks_;  // two per closure
  std::vector<int> starts_, columns_;
  std::vector<S> values_;
};

/// Lowest common ancestor of two bodies, or ground.
int common_ancestor(const Model& model, int a, int b);

extern template class ClosureJacobian<double>;
extern template class ClosureJacobian<long double>;
extern template class ClosureJacobian<Count>;

}  // namespace lanc
