// Second derivatives of the closure conditions: what tells a singular configuration from a redundant one.
#pragma once

#include <vector>

#include "lib/system/equations.h"
#include "lib/system/evaluator.h"

namespace lanc {

/// D²g(ξ, ξ) at a state: the part of γ̿ that is quadratic in the velocities. Where the rank of G is constant, no ξ in
/// its kernel has a curvature outside its range (constant rank theorem); where it is not, motions of several branches
/// cross or a first-order motion leads nowhere. O(n) each. Tested by tests/lib/closure_test.cpp.
class ClosureCurvature {
 public:
  explicit ClosureCurvature(const Model& model) : evaluator_(model), at_rest_(model) {}

  /// Curvature of every row; xi: one value per velocity.
  std::vector<double> operator()(const State<double>& state, const std::vector<double>& xi) {
    State<double> moving = state;
    moving.v = xi;
    std::vector<double> result = bias(moving);
    for (double& v : moving.v) v = -v;
    const std::vector<double> backward = bias(moving);
    for (double& v : moving.v) v = 0;
    const std::vector<double> still = bias(moving);
    for (std::size_t k = 0; k < result.size(); ++k) result[k] = (result[k] + backward[k]) / 2 - still[k];
    return result;
  }

 private:
  std::vector<double> bias(const State<double>& state) {
    const System<double>& system = evaluator_.system(state);
    bias_accelerations(system, system.rhs, at_rest_);
    std::vector<double> result;
    closure_accelerations(system, system.rhs, at_rest_, result);  // η̇ = 0
    return result;
  }

  Evaluator<double> evaluator_;
  Solution<double> at_rest_;
};

}  // namespace lanc
