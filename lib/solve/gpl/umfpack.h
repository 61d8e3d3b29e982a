#pragma once

#include "lib/solve/sparse_solver.h"

namespace lanc {

/// UMFPACK: unsymmetric multifrontal LU (Davis 2004, ACM TOMS 30:196). GPL.
///
/// `as_given` and `amd` prefer pivots on the diagonal (symmetric strategy), at least pivot_tolerance times the largest
/// of their column; `library` leaves the strategy, the order and the tolerances to UMFPACK. The numeric object cannot
/// be refilled: factorise() allocates, solve() does not. Throws std::bad_alloc.
std::unique_ptr<SparseSolver> make_umfpack(const SparseView& sample, const SparseOptions& options);

}  // namespace lanc
