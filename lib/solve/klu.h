#pragma once

#include "lib/solve/sparse_solver.h"

namespace lanc {

/// KLU: left-looking LU, column by column (Davis & Palamadai Natarajan 2010, ACM TOMS 37:36). LGPL.
///
/// `as_given`: no block triangular form, no scaling. With pivot_tolerance 0 the pivots are the listed ones (on the
/// diagonal, if none are listed), found once for the sample; factorise() then repeats the arithmetic (klu_refactor) and
/// allocates nothing. With a positive tolerance pivots of one state can be useless at the next, hence factorise() looks
/// for new ones (klu_factor), which allocates. `amd`: AMD without block triangular form. `library`: KLU's defaults
/// (BTF, AMD, row scaling). Symmetric matrices are solved with the transposed factors, which is the same and faster.
/// Throws std::bad_alloc.
std::unique_ptr<SparseSolver> make_klu(const SparseView& sample, const SparseOptions& options);

}  // namespace lanc
