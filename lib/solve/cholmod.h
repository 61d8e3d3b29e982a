#pragma once

#include <span>

#include "lib/solve/sparse_solver.h"

namespace lanc {

/// L D Lᵀ as plain arrays, valid until the next factorisation. Column j of the factor is
/// [starts[j], starts[j] + counts[j]) of rows and values: first D_j (row j), then the entries of L below, rows
/// ascending.
struct LdlFactors {
  std::span<const int> starts, counts, order;  // order[j]: column of the matrix eliminated j-th
  const int* rows = nullptr;
  const double* values = nullptr;
};

/// CHOLMOD's simplicial LDLᵀ (Chen, Davis, Hager & Rajamanickam 2008, ACM TOMS 35:22), LGPL; its supernodal part, under
/// the GPL, is never called. The matrix is the upper triangle of a symmetric one. No pivoting: the order must be one in
/// which every pivot differs from zero. factorise() and solve() allocate nothing when the order is as_given.
/// `library` is CHOLMOD's choice among AMD and what else it was built with.
class CholmodSolver : public SparseSolver {
 public:
  virtual LdlFactors factors() const = 0;
};

/// Throws std::bad_alloc.
std::unique_ptr<CholmodSolver> make_cholmod(const SparseView& sample, const SparseOptions& options);

}  // namespace lanc
