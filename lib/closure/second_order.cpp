#include "lib/closure/second_order.h"

#include <cmath>

#include "lib/closure/curvature.h"
#include "lib/closure/rank.h"
#include "lib/closure/scaling.h"
#include "lib/solve/dense.h"
#include "lib/system/closure_jacobian.h"

namespace lanc {

ClosureDecomposition decompose_closures(const System<double>& system, int rank) {
  const ClosureScaling scaling(system.model);
  ClosureJacobian<double> jacobian(system.model);
  jacobian.evaluate(system);
  const int rows = jacobian.rows(), nv = system.model.nv();
  Eigen::MatrixXd G = Eigen::MatrixXd::Zero(rows, nv);
  for (int k = 0; k < rows; ++k)
    for (int p = jacobian.starts()[k]; p < jacobian.starts()[k + 1]; ++p) {
      const int c = jacobian.columns()[p];
      G(k, c) = jacobian.values()[p] * scaling.row[k] * scaling.column[c];
    }
  ClosureDecomposition result;
  if (rows == 0 || nv == 0) {
    result.U.setIdentity(rows, rows);
    result.V.setIdentity(nv, nv);
    return result;
  }
  SingularValues svd = singular_values(G, SingularVectors::full);
  result.U = std::move(svd.U), result.V = std::move(svd.V), result.sigma = std::move(svd.sigma);
  const double zero = zero_singular_value * std::max(1.0, result.sigma[0]);
  result.rank = rank >= 0 ? rank : static_cast<int>((result.sigma.array() > zero).count());
  return result;
}

SecondOrder::SecondOrder(const Model& model, const State<double>& state, const ClosureDecomposition& decomposition)
    : kernel_(decomposition.kernel()) {
  constexpr double rounding = 1e-7;  // of forms that consist of unit vectors and lengths divided by the model's
  const ClosureScaling scaling(model);
  const Eigen::MatrixXd left = decomposition.left_kernel();
  const int d = static_cast<int>(kernel_.cols()), conditions = static_cast<int>(left.cols());
  ClosureCurvature curvature(model);
  const auto projected = [&](const Eigen::VectorXd& xi) {
    std::vector<double> v(model.nv());
    for (int k = 0; k < model.nv(); ++k) v[k] = xi[k] * scaling.column[k];
    const std::vector<double> rows = curvature(state, v);
    Eigen::VectorXd scaled(left.rows());
    for (int k = 0; k < scaled.size(); ++k) scaled[k] = rows[k] * scaling.row[k];
    return Eigen::VectorXd(left.transpose() * scaled);
  };
  if (conditions == 0 || d == 0) return;
  std::vector<Eigen::MatrixXd> forms(conditions, Eigen::MatrixXd::Zero(d, d));
  Eigen::MatrixXd diagonal(conditions, d);
  for (int i = 0; i < d; ++i) diagonal.col(i) = projected(kernel_.col(i));
  for (int i = 0; i < d; ++i)
    for (int j = i; j < d; ++j) {  // polarisation: 2 Q(x, y) = Q(x+y) − Q(x) − Q(y)
      const Eigen::VectorXd value =
          i == j
              ? Eigen::VectorXd(diagonal.col(i))
              : Eigen::VectorXd((projected(kernel_.col(i) + kernel_.col(j)) - diagonal.col(i) - diagonal.col(j)) / 2);
      for (int k = 0; k < conditions; ++k) forms[k](i, j) = forms[k](j, i) = value[k];
    }
  for (Eigen::MatrixXd& form : forms)
    if (form.cwiseAbs().maxCoeff() > rounding) forms_.push_back(std::move(form));
}

std::vector<Eigen::VectorXd> SecondOrder::tangents(int starts) const {
  std::vector<Eigen::VectorXd> result;
  const int d = static_cast<int>(kernel_.cols());
  std::vector<Eigen::VectorXd> zeros;
  if (forms_.empty())
    for (int k = 0; k < d; ++k) zeros.push_back(Eigen::VectorXd::Unit(d, k));
  else if (d == 2)
    zeros = zeros_in_plane();
  else if (d > 2)
    zeros = search_zeros(starts);
  for (const Eigen::VectorXd& x : zeros) result.push_back(kernel_ * x);
  return result;
}

/// Zeros of a binary quadratic form, of those the ones that all forms share.
std::vector<Eigen::VectorXd> SecondOrder::zeros_in_plane() const {
  const auto largest = std::max_element(forms_.begin(), forms_.end(), [](const auto& a, const auto& b) {
    return a.cwiseAbs().maxCoeff() < b.cwiseAbs().maxCoeff();
  });
  // In the axes of the form, λ₀ x² + λ₁ y² = 0.
  const SymmetricEigen axes = symmetric_eigen(*largest);
  const double a = axes.values[0], b = axes.values[1], scale = std::max(std::abs(a), std::abs(b));
  constexpr double rounding = 1e-9;
  if (a > rounding * scale || b < -rounding * scale) return {};  // definite: no real zero
  const double slope = std::sqrt(std::max(0.0, -a)), other = std::sqrt(std::max(0.0, b));
  std::vector<Eigen::VectorXd> zeros;
  for (const double sign : {1.0, -1.0}) {
    Eigen::VectorXd x = axes.V.col(0) * other + axes.V.col(1) * (sign * slope);
    x.normalize();
    const bool known = !zeros.empty() && std::abs(std::abs(zeros[0].dot(x)) - 1) < 1e-12;
    const bool shared = std::all_of(forms_.begin(), forms_.end(), [&](const Eigen::MatrixXd& form) {
      return std::abs(x.dot(form * x)) < 1e-7 * scale;
    });
    if (!known && shared) zeros.push_back(x);
  }
  return zeros;
}

/// Gauss-Newton on the sphere, from directions spread over it.
std::vector<Eigen::VectorXd> SecondOrder::search_zeros(int starts) const {
  const int d = static_cast<int>(kernel_.cols()), m = static_cast<int>(forms_.size());
  std::vector<Eigen::VectorXd> zeros;
  for (int start = 0; start < starts; ++start) {
    Eigen::VectorXd x(d);
    for (int k = 0; k < d; ++k) x[k] = std::sin(1.0 + 1.7 * (k + 1) + 2.9 * start * (k + 2) + 0.3 * start * start);
    x.normalize();
    double error = 1;
    for (int step = 0; step < 60 && error > 1e-14; ++step) {
      Eigen::VectorXd value(m + 1);
      Eigen::MatrixXd slope(m + 1, d);
      for (int k = 0; k < m; ++k) {
        const Eigen::VectorXd Qx = forms_[k] * x;
        value[k] = x.dot(Qx);
        slope.row(k) = 2 * Qx.transpose();
      }
      value[m] = 0, slope.row(m) = x.transpose();
      error = value.cwiseAbs().maxCoeff();
      x -= least_squares(slope, value);
      if (!x.allFinite() || x.norm() == 0) break;
      x.normalize();
    }
    if (!(error < 1e-10)) continue;
    const bool known = std::any_of(zeros.begin(), zeros.end(),
                                   [&](const Eigen::VectorXd& z) { return std::abs(std::abs(z.dot(x)) - 1) < 1e-8; });
    if (!known) zeros.push_back(x);
  }
  return zeros;
}

}  // namespace lanc
