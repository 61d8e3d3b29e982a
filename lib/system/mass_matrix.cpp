#include "lib/system/mass_matrix.h"

#include <cmath>
#include <limits>
#include <optional>

#include "lib/solve/dense.h"
#include "lib/solve/dense_algebra.h"
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

Eigen::MatrixXd square(const std::vector<double>& matrix) {
  const auto n = static_cast<Eigen::Index>(std::lround(std::sqrt(static_cast<double>(matrix.size()))));
  return Eigen::Map<const Eigen::MatrixXd>(matrix.data(), n, n);
}

/// D M D with D = diag(d)^(-1/2), or nothing where M or d cannot be used so.
std::optional<Eigen::MatrixXd> equilibrated(Eigen::MatrixXd M, const Eigen::MatrixXd& d) {
  if (!M.allFinite()) return std::nullopt;
  Eigen::VectorXd scale(M.rows());
  for (Eigen::Index k = 0; k < M.rows(); ++k) {
    if (!(d(k, k) > 0)) return std::nullopt;
    scale[k] = 1 / std::sqrt(d(k, k));
  }
  scale_both_sides(scale, M);
  return M;
}

}  // namespace

double equilibrated_condition(const std::vector<double>& matrix) {
  constexpr double infinite = std::numeric_limits<double>::infinity();
  if (matrix.empty()) return 1;
  const Eigen::MatrixXd M = square(matrix);
  const auto scaled = equilibrated(M, M);
  if (!scaled) return infinite;
  const Eigen::VectorXd values = symmetric_eigenvalues(*scaled);
  return values[0] > 0 ? values[values.size() - 1] / values[0] : infinite;
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
  if (system.model.nv() == 0) return false;
  // Units do not matter then, and rounding errors are of the size of ε.
  const auto scaled = equilibrated(square(mass_matrix(system)), square(mass_matrix(without_cancellation(system))));
  if (!scaled || Cholesky<double>().compute(*scaled)) return false;
  const double noise = 16 * std::numeric_limits<double>::epsilon() * static_cast<double>(scaled->rows());
  return scaled->cwiseAbs().maxCoeff() > noise && reciprocal_condition(*scaled) > noise;
}

template bool regular_but_indefinite(const System<double>&);
template bool regular_but_indefinite(const System<long double>&);
template bool regular_but_indefinite(const System<Count>&);

}  // namespace lanc
