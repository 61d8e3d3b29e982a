// Eigenvalues of small motions, by LAPACK's QZ algorithm. Private to the library.
#pragma once

#include <Eigen/Core>
#include <complex>
#include <vector>

namespace lanc {

/// All finite s with det(M s² + C s + K) = 0, ascending by imaginary, then real part. M may be singular. By dggev on
/// the companion form, O(n³). Throws std::runtime_error when the iteration does not converge.
std::vector<std::complex<double>> quadratic_eigenvalues(const Eigen::MatrixXd& M, const Eigen::MatrixXd& C,
                                                        const Eigen::MatrixXd& K);

}  // namespace lanc
