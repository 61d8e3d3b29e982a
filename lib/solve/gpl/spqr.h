#pragma once

#include "lib/solve/sparse_solver.h"

namespace lanc {

/// SuiteSparseQR: multifrontal Householder QR (Davis 2011, ACM TOMS 38:8). GPL.
///
/// The matrix is multiplied by options.scale and then equilibrated (by powers of two), so that the rank decision does
/// not depend on units; `singular` when a column of R then vanishes to 1e-13. `as_given`: columns from left to right;
/// `amd`: AMD on AᵀA; `library`: SPQR's choice. factorise() and solve() allocate (malloc). Throws std::bad_alloc.
std::unique_ptr<SparseSolver> make_spqr(const SparseView& sample, const SparseOptions& options);

}  // namespace lanc
