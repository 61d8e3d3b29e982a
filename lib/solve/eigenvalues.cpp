#include "lib/solve/eigenvalues.h"

#include <fmt/format.h>
#include <lapacke.h>

#include <algorithm>
#include <stdexcept>

namespace lanc {

std::vector<std::complex<double>> quadratic_eigenvalues(const Eigen::MatrixXd& M, const Eigen::MatrixXd& C,
                                                        const Eigen::MatrixXd& K) {
  const Eigen::Index n = M.rows();
  if (n == 0) return {};
  // [0, 1; −K, −C] x = s [1, 0; 0, M] x
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(2 * n, 2 * n), B = Eigen::MatrixXd::Identity(2 * n, 2 * n);
  A.topRightCorner(n, n).setIdentity();
  A.bottomLeftCorner(n, n) = -K;
  A.bottomRightCorner(n, n) = -C;
  B.bottomRightCorner(n, n) = M;
  const auto size = static_cast<lapack_int>(2 * n);
  Eigen::VectorXd re(2 * n), im(2 * n), under(2 * n);
  const lapack_int info = LAPACKE_dggev(LAPACK_COL_MAJOR, 'N', 'N', size, A.data(), size, B.data(), size, re.data(),
                                        im.data(), under.data(), nullptr, 1, nullptr, 1);
  if (info != 0) throw std::runtime_error(fmt::format("LAPACK's dggev does not converge (info {})", info));
  std::vector<std::complex<double>> result;
  const double zero = 1e-14 * under.cwiseAbs().maxCoeff();
  for (Eigen::Index k = 0; k < 2 * n; ++k)
    if (std::abs(under[k]) > zero) result.emplace_back(re[k] / under[k], im[k] / under[k]);
  std::sort(result.begin(), result.end(), [](const auto& a, const auto& b) {
    return a.imag() != b.imag() ? a.imag() < b.imag() : a.real() < b.real();
  });
  return result;
}

}  // namespace lanc
