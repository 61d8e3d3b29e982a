#include "lib/solve/dense.h"

#include <lapacke.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <limits>
#include <stdexcept>

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

Eigen::VectorXd symmetric_eigenvalues(const Eigen::MatrixXd& A) {
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(A, Eigen::EigenvaluesOnly).eigenvalues();
}

double reciprocal_condition(const Eigen::MatrixXd& A) { return Eigen::PartialPivLU<Eigen::MatrixXd>(A).rcond(); }

SymmetricEigen symmetric_eigen(const Eigen::MatrixXd& A) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(A);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

Eigen::MatrixXd solve_fully_pivoted(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B) {
  return Eigen::FullPivLU<Eigen::MatrixXd>(A).solve(B);
}

Eigen::VectorXd least_squares(const Eigen::MatrixXd& A, const Eigen::VectorXd& b, double zero) {
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> solver(A.rows(), A.cols());
  if (zero >= 0) solver.setThreshold(zero);
  return solver.compute(A).solve(b);
}

std::vector<int> pivot_order(const Eigen::MatrixXd& A) {
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(A);
  const auto& order = qr.colsPermutation().indices();
  return {order.data(), order.data() + order.size()};
}

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
