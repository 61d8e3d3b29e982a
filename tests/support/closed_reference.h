// Closed loops in long double by singular values: the oracle of formulations on loops. Uses the rows of System and
// nothing of lib/closure, so that a wrong decision there shows.
#pragma once

#include "tests/support/naive.h"

namespace lanc::test {

struct ClosedReference {
  Solution<long double> solution;  // λ of minimum norm in the scaled rows
  int rank = 0;
  double sigma = 0, next_sigma = 0;  // σ_r and σ_{r+1} of the scaled G
  double contradiction = 0;          // largest scaled part of γ̿ outside the range of G, relative to its terms
  double kernel_condition = 1;       // of Zᵀ H Z, equilibrated; infinite: no unique answer; at most 1e19 otherwise
  double schur_condition = 1;  // of the equilibrated G H⁻¹ Gᵀ of the conditions that count; infinite: H singular
  /// Components of f̂ that no self-stress changes, per body; rows likewise.
  std::vector<std::array<bool, 6>> unique;
  std::vector<bool> unique_row;
};

/// Cubic in long double: up to some hundred velocities.
ClosedReference solve_closed_naively(const System<long double>& system);

/// Largest difference of reactions in unique components, in N (moments divided by the model's length).
double reaction_error(const ClosedReference& reference, const Solution<double>& solution, const Model& model);

}  // namespace lanc::test
