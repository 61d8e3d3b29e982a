// Eq. 14 solved as it stands, by a sparse direct solver. The folders eq14-* differ in the solver and its settings only.
#pragma once

#include "lib/formulation/formulation.h"
#include "lib/solve/sparse_solver.h"
#include "lib/system/eq14_matrix.h"

namespace lanc {

/// Makes a solver for the pattern of a matrix.
using SolverFactory = std::unique_ptr<SparseSolver> (*)(const SparseView& sample, const SparseOptions& options);

/// What one of the eq14-* formulations is made of.
struct Eq14Settings {
  Eq14Layout layout;
  SparseOptions solver;
  SolverFactory make_solver = nullptr;
  /// The solver takes the pivots of the layout, whatever their size. They divide by the tree's M̄, so that where loops
  /// are closed a vanishing pivot says nothing about the mechanism: an objection then, not `singular`.
  bool fixed_pivots = false;
};

/// For a layout with the same order in rows and columns: multiplying row and column k of eq. 14 by the k-th of these
/// (powers of two) leaves its entries without units. Lengths are measured in the model's, masses in the mean mass.
std::vector<double> unit_scale(const Model& model, const Eq14Layout& layout);

/// Constructor: pattern of eq. 14 and symbolic factorisation, once per model. assemble: values. factorise: numeric
/// factorisation. substitute: forward and back substitution, any number of times. `double` only, as SuiteSparse is.
class Eq14Formulation : public Formulation<double> {
 public:
  Eq14Formulation(const Model& model, const Eq14Settings& settings);

  void assemble(const System<double>& system) final;
  Outcome factorise(const System<double>& system) override;
  void substitute(const System<double>& system, const RightHandSide<double>& rhs, Solution<double>& solution) final;
  std::optional<LibraryStatistics> statistics() const final;

  /// What the solver gets and what it made of it; for tests and experiments.
  const Eq14Matrix<double>& matrix() const { return matrix_; }
  const SparseSolver& solver() const { return *solver_; }

 private:
  SparseView view() const;
  /// " at body 'x'", to be put into a message; empty when the column is not known.
  std::string place(int column) const;

  Eq14Matrix<double> matrix_;
  bool fixed_pivots_;
  std::unique_ptr<SparseSolver> solver_;
  std::vector<double> b_, x_;
};

/// The objections all of them share: no bodies, or too many entries.
std::optional<std::string> eq14_objection(const Model& model);

}  // namespace lanc
