// L D Lᵀ on scalars CHOLMOD does not know, in the order of the matrix.
#pragma once

#include <algorithm>
#include <vector>

namespace lanc {

/// The same elimination as CHOLMOD's simplicial LDLᵀ, row by row; same operations, as a test shows. Takes the columns
/// of the upper triangle, rows ascending, the diagonal in each. Where the order is a perfect elimination order they are
/// the rows of L; otherwise L fills. Allocates in the constructor only.
template <class S>
class SparseLdl {
 public:
  SparseLdl(const std::vector<int>& starts, const std::vector<int>& rows)
      : matrix_starts_(starts), matrix_rows_(rows), starts_(starts.size(), 0), counts_(starts.size() - 1) {
    const int n = size();
    find_rows_of_factor();
    for (int k = 0; k < n; ++k)
      for (int p = row_starts_[k]; p < row_starts_[k + 1]; ++p) ++starts_[row_columns_[p] + 1];
    for (int k = 0; k < n; ++k) starts_[k + 1] += starts_[k];
    rows_.resize(starts_[n]), L_.resize(starts_[n]), D_.resize(n), work_.assign(n, S(0.0));
  }

  void factorise(const std::vector<S>& values) {
    const int n = size();
    counts_.assign(n, 0);
    for (int k = 0; k < n; ++k) {
      const int last = matrix_starts_[k + 1] - 1;  // the diagonal stands last
      for (int p = row_starts_[k]; p < row_starts_[k + 1]; ++p) work_[row_columns_[p]] = S(0.0);
      for (int p = matrix_starts_[k]; p < last; ++p) work_[matrix_rows_[p]] = values[p];
      S d = values[last];
      for (int p = row_starts_[k]; p < row_starts_[k + 1]; ++p) {
        const int i = row_columns_[p];
        const S y = work_[i];
        int q = starts_[i];
        for (const int end = q + counts_[i]; q < end; ++q) work_[rows_[q]] -= L_[q] * y;
        const S l = y / D_[i];
        d -= l * y;
        rows_[q] = k, L_[q] = l;
        ++counts_[i];
      }
      D_[k] = d;
    }
  }

  void solve(std::vector<S>& x) const {
    const int n = size();
    for (int k = 0; k < n; ++k)
      for (int q = starts_[k]; q < starts_[k + 1]; ++q) x[rows_[q]] -= L_[q] * x[k];
    for (int k = 0; k < n; ++k) x[k] = x[k] / D_[k];
    for (int k = n - 1; k >= 0; --k)
      for (int q = starts_[k]; q < starts_[k + 1]; ++q) x[k] -= L_[q] * x[rows_[q]];
  }

  int size() const { return static_cast<int>(counts_.size()); }
  const S& pivot(int k) const { return D_[k]; }

 private:
  /// Row k of L has the columns on the paths of the elimination tree from the entries of column k of the matrix upwards
  /// to k (Davis 2006, Direct Methods for Sparse Linear Systems, section 4.2).
  void find_rows_of_factor() {
    const int n = size();
    std::vector<int> parent(n, -1), met(n, -1);
    row_starts_.assign(1, 0);
    for (int k = 0; k < n; ++k) {
      met[k] = k;
      for (int p = matrix_starts_[k]; p < matrix_starts_[k + 1]; ++p)
        for (int i = matrix_rows_[p]; met[i] != k; i = parent[i]) {
          if (parent[i] < 0) parent[i] = k;
          met[i] = k;
          row_columns_.push_back(i);
        }
      std::sort(row_columns_.begin() + row_starts_[k], row_columns_.end());
      row_starts_.push_back(static_cast<int>(row_columns_.size()));
    }
  }

  std::vector<int> matrix_starts_, matrix_rows_, starts_, counts_, rows_;
  std::vector<int> row_starts_, row_columns_;  // of L, without the diagonal
  std::vector<S> L_, D_, work_;
};

}  // namespace lanc
