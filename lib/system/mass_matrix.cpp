#include "lib/system/mass_matrix.h"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <limits>

#include "lib/system/equations.h"

namespace lanc {

std::vector<double> mass_matrix(const System<double>& system) {
  const int nv = system.model.nv();
  System<double> unloaded = system;
  unloaded.rhs = RightHandSide<double>(system.model);
  Solution<double> unit(system.model);
  std::vector<double> matrix, column;
  matrix.reserve(static_cast<std::size_t>(nv) * static_cast<std::size_t>(nv));
  for (int k = 0; k < nv; ++k) {
    unit.vdot[k] = 1;
    inverse_dynamics(unloaded, unit, column);
    unit.vdot[k] = 0;
    matrix.insert(matrix.end(), column.begin(), column.end());
  }
  return matrix;
}

double equilibrated_condition(const std::vector<double>& matrix) {
  constexpr double infinite = std::numeric_limits<double>::infinity();
  const auto n = static_cast<Eigen::Index>(std::lround(std::sqrt(static_cast<double>(matrix.size()))));
  if (n == 0) return 1;
  const Eigen::Map<const Eigen::MatrixXd> M(matrix.data(), n, n);
  if (!M.allFinite() || !(M.diagonal().minCoeff() > 0)) return infinite;
  const Eigen::VectorXd scale = M.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd scaled = scale.asDiagonal() * M * scale.asDiagonal();
  const Eigen::VectorXd values =
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(scaled, Eigen::EigenvaluesOnly).eigenvalues();
  return values[0] > 0 ? values[n - 1] / values[0] : infinite;
}

}  // namespace lanc
