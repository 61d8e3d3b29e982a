#include "lib/solve/dense_inverse.h"

#include <Eigen/Core>

namespace lanc {

bool invert_from_last(double* A, int n, double* scratch) {
  const auto column = [=](int j) { return A + std::ptrdiff_t(j) * n; };
  double* __restrict b = scratch;  // the pivot's row and column
  for (int k = n - 1; k >= 0; --k) {
    for (int j = 0; j < k; ++j) b[j] = column(j)[k];
    for (int i = k; i < n; ++i) b[i] = column(k)[i];
    const double pivot = b[k];
    if (!(pivot > 0)) return false;
    const double inverse = 1 / pivot;
    b[k] = 0;
    for (int j = 0; j < n; ++j) {
      const double f = b[j] * inverse;
      if (f == 0) continue;
      double* __restrict a = column(j);
      for (int i = j; i < n; ++i) a[i] -= f * b[i];
    }
    for (int j = 0; j < k; ++j) column(j)[k] = b[j] * inverse;
    for (int i = k; i < n; ++i) column(k)[i] = b[i] * inverse;
    column(k)[k] = -inverse;
  }
  // the sweeps leave −A⁻¹
  for (int j = 0; j < n; ++j)
    for (int i = j; i < n; ++i) column(i)[j] = column(j)[i] = -column(j)[i];
  return true;
}

void multiply(int rows, int inner, int columns, double factor, const double* A, const double* B, double* C) {
  using Matrix = Eigen::MatrixXd;
  Eigen::Map<Matrix>(C, rows, columns).noalias() =
      factor * Eigen::Map<const Matrix>(A, rows, inner) * Eigen::Map<const Matrix>(B, inner, columns);
}

}  // namespace lanc
