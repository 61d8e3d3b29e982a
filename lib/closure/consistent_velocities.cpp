#include <fmt/format.h>

#include <cmath>

#include "lib/closure/assembly.h"
#include "lib/closure/components.h"
#include "lib/closure/rank.h"
#include "lib/closure/scaling.h"
#include "lib/solve/dense.h"
#include "lib/solve/dense_algebra.h"
#include "lib/system/closure_jacobian.h"
#include "lib/system/evaluator.h"
#include "lib/system/mass_matrix.h"

namespace lanc {
namespace {

/// Orthonormal combinations of the rows of the scaled G that are independent: `rows` = U_rᵀ G, and U_r.
struct Independent {
  Eigen::MatrixXd U, rows;
};

Independent independent_rows(const Model& model, const ClosureJacobian<double>& jacobian,
                             const ClosureScaling& scaling) {
  Eigen::MatrixXd G = Eigen::MatrixXd::Zero(jacobian.rows(), model.nv());
  for (int k = 0; k < jacobian.rows(); ++k)
    for (int p = jacobian.starts()[k]; p < jacobian.starts()[k + 1]; ++p)
      G(k, jacobian.columns()[p]) = jacobian.values()[p] * scaling.row[k] * scaling.column[jacobian.columns()[p]];
  std::vector<Eigen::VectorXd> directions;
  double largest = 1;
  std::vector<double> sizes;
  for (const ClosureComponent& part : closure_components(jacobian.starts(), jacobian.columns(), model.nv())) {
    if (part.columns.empty()) continue;
    const SingularValues svd = left_singular_values(G(part.rows, part.columns), SingularVectors::thin);
    largest = std::max(largest, svd.sigma[0]);
    for (Eigen::Index k = 0; k < svd.sigma.size(); ++k) {
      Eigen::VectorXd u = Eigen::VectorXd::Zero(jacobian.rows());
      u(part.rows) = svd.U.col(k);
      directions.push_back(std::move(u));
      sizes.push_back(svd.sigma[k]);
    }
  }
  Independent result;
  int rank = 0;
  result.U.resize(jacobian.rows(), static_cast<Eigen::Index>(directions.size()));
  for (std::size_t k = 0; k < directions.size(); ++k)
    if (sizes[k] > zero_singular_value * largest) result.U.col(rank++) = directions[k];
  result.U.conservativeResize(Eigen::NoChange, rank);
  result.rows = result.U.transpose() * G;
  return result;
}

/// Lower factor of the metric in scaled velocities; its upper triangle is not to be read.
Eigen::MatrixXd metric_factor(const System<double>& system, const ClosureScaling& scaling) {
  const int nv = system.model.nv();
  const std::vector<double> mass = mass_matrix(system);
  const Eigen::VectorXd scale = Eigen::Map<const Eigen::VectorXd>(scaling.column.data(), nv);
  Eigen::MatrixXd M = Eigen::Map<const Eigen::MatrixXd>(mass.data(), nv, nv);
  scale_both_sides(scale, M);
  const double mean = M.trace() / nv;
  if (!(mean > 0) || !(equilibrated_condition({M.data(), M.data() + M.size()}) < 1e12))
    M.diagonal().array() += mean > 0 ? mean : 1.0;
  // indefinite inertias are legal (BodySpec::allow_nonphysical_inertia): no metric, so the plain one
  if (!cholesky_in_place(M)) return Eigen::MatrixXd::Identity(nv, nv);
  return M;
}

}  // namespace

VelocityResult consistent_velocities(const Model& model, State<double> state) {
  VelocityResult result;
  result.state = std::move(state);
  const int nv = model.nv();
  if (!model.has_closures()) return result;
  Evaluator<double> evaluator(model);
  const System<double>* system = &evaluator.system(result.state);
  ClosureJacobian<double> jacobian(model);
  jacobian.evaluate(*system);
  const ClosureScaling scaling(model);
  Eigen::VectorXd residual(jacobian.rows());
  const auto measure = [&] {
    double speed = 1;
    for (int k = 0; k < nv; ++k) speed = std::max(speed, std::abs(result.state.v[k]) / scaling.column[k]);
    for (int k = 0; k < jacobian.rows(); ++k) residual[k] = system->closure_rows[k].rate * scaling.row[k];
    result.violation = residual.lpNorm<Eigen::Infinity>() / speed;
  };
  measure();
  if (nv > 0) {
    const Independent independent = independent_rows(model, jacobian, scaling);
    const Eigen::MatrixXd L = metric_factor(*system, scaling);
    // minimum ‖Lᵀ δ‖ with R δ = −Uᵀ residual: Lᵀ δ = Q T⁻ᵀ (…), L⁻¹ Rᵀ = Q T
    Qr<double> qr;
    qr.compute(solve_lower<double>(L, independent.rows.transpose()));
    const Eigen::Index rank = independent.rows.rows();
    const Eigen::MatrixXd T = qr.R(rank);
    for (int pass = 0; pass < 3 && rank > 0; ++pass) {  // the later ones take away rounding errors
      const Eigen::VectorXd wanted = -transposed_product(independent.U, residual);
      if (pass > 0 && wanted.lpNorm<Eigen::Infinity>() < 1e-15) break;
      Eigen::VectorXd y = Eigen::VectorXd::Zero(nv);
      y.head(rank) = solve_upper_transposed(T, wanted);
      const Eigen::VectorXd change = solve_lower_transposed(L, qr.times_Q(y));
      for (int k = 0; k < nv; ++k) result.state.v[k] += change[k] * scaling.column[k];
      result.changed = std::max(result.changed, change.lpNorm<Eigen::Infinity>());
      system = &evaluator.system(result.state);
      measure();
    }
  }
  constexpr double tolerance = 1e-10;                 // redundant rows of a state good to 1e-12 leave this much
  result.consistent = result.violation <= tolerance;  // false for NaN
  if (!result.consistent) {
    Eigen::Index worst = 0;
    residual.cwiseAbs().maxCoeff(&worst);
    result.message = fmt::format(
        "no velocities satisfy all closures: '{}' is left with {:.3g} {}; a prescribed motion cannot be followed here",
        model.closures().row_names[worst], residual[worst] / scaling.row[worst],
        model.closures().row_is_length[worst] ? "m/s" : "rad/s");
  }
  return result;
}

}  // namespace lanc
