#include "tests/support/closed_reference.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <array>
#include <cmath>
#include <limits>

namespace lanc::test {
namespace {

using Real = long double;
using Matrix = ReducedSystem::Matrix;
using Vector = ReducedSystem::Vector;

Vector components(const Wrench<Real>& f) {
  Vector x(6);
  x << f.moment.x, f.moment.y, f.moment.z, f.force.x, f.force.y, f.force.z;
  return x;
}

/// G and γ̿ in joint coordinates, straight from their definition; and the sum of all terms of γ̿ made positive.
void closure_rows(const System<Real>& system, const ReducedSystem& reduced, Matrix& G, Vector& gamma, Vector& size) {
  const Model& model = system.model;
  const int rows = model.closures().rows();
  G = Matrix::Zero(rows, model.nv());
  gamma.resize(rows);
  for (int k = 0; k < rows; ++k) gamma[k] = system.rhs.closure[k];
  size = gamma.cwiseAbs();
  for (const Closure& c : model.closures().closures)
    for (int k = c.row; k < c.row + c.conditions().count; ++k) {
      const auto side = [&](int body, const Wrench<Real>& row) {
        if (body == ground) return;
        G.row(k) += components(row).transpose() * reduced.J.middleRows(6 * body, 6);
        gamma[k] += components(row).dot(reduced.bias.segment(6 * body, 6));
        size[k] += components(row).cwiseAbs().dot(reduced.bias.segment(6 * body, 6).cwiseAbs());
      };
      side(c.body_a, system.closure_rows[k].a), side(c.body_b, system.closure_rows[k].b);
    }
  for (const Coupler& c : model.closures().couplers)
    for (const Coupler::Term& term : c.terms) G(c.row, term.v) += term.factor;
}

/// Condition of a symmetric positive definite matrix scaled to unit diagonal.
double equilibrated_condition(const Matrix& A) {
  constexpr double infinite = std::numeric_limits<double>::infinity();
  if (A.rows() == 0) return 1;
  if (!(A.diagonal().minCoeff() > 0)) return infinite;
  const Vector d = A.diagonal().cwiseSqrt().cwiseInverse();
  const Vector e =
      Eigen::SelfAdjointEigenSolver<Matrix>(d.asDiagonal() * A * d.asDiagonal(), Eigen::EigenvaluesOnly).eigenvalues();
  return e[0] > 0 ? static_cast<double>(e[e.size() - 1] / e[0]) : infinite;
}

/// η̇ and λ of M̄ η̇ − Gᵀλ = b, Gη̇ = −γ̿ with independent rows of G, by LU with full pivoting: where inertias differ by
/// more than the digits of long double, a basis of the kernel of G mixes them and this does not. False: singular.
bool solve_graded(const ReducedSystem& reduced, const Matrix& G, const Vector& gamma, Vector& vdot, Vector& lambda) {
  const Eigen::Index nv = G.cols(), r = G.rows();
  Matrix K = Matrix::Zero(nv + r, nv + r);
  K.topLeftCorner(nv, nv) = reduced.H;
  K.topRightCorner(nv, r) = -G.transpose();
  K.bottomLeftCorner(r, nv) = G;
  Vector b(nv + r);
  b << reduced.b, -gamma;
  Eigen::FullPivLU<Matrix> lu(K);
  lu.setThreshold(0);
  if (!lu.isInvertible()) return false;
  Vector x = lu.solve(b);
  x += lu.solve(b - K * x);
  vdot = x.head(nv), lambda = x.tail(r);
  return true;
}

/// Numbers of `rank` rows that are far from dependent.
std::vector<int> independent_rows(const Matrix& G, int rank) {
  const Eigen::ColPivHouseholderQR<Matrix> qr(G.transpose());
  const auto& order = qr.colsPermutation().indices();
  return {order.data(), order.data() + rank};
}

}  // namespace

ClosedReference solve_closed_naively(const System<Real>& system) {
  const Model& model = system.model;
  const int nv = model.nv(), rows = model.closures().rows();
  const ReducedSystem reduced = reduce_naively(system);
  Matrix G;
  Vector gamma, gamma_size;
  closure_rows(system, reduced, G, gamma, gamma_size);
  // Rows that are lengths and velocities that are lengths in units of the model's (design: README, Decisions)
  Vector R(rows), C(nv);
  for (int k = 0; k < nv; ++k) C[k] = model.column_kind(k) == ColumnKind::translation ? model.length() : 1;
  for (int k = 0; k < rows; ++k) R[k] = model.closures().row_is_length[k] ? 1 / model.length() : 1;
  for (const Coupler& c : model.closures().couplers)
    R[c.row] = 1 / (G.row(c.row) * C.asDiagonal()).cwiseAbs().maxCoeff();
  const Matrix Gs = R.asDiagonal() * G * C.asDiagonal();
  const Eigen::JacobiSVD<Matrix> svd(Gs, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Vector sigma = svd.singularValues();

  ClosedReference result;
  for (int k = 0; k < sigma.size(); ++k) result.rank += sigma[k] > 1e-10L * std::max<Real>(1, sigma[0]);
  const int r = result.rank;
  result.sigma = r > 0 ? static_cast<double>(sigma[r - 1]) : 0;
  result.next_sigma = r < sigma.size() ? static_cast<double>(sigma[r]) : 0;
  const Matrix U = svd.matrixU().leftCols(r), V = svd.matrixV().leftCols(r), U0 = svd.matrixU().rightCols(rows - r),
               Z = C.asDiagonal() * svd.matrixV().rightCols(nv - r);
  const Vector inverse = sigma.head(r).cwiseInverse(), scaled_gamma = R.asDiagonal() * gamma;
  if (const Real size = (R.asDiagonal() * gamma_size).maxCoeff(); U0.cols() > 0 && size > 0)
    result.contradiction = static_cast<double>((U0.transpose() * scaled_gamma).cwiseAbs().maxCoeff() / size);

  Vector vdot = -(C.asDiagonal() * (V * (inverse.asDiagonal() * (U.transpose() * scaled_gamma))));
  const Matrix ZHZ = Z.transpose() * reduced.H * Z;
  result.kernel_condition = equilibrated_condition(ZHZ);
  if (Z.cols() > 0) vdot += Z * Eigen::LDLT<Matrix>(ZHZ).solve(Z.transpose() * (reduced.b - reduced.H * vdot));
  const Vector excess = C.asDiagonal() * (reduced.H * vdot - reduced.b);  // G_sᵀ λ_s
  Vector lambda = R.asDiagonal() * (U * (inverse.asDiagonal() * (V.transpose() * excess)));
  constexpr double graded = 1e12, unknown = 1e19;
  if (!(result.kernel_condition < graded)) {
    const std::vector<int> rows_used = independent_rows(Gs, r);
    Vector some = Vector::Zero(r);
    if (solve_graded(reduced, G(rows_used, Eigen::all), gamma(rows_used), vdot, some)) {
      result.kernel_condition = std::min(result.kernel_condition, unknown);
      Vector scaled = Vector::Zero(rows);
      for (int k = 0; k < r; ++k) scaled[rows_used[k]] = some[k] / R[rows_used[k]];
      lambda = R.asDiagonal() * (U * (U.transpose() * scaled));
    } else {
      result.kernel_condition = std::numeric_limits<double>::infinity();
    }
  }
  result.solution = complete_naively(system, reduced, vdot, lambda);

  const Eigen::LLT<Matrix> cholesky(reduced.H);
  const Matrix counting = U.transpose() * Gs;
  result.schur_condition =
      cholesky.info() == Eigen::Success
          ? equilibrated_condition(counting * C.cwiseInverse().asDiagonal() *
                                   cholesky.solve(C.cwiseInverse().asDiagonal() * counting.transpose()))
          : std::numeric_limits<double>::infinity();

  result.unique.assign(model.bodies(), {true, true, true, true, true, true});
  result.unique_row.assign(rows, true);
  System<Real> unloaded = system;
  unloaded.rhs.set_zero();
  ReducedSystem still = reduced;
  still.bias.setZero();
  for (int mode = 0; mode < U0.cols(); ++mode) {
    const Vector stress = R.asDiagonal() * U0.col(mode);
    const Solution<Real> s = complete_naively(unloaded, still, Vector::Zero(nv), stress);
    for (int k = 0; k < rows; ++k)
      if (std::abs(U0(k, mode)) > 1e-9L) result.unique_row[k] = false;
    for (int i = 0; i < model.bodies(); ++i) {
      const Vector f = components(s.wrench[i]);
      for (int c = 0; c < 6; ++c)
        if (std::abs(f[c]) * (c < 3 ? 1 : model.length()) > 1e-9L) result.unique[i][c] = false;
    }
  }
  return result;
}

double reaction_error(const ClosedReference& reference, const Solution<double>& solution, const Model& model) {
  double worst = 0;
  for (int i = 0; i < model.bodies(); ++i) {
    const Wrench<double>& f = solution.wrench[i];
    const Wrench<long double>& h = reference.solution.wrench[i];
    const long double parts[] = {f.moment.x - h.moment.x, f.moment.y - h.moment.y, f.moment.z - h.moment.z,
                                 f.force.x - h.force.x,   f.force.y - h.force.y,   f.force.z - h.force.z};
    for (int c = 0; c < 6; ++c)
      if (reference.unique[i][c])
        worst = std::max(worst, static_cast<double>(std::abs(parts[c])) / (c < 3 ? model.length() : 1));
  }
  return worst;
}

}  // namespace lanc::test
