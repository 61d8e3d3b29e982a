// What the direct solvers of SuiteSparse have in common. One file each beside this one (those under the GPL in gpl/);
// no type of SuiteSparse shows in any header.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace lanc {

/// A square matrix by columns (rows ascending in each), owned by somebody else.
struct SparseView {
  int size = 0;
  const int* starts = nullptr;  // size + 1
  const int* rows = nullptr;
  const double* values = nullptr;

  int nonzeros() const { return starts[size]; }
};

/// Who orders the elimination.
enum class EliminationOrder : unsigned char {
  as_given,  // nobody: columns from left to right
  amd,       // approximate minimum degree
  library    // whatever the library does when nothing is asked of it
};

struct SparseOptions {
  EliminationOrder order = EliminationOrder::as_given;
  bool symmetric = false;  // the matrix is its own transpose, in pattern and values
  /// With `as_given`, where a library takes them (KLU): the row and the column eliminated k-th; empty: from left to
  /// right.
  std::vector<int> pivot_rows, pivot_columns;
  /// Least size of a pivot relative to the largest candidate; 0 takes the diagonal whatever its size. Not used by
  /// factorisations that do not pivot (CHOLMOD) or always find a good one (SPQR).
  double pivot_tolerance = 0;
  bool refine = false;  // iterative refinement inside the library, where it has one (UMFPACK)
  /// Row and column k are multiplied by scale[k] where a library decides a rank (SPQR); empty: by 1.
  std::vector<double> scale;
};

/// How a factorisation ended.
struct Factorisation {
  enum class Result : unsigned char { done, singular, failed };
  Result result = Result::done;
  int column = -1;          // of the matrix, where it broke down; −1 unknown
  std::string_view reason;  // for `failed`: what the library says
};

/// What a library reports of the last factorisation. NaN where it has no counter.
struct FactorStatistics {
  std::int64_t nonzeros = 0;  // of the factors, diagonals once
  std::int64_t bytes = 0;     // held by the library
  double factorise_flops = std::numeric_limits<double>::quiet_NaN();
  double solve_flops = std::numeric_limits<double>::quiet_NaN();
};

/// Bound to a pattern when made: symbolic work, and one factorisation of sample values that makes the library allocate
/// what it needs. One object per thread.
class SparseSolver {
 public:
  virtual ~SparseSolver() = default;
  SparseSolver() = default;
  SparseSolver(const SparseSolver&) = delete;
  SparseSolver& operator=(const SparseSolver&) = delete;

  /// New values on the same pattern.
  virtual Factorisation factorise(const SparseView& matrix) = 0;
  /// x from b with the factors of the last factorise(); b may be overwritten.
  virtual void solve(const SparseView& matrix, std::vector<double>& b, std::vector<double>& x) = 0;
  virtual FactorStatistics statistics() const = 0;
  /// Rows and columns in the order of elimination: entry k is the row (column) of the matrix eliminated k-th.
  virtual void elimination(std::vector<int>& rows, std::vector<int>& columns) const = 0;
};

}  // namespace lanc
