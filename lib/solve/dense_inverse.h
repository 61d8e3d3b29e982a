// The inverse of a symmetric positive definite matrix and products, on plain arrays, column after column; no memory is
// taken but Eigen's own scratch for products above 128 KiB. Private to the library.
#pragma once

namespace lanc {

/// A⁻¹ in place by Gauss-Jordan elimination (symmetric sweeps), from the last row to the first. Reads the lower
/// triangle, writes all of A. Rows of zeros in a pivot's column cost nothing, so that a mass matrix, in which nobody
/// moves with the bodies of another branch, costs n · depth² at the beginning. n³ operations. scratch: n numbers.
/// False when A is not positive definite; A is then not usable. Tested by tests/lib/dense_algebra_test.cpp.
[[nodiscard]] bool invert_from_last(double* A, int n, double* scratch);

/// C = factor · A B for A of rows × inner, B of inner × columns.
void multiply(int rows, int inner, int columns, double factor, const double* A, const double* B, double* C);

}  // namespace lanc
