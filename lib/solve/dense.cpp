#include "lib/solve/dense.h"

#include <lapacke.h>

#include <limits>
#include <stdexcept>

template class Eigen::ColPivHouseholderQR<Eigen::MatrixXd>;
template class Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd>;
template class Eigen::HouseholderQR<Eigen::MatrixXd>;
template class Eigen::LLT<Eigen::MatrixXd>;
template class Eigen::PartialPivLU<Eigen::MatrixXd>;
template class Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>;

namespace lanc {
namespace {

Eigen::Index columns(SingularVectors vectors, Eigen::Index thin, Eigen::Index full) {
  return vectors == SingularVectors::none ? 0 : vectors == SingularVectors::thin ? thin : full;
}

SingularValues decompose(const Eigen::MatrixXd& A, SingularVectors left, SingularVectors right) {
  const Eigen::Index m = A.rows(), n = A.cols(), k = std::min(m, n);
  SingularValues result;
  result.sigma.setConstant(k, std::numeric_limits<double>::quiet_NaN());
  result.U.setIdentity(m, columns(left, k, m));
  Eigen::MatrixXd Vt = Eigen::MatrixXd::Identity(columns(right, k, n), n);
  if (k > 0 && A.allFinite()) {
    Eigen::MatrixXd work = A;  // is overwritten
    Eigen::VectorXd superdiagonal(k);
    const auto stride = [](const Eigen::MatrixXd& X) {
      return static_cast<lapack_int>(std::max<Eigen::Index>(1, X.rows()));
    };
    const lapack_int info =
        LAPACKE_dgesvd(LAPACK_COL_MAJOR, static_cast<char>(left), static_cast<char>(right), static_cast<lapack_int>(m),
                       static_cast<lapack_int>(n), work.data(), stride(work), result.sigma.data(), result.U.data(),
                       static_cast<lapack_int>(m), Vt.data(), stride(Vt), superdiagonal.data());
    if (info != 0) throw std::runtime_error("singular values: the iteration of dgesvd did not converge");
  }
  result.V = Vt.transpose();
  return result;
}

}  // namespace

Eigen::VectorXd SingularValues::solve(const Eigen::VectorXd& b, double zero) const {
  const Eigen::Index rank = (sigma.array() > zero).count();
  return V.leftCols(rank) * (U.leftCols(rank).transpose() * b).cwiseQuotient(sigma.head(rank));
}

SingularValues singular_values(const Eigen::MatrixXd& A, SingularVectors vectors) {
  return decompose(A, vectors, vectors);
}

SingularValues left_singular_values(const Eigen::MatrixXd& A, SingularVectors vectors) {
  return decompose(A, vectors, SingularVectors::none);
}

}  // namespace lanc
