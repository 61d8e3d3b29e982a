// Dense decompositions of matrices of double, each compiled once (Eigen's would cost every file that uses one up to a
// minute of compilation): singular values by LAPACK, the others by Eigen. Private to the library.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace lanc {

/// A symmetric matrix, V diag(values) Vᵀ, values ascending.
struct SymmetricEigen {
  Eigen::VectorXd values;
  Eigen::MatrixXd V;
};
SymmetricEigen symmetric_eigen(const Eigen::MatrixXd& A);
/// The values alone.
Eigen::VectorXd symmetric_eigenvalues(const Eigen::MatrixXd& A);
/// An estimate of 1 / (|A| |A⁻¹|) in the 1-norm, from LU of a square matrix.
double reciprocal_condition(const Eigen::MatrixXd& A);
/// A⁻¹ B of a square matrix, by LU with full pivoting.
Eigen::MatrixXd solve_fully_pivoted(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B);
/// The x of least norm that minimises |A x − b|, by a complete orthogonal decomposition; pivots up to `zero` times the
/// largest are taken for zero, up to rounding errors where nothing is said.
Eigen::VectorXd least_squares(const Eigen::MatrixXd& A, const Eigen::VectorXd& b, double zero = -1);
/// The columns of A in the order in which QR with pivoting takes them: the best to express all others by come first.
std::vector<int> pivot_order(const Eigen::MatrixXd& A);

/// Which singular vectors are wanted: none, those of the singular values, or an orthonormal basis of the whole space.
enum class SingularVectors : char { none = 'N', thin = 'S', full = 'A' };

/// A = U diag(sigma) Vᵀ, sigma descending.
struct SingularValues {
  Eigen::VectorXd sigma;  // min(rows, columns)
  Eigen::MatrixXd U, V;   // empty where not wanted

  /// The x of least norm that minimises |A x − b|, singular values up to `zero` taken for zero. Needs vectors.
  Eigen::VectorXd solve(const Eigen::VectorXd& b, double zero) const;
};

/// By dgesvd. Eigen's own divide and conquer (3.4.0) reads outside of its arrays for some matrices that lack rank.
/// Where A is not finite, sigma is NaN and the vectors are those of the identity. Throws std::runtime_error when the
/// iteration does not converge. O(rows · columns · min).
SingularValues singular_values(const Eigen::MatrixXd& A, SingularVectors vectors = SingularVectors::none);
/// U only: left singular vectors.
SingularValues left_singular_values(const Eigen::MatrixXd& A, SingularVectors vectors);

}  // namespace lanc
