// A configuration up to second order: which first-order motions the closure conditions allow, and which of them can go
// on. Dense singular value decomposition: for mechanisms up to some hundred velocities.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "lib/model/model.h"
#include "lib/system/system.h"

namespace lanc {

/// The scaled G (lib/closure/scaling.h) taken apart: G_s = U diag(σ) Vᵀ.
struct ClosureDecomposition {
  Eigen::MatrixXd U, V;  // square
  Eigen::VectorXd sigma;
  int rank = 0;  // by zero_singular_value, unless given

  Eigen::MatrixXd kernel() const { return V.rightCols(V.cols() - rank); }
  Eigen::MatrixXd left_kernel() const { return U.rightCols(U.cols() - rank); }
  /// σ_k counted from 1; 0 beyond the last.
  double sigma_at(int k) const { return k >= 1 && k <= sigma.size() ? sigma[k - 1] : 0; }
};
/// rank: −1 for the numerical one.
ClosureDecomposition decompose_closures(const System<double>& system, int rank = -1);

/// U₀ᵀ D²g(ξ, ξ) on the kernel of G: a first-order motion ξ = kernel · x goes on to second order where all these
/// quadratic forms vanish. They vanish identically where the rank is constant (redundancy); are definite for a shaky
/// linkage; and have real zeros, the tangents, where branches of motion cross. Prescribed motions stand still.
class SecondOrder {
 public:
  /// d(d+1)/2 evaluations of the kinematics for a kernel of dimension d.
  SecondOrder(const Model& model, const State<double>& state, const ClosureDecomposition& decomposition);

  /// No form is different from zero: the rank is the same in neighbouring states.
  bool vanishes() const { return forms_.empty(); }
  /// The forms that do not vanish, on coordinates of the kernel.
  const std::vector<Eigen::MatrixXd>& forms() const { return forms_; }
  /// Directions in the kernel, one of each pair ±ξ, in which all forms vanish, as scaled velocities of length 1. All of
  /// them for a kernel of dimension 1 or 2; as many as a search from `starts` directions finds for larger ones, where
  /// they may form a cone. With vanishing forms: the basis of the kernel.
  std::vector<Eigen::VectorXd> tangents(int starts = 64) const;

 private:
  std::vector<Eigen::VectorXd> zeros_in_plane() const;
  std::vector<Eigen::VectorXd> search_zeros(int starts) const;

  Eigen::MatrixXd kernel_;
  std::vector<Eigen::MatrixXd> forms_;
};

}  // namespace lanc
