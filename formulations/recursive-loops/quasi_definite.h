// Eq. 14 with closures as one sparse quasi-definite matrix: where no order of bodies and closures keeps the recursion
// linear.
#pragma once

#include <memory>

#include "lib/solve/cholmod.h"
#include "lib/system/eq14_matrix.h"

namespace lanc {

/// Eq. 14 with its border has M and A in the rows of â and η̇, and zeros in those of f̂ and λ. With a small positive
/// number ρ added to the former where A is zero, and a small −μ to the latter, it is quasi-definite: L D Lᵀ exists in
/// any order of rows and columns (Vanderbei 1995), hence in that of approximate minimum degree, which finds its way
/// through what leaf first fills. Proximal steps take ρ and μ out again: x += K_ρμ⁻¹ (b − K x) until a step changes
/// nothing (Carpentier, Budhiraja & Mansard 2021). Rows that depend on others are left out. M must be regular, body by
/// body. `double` only. Tested by tests/formulations/recursive_loops_test.cpp.
class QuasiDefinite {
 public:
  explicit QuasiDefinite(const Model& model);

  /// `independent`: per closure row, as lib/closure/rank.h decides. False when a pivot has the wrong sign: the inertia
  /// of some body is singular or that of no body.
  bool factorise(const System<double>& system, std::span<const char> independent);
  /// Where steps do not converge, η̇ is not a number.
  void substitute(const System<double>& system, const RightHandSide<double>& rhs, Solution<double>& solution);

  int unknowns() const { return matrix_.size(); }
  int nonzeros() const { return static_cast<int>(rows_.size()); }
  FactorStatistics statistics() const { return solver_->statistics(); }
  /// Proximal steps of the last substitution.
  int steps() const { return steps_; }

 private:
  SparseView view() const;
  void fill();
  void regularise(const System<double>& system, std::span<const char> independent, double strength);
  bool signs_are_right() const;
  double size(const Solution<double>& solution) const;
  double size(const System<double>& system, const RightHandSide<double>& rhs) const;
  double open_closures() const;

  Model model_;
  Eq14Matrix<double> matrix_;
  std::vector<int> starts_, rows_;  // those of eq. 14, and every diagonal entry
  std::vector<double> values_;
  std::vector<double> free_;          // per closure row, free_delassus_diagonal()
  std::vector<double> sign_, shift_;  // of every pivot; of every diagonal entry: ρ, −μ
  std::vector<char> independent_;
  std::unique_ptr<CholmodSolver> solver_;
  RightHandSide<double> residual_;
  Solution<double> step_;
  std::vector<double> b_, x_;
  int steps_ = 0;
};

}  // namespace lanc
