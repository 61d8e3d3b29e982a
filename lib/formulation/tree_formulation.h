// For formulations that solve trees: loops are closed on top of them by the Schur complement G M̄⁻¹ Gᵀ.
#pragma once

#include <Eigen/Core>

#include "lib/formulation/formulation.h"
#include "lib/scalar/count_eigen.h"

namespace lanc {

/// A formulation of open chains becomes one of closed loops: the tree is solved for unit multipliers of a set of
/// independent closure rows, which gives the columns of M̄⁻¹Gᵀ and with them the inverse operational-space inertia
/// G M̄⁻¹ Gᵀ (Rodriguez, Jain & Kreutz-Delgado 1992); its Cholesky factor gives λ. O(r) solutions of the tree and O(r³).
/// Divides by M̄: where the tree without its loops is singular, this is an objection.
template <class S>
class TreeFormulation : public Formulation<S> {
 public:
  explicit TreeFormulation(const Model& model);
  // In the library, whose alignment of dynamic matrices need not be that of whoever derives from this.
  ~TreeFormulation() override;

  Outcome factorise(const System<S>& system) final;
  void substitute(const System<S>& system, const RightHandSide<S>& rhs, Solution<S>& solution) final;

 protected:
  /// The phases of the tree, as if no loop were closed.
  virtual Outcome factorise_tree(const System<S>& system) = 0;
  virtual void substitute_tree(const System<S>& system, const RightHandSide<S>& rhs, Solution<S>& solution) = 0;

 private:
  using Matrix = Eigen::Matrix<S, Eigen::Dynamic, Eigen::Dynamic>;
  Outcome factorise_closures(const System<S>& system);
  /// λ from what the open loops do, and the tree once more under it.
  void close(const System<S>& system, const RightHandSide<S>& rhs, Solution<S>& solution);

  std::vector<int> rows_;  // the independent closure rows
  Matrix schur_;           // G M̄⁻¹ Gᵀ of these rows, then its Cholesky factor
  Eigen::Matrix<S, Eigen::Dynamic, 1> lambda_;
  RightHandSide<S> loaded_;
  Solution<S> unit_;
  std::vector<S> closure_;
};

extern template class TreeFormulation<double>;
extern template class TreeFormulation<long double>;
extern template class TreeFormulation<Count>;

}  // namespace lanc
