// For formulations of the reduced system: M̄ and G are formed, and the differences begin after that.
//
//   M̄ η̇ − Gᵀ λ = b,   G η̇ + γ̿ = 0   with M̄ = JᵀMJ + A, b = Jᵀ(f̂^tc − M ā) + τ   (theory, sections 1 and 4)
#pragma once

#include <Eigen/Core>

#include "lib/closure/scaling.h"
#include "lib/formulation/formulation.h"
#include "lib/scalar/count_eigen.h"
#include "lib/system/closure_jacobian.h"

namespace lanc {

/// M̄ by the composite-rigid-body recursion into a dense matrix, b by one recursion, G and γ̿ of all closure rows; a
/// derived class finds η̇ and λ; then â by (8) and f̂ by (3). O(n d) for M̄ at depth d.
///
/// What derived classes see is scaled as lib/closure/scaling.h says, so that no choice, penalty or threshold depends on
/// units: M̄ and b in kg m² and kg m²/s², G and γ̿ without unit and in 1/s². Where no conditions hold (an open chain, or
/// rank 0) they are not asked: Cholesky of M̄, which allocates nothing. Tested by
/// tests/formulations/constrained_test.cpp.
template <class S>
class ReducedFormulation : public Formulation<S> {
 public:
  explicit ReducedFormulation(const Model& model);

  void assemble(const System<S>& system) final;
  Outcome factorise(const System<S>& system) final;
  void substitute(const System<S>& system, const RightHandSide<S>& rhs, Solution<S>& solution) final;

 protected:
  using Matrix = Eigen::Matrix<S, Eigen::Dynamic, Eigen::Dynamic>;
  using Vector = Eigen::Matrix<S, Eigen::Dynamic, 1>;

  /// Everything that does not depend on the right-hand side. At least one closure condition holds.
  virtual Outcome factorise_closed(const System<S>& system) = 0;
  /// η̇ and λ for b and γ̿; λ has all rows, is zero on entry, and may stay so where rows are dependent.
  virtual void substitute_closed(const Vector& b, const Vector& gamma, Vector& vdot, Vector& lambda) = 0;

  const Matrix& mass_matrix() const { return mass_matrix_; }    // M̄, n_η × n_η
  const Matrix& closure_jacobian() const { return jacobian_; }  // G, all rows
  /// G of a set of independent rows, and which they are. Formed anew at every call.
  Matrix independent_jacobian() const;
  const std::vector<int>& independent_rows() const { return rows_; }

  /// What a singular matrix is called that is positive definite for every mechanism that has an answer.
  static Outcome no_inertia(const char* matrix);

 private:
  void form_mass_matrix(const System<S>& system);
  void form_jacobian(const System<S>& system);
  void form_b(const System<S>& system, const RightHandSide<S>& rhs, Solution<S>& solution);
  void solve_closed(const System<S>& system, const RightHandSide<S>& rhs, Solution<S>& solution);

  ClosureScaling scaling_;
  ClosureJacobian<S> sparse_jacobian_;
  std::vector<RigidInertia<S>> composite_;  // M^c_i: body i and all it carries, as one rigid body
  std::vector<Wrench<S>> load_;
  Matrix mass_matrix_;  // of an open chain, the lower triangle becomes its Cholesky factor
  Matrix jacobian_;
  std::vector<int> rows_;  // the independent ones
  Vector b_, gamma_, vdot_, lambda_;
};

/// Where a system with regularised closure conditions is factored, [M̄ −Gᵀ; G μ] with μ diagonal, and the answer
/// approached by steps whose right-hand side is what the last one left. Each step leaves the fraction μ_k / (μ_k + σ_k)
/// of a closure error, σ_k being the eigenvalues of G M̄⁻¹ Gᵀ other than zero. Redundant rows need no treatment but
/// this: what cannot be balanced in closure errors, rounding errors of γ̿ at most, is kept out of λ, where μ⁻¹ magnifies
/// it; λ gets minimum norm on the way. Every step repeats the momentum balance, too. Stops at the rounding errors of
/// both, or after 200 steps with closures open, which Formulation::solve tells: not_converged.
template <class S>
class RegularisedFormulation : public ReducedFormulation<S> {
 public:
  explicit RegularisedFormulation(const Model& model);

  /// Steps of the last substitution.
  int steps() const { return steps_; }

 protected:
  using typename ReducedFormulation<S>::Matrix;
  using typename ReducedFormulation<S>::Vector;

  Outcome factorise_closed(const System<S>& system) final;
  void substitute_closed(const Vector& b, const Vector& gamma, Vector& vdot, Vector& lambda) final;
  virtual Outcome factorise_regularised() = 0;
  /// x, l of [M̄ −Gᵀ; G μ] [x; l] = [p; q].
  virtual void step(const Vector& p, const Vector& q, Vector& x, Vector& l) = 0;
  /// About the diagonal of G M̄⁻¹ Gᵀ: Σ_k G_ik² / M̄_kk. Coordinates without inertia are left out, since any μ will do
  /// for what they let go.
  Vector delassus_diagonal() const;

 private:
  void keep_in_range(Vector& rows) const;

  int steps_ = 0;
  Matrix range_;  // orthonormal basis of the range of G, where rows are redundant
  Vector p_, q_, x_, l_;
};

/// Why a dense M̄ and G cannot be had, or nothing; for FormulationInfo.
std::optional<std::string> dense_reduced_objection(const Model& model);

extern template class ReducedFormulation<double>;
extern template class ReducedFormulation<long double>;
extern template class ReducedFormulation<Count>;
extern template class RegularisedFormulation<double>;
extern template class RegularisedFormulation<long double>;
extern template class RegularisedFormulation<Count>;

}  // namespace lanc
