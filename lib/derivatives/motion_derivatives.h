// The equations of motion as a residual, and its exact derivatives by dual numbers.
// Private to the library.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "lib/system/evaluator.h"

namespace lanc {

/// Of q̇ = H(q) η, r = M̄ η̇ − b − Gᵀλ, g, ġ = G η + γ̄ and g̈ = G η̇ + γ̿ with respect to all q, then all η, one column
/// each; η̇ and λ are kept. Euler parameters are normalised within, so that the direction of their length has none.
struct MotionDerivatives {
  Eigen::MatrixXd coordinate_rate, balance, position, velocity, acceleration;
};

/// Inverse dynamics on Dual<8>: a pass over the bodies for every eight columns, no differences. Bound to a model.
/// Tested by tests/derivatives/motion_derivatives_test.cpp.
class Differentiator {
 public:
  static constexpr int lanes = 8;
  Differentiator(const Model& model, const Loads<double>& loads);

  const MotionDerivatives& at(const State<double>& state, const std::vector<double>& vdot,
                              const std::vector<double>& lambda);
  /// Passes over the bodies that one at() takes.
  int passes() const { return (model_.nq() + model_.nv() + lanes - 1) / lanes; }

 private:
  using D = Dual<lanes>;
  void allocate();
  void evaluate(State<D> state);
  void store(int first, int count);

  Model model_;
  Loads<D> loads_;
  Evaluator<D> evaluator_;
  Solution<D> solution_;
  std::vector<D> rates_, tau_, acceleration_;
  const System<D>* system_ = nullptr;
  MotionDerivatives result_;
};

}  // namespace lanc
