// L D Lᵀ on scalars CHOLMOD does not know, for a matrix whose order is a perfect elimination order.
#pragma once

#include <vector>

namespace lanc {

/// The same elimination as CHOLMOD's simplicial LDLᵀ, row by row; same operations, as a test shows. The columns of the
/// upper triangle (rows ascending) are the rows of L, since nothing fills. Allocates in the constructor only.
template <class S>
class NoFillLdl {
 public:
  NoFillLdl(const std::vector<int>& starts, const std::vector<int>& rows)
      : matrix_starts_(starts), matrix_rows_(rows), starts_(starts.size(), 0), counts_(starts.size() - 1) {
    const int n = size();
    for (int k = 0; k < n; ++k)
      for (int p = starts[k]; p < starts[k + 1]; ++p)
        if (rows[p] != k) ++starts_[rows[p] + 1];
    for (int k = 0; k < n; ++k) starts_[k + 1] += starts_[k];
    rows_.resize(starts_[n]), L_.resize(starts_[n]), D_.resize(n), work_.resize(n);
  }

  void factorise(const std::vector<S>& values) {
    const int n = size();
    counts_.assign(n, 0);
    for (int k = 0; k < n; ++k) {
      const int first = matrix_starts_[k], last = matrix_starts_[k + 1] - 1;  // the diagonal stands last
      for (int p = first; p < last; ++p) work_[matrix_rows_[p]] = values[p];
      S d = values[last];
      for (int p = first; p < last; ++p) {
        const int i = matrix_rows_[p];
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
  std::vector<int> matrix_starts_, matrix_rows_, starts_, counts_, rows_;
  std::vector<S> L_, D_, work_;
};

}  // namespace lanc
