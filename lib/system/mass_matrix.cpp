#include "lib/system/mass_matrix.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>
#include <limits>

#include "lib/system/equations.h"

namespace lanc {

template <class S>
std::vector<double> mass_matrix(const System<S>& system) {
  const int nv = system.model.nv();
  System<S> unloaded = system;
  unloaded.rhs = RightHandSide<S>(system.model);
  Solution<S> unit(system.model);
  std::vector<double> matrix;
  std::vector<S> column;
  matrix.reserve(static_cast<std::size_t>(nv) * static_cast<std::size_t>(nv));
  for (int k = 0; k < nv; ++k) {
    unit.vdot[k] = S(1.0);
    inverse_dynamics(unloaded, unit, column);
    unit.vdot[k] = S(0.0);
    for (const S& x : column) matrix.push_back(to_double(x));
  }
  return matrix;
}

template std::vector<double> mass_matrix(const System<double>&);
template std::vector<double> mass_matrix(const System<long double>&);
template std::vector<double> mass_matrix(const System<Count>&);

namespace {

Eigen::Map<const Eigen::MatrixXd> square(const std::vector<double>& matrix) {
  const auto n = static_cast<Eigen::Index>(std::lround(std::sqrt(static_cast<double>(matrix.size()))));
  return {matrix.data(), n, n};
}

}  // namespace

double equilibrated_condition(const std::vector<double>& matrix) {
  constexpr double infinite = std::numeric_limits<double>::infinity();
  const auto M = square(matrix);
  const Eigen::Index n = M.rows();
  if (n == 0) return 1;
  if (!M.allFinite() || !(M.diagonal().minCoeff() > 0)) return infinite;
  const Eigen::VectorXd scale = M.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd scaled = scale.asDiagonal() * M * scale.asDiagonal();
  const Eigen::VectorXd values =
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(scaled, Eigen::EigenvaluesOnly).eigenvalues();
  return values[0] > 0 ? values[n - 1] / values[0] : infinite;
}

namespace {

/// The same mechanism with inertias that are as large and positive definite: what M̄ is made of before anything cancels.
template <class S>
System<S> without_cancellation(System<S> system) {
  for (auto& body : system.bodies) {
    const auto& [mass, h, J] = body.inertia;
    S size(0.0);
    for (const S& x : {J.xx, J.yy, J.zz, J.xy, J.xz, J.yz}) size += S(std::abs(to_double(x)));
    if (to_double(mass) != 0) size += dot(h, h) / mass;
    const S none(0.0);
    body.inertia = {mass, {none, none, none}, {size, size, size, none, none, none}};
  }
  return system;
}

}  // namespace

template <class S>
bool regular_but_indefinite(const System<S>& system) {
  const std::vector<double> matrix = mass_matrix(system), bound = mass_matrix(without_cancellation(system));
  const auto M = square(matrix);
  const Eigen::Index n = M.rows();
  if (n == 0 || !M.allFinite() || !(square(bound).diagonal().minCoeff() > 0)) return false;
  // Units do not matter then, and rounding errors are of the size of ε.
  const Eigen::VectorXd scale = square(bound).diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd scaled = scale.asDiagonal() * M * scale.asDiagonal();
  if (Eigen::LLT<Eigen::MatrixXd>(scaled).info() == Eigen::Success) return false;
  const double noise = 16 * std::numeric_limits<double>::epsilon() * static_cast<double>(n);
  const Eigen::PartialPivLU<Eigen::MatrixXd> lu(scaled);
  return scaled.cwiseAbs().maxCoeff() > noise && lu.rcond() > noise;
}

template bool regular_but_indefinite(const System<double>&);
template bool regular_but_indefinite(const System<long double>&);
template bool regular_but_indefinite(const System<Count>&);

}  // namespace lanc
