// Dense decompositions of matrices of double: singular values by LAPACK, and Eigen's, compiled once (each would cost
// every file that uses it up to a minute of compilation). Include this instead of <Eigen/QR> and its like where such
// matrices are decomposed. Private to the library.
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>

extern template class Eigen::ColPivHouseholderQR<Eigen::MatrixXd>;
extern template class Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd>;
extern template class Eigen::HouseholderQR<Eigen::MatrixXd>;
extern template class Eigen::LLT<Eigen::MatrixXd>;
extern template class Eigen::PartialPivLU<Eigen::MatrixXd>;
extern template class Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>;

namespace lanc {

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
