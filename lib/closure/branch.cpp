#include "lib/closure/branch.h"

#include <fmt/format.h>

#include <cmath>

#include "lib/closure/curvature.h"
#include "lib/closure/rank.h"
#include "lib/closure/retraction.h"
#include "lib/closure/scaling.h"
#include "lib/solve/dense.h"
#include "lib/system/evaluator.h"

namespace lanc {
namespace {

/// Velocities in SI units from scaled ones.
std::vector<double> velocities(const Model& model, const Eigen::VectorXd& scaled) {
  const ClosureScaling scaling(model);
  std::vector<double> v(model.nv());
  for (int k = 0; k < model.nv(); ++k) v[k] = scaled[k] * scaling.column[k];
  return v;
}

Eigen::VectorXd scaled_violation(const System<double>& system) {
  const ClosureScaling scaling(system.model);
  Eigen::VectorXd g(system.closure_rows.size());
  for (int k = 0; k < g.size(); ++k) g[k] = system.closure_rows[k].g * scaling.row[k];
  return g;
}

/// Back to g = 0 by steps perpendicular to the kernel, σ_1 … σ_rank alone being inverted. The largest part of the way
/// is returned in `distance`.
std::optional<State<double>> corrected(const Model& model, State<double> state, int rank, double& distance) {
  constexpr int most_steps = 12;
  constexpr double tolerance = 1e-13;
  Evaluator<double> evaluator(model);
  distance = 0;
  double last = std::numeric_limits<double>::infinity();
  for (int step = 0; step < most_steps; ++step) {
    const System<double>& system = evaluator.system(state);
    const Eigen::VectorXd g = scaled_violation(system);
    const double error = g.cwiseAbs().maxCoeff();
    if (error == 0 || (error < tolerance && error > last / 2)) return state;
    if (!(error < 10 * last)) return std::nullopt;
    last = error;
    const ClosureDecomposition svd = decompose_closures(system, rank);
    const Eigen::VectorXd move = svd.V.leftCols(rank) * (svd.sigma.head(rank).cwiseInverse().asDiagonal() *
                                                         (svd.U.leftCols(rank).transpose() * g));
    if (!move.allFinite()) return std::nullopt;
    distance = std::max(distance, move.norm());
    state.q = moved(model, state.q, velocities(model, -move));
  }
  return last < 100 * tolerance ? std::optional(state) : std::nullopt;
}

}  // namespace

BranchTracer::BranchTracer(const Model& model, const State<double>& start, int rank, const Eigen::VectorXd& towards)
    : model_(model), rank_(rank) {
  if (model.nv() - rank != 1)
    throw InputError(
        fmt::format("a curve is followed where the mobility is 1; this mechanism has {} velocities and "
                    "{} independent closure conditions",
                    model.nv(), rank));
  here_ = point(start, towards, nullptr);
}

BranchPoint BranchTracer::point(State<double> state, const Eigen::VectorXd& towards, const BranchPoint* before) const {
  Evaluator<double> evaluator(model_);
  const ClosureDecomposition svd = decompose_closures(evaluator.system(state), rank_);
  BranchPoint result;
  result.tangent = svd.V.col(model_.nv() - 1);
  // where the rank drops the last singular vector is any of the kernel: the caller knows the tangent
  const bool singular = !(svd.sigma_at(rank_) > clear_singular_value);
  if (singular && towards.size() > 0) result.tangent = towards.normalized();
  if (towards.size() > 0 && result.tangent.dot(towards) < 0) result.tangent = -result.tangent;
  result.sigma = svd.sigma_at(rank_);
  if (rank_ > 0) result.left = svd.U.col(rank_ - 1), result.right = svd.V.col(rank_ - 1);
  if (before && rank_ > 0 && !singular) {
    const double same = result.left.dot(before->left) * result.right.dot(before->right);
    if ((same < 0) != (before->sigma < 0)) result.sigma = -result.sigma;
  }
  state.v = velocities(model_, result.tangent);
  result.state = std::move(state);
  return result;
}

std::optional<BranchPoint> BranchTracer::at(double h) const {
  if (h == 0) return here_;
  State<double> predicted = here_.state;
  predicted.q = moved(model_, predicted.q, velocities(model_, here_.tangent * h));
  double distance = 0;
  const auto state = corrected(model_, predicted, rank_, distance);
  if (!state || distance > 0.3 * std::abs(h)) return std::nullopt;
  BranchPoint next = point(*state, here_.tangent, &here_);
  if (next.tangent.dot(here_.tangent) < 0.8) return std::nullopt;  // turned by more than 37°: another branch, perhaps
  next.arc = here_.arc + h;
  return next;
}

bool BranchTracer::advance(double h) {
  constexpr int most_halvings = 12;
  for (int k = 0; k <= most_halvings; ++k, h /= 2)
    if (auto next = at(h)) {
      here_ = *std::move(next);
      return true;
    }
  return false;
}

/// Regula falsi with the Illinois modification: brackets, and converges superlinearly.
std::optional<BranchPoint> BranchTracer::locate(double h,
                                                const std::function<double(const BranchPoint&)>& event) const {
  auto right = at(h);
  if (!right) return std::nullopt;
  double a = 0, b = h, fa = event(here_), fb = event(*right);
  if (fa == 0) return here_;
  if (!(fa * fb <= 0)) return std::nullopt;
  BranchPoint best = *std::move(right);
  for (int step = 0; step < 100 && fb != 0 && std::abs(b - a) > 1e-15 * (1 + std::abs(h)); ++step) {
    const double c = b - fb * (b - a) / (fb - fa);
    const auto middle = at(c);
    if (!middle) return std::nullopt;
    const double fc = event(*middle);
    if (fc * fb < 0)
      a = b, fa = fb;
    else
      fa /= 2;
    const bool done = c == b;
    b = c, fb = fc, best = *middle;
    if (done) break;
  }
  return best;
}

std::optional<SingularPoint> locate_singular_point(const Model& model, const State<double>& near, int rank) {
  const ClosureScaling scaling(model);
  const int nv = model.nv(), rows = model.closures().rows();
  State<double> state = near;
  std::fill(state.v.begin(), state.v.end(), 0.0);
  Evaluator<double> evaluator(model);
  ClosureCurvature curvature(model);
  Eigen::VectorXd u = decompose_closures(evaluator.system(state), rank).U.col(rank - 1);
  double last = std::numeric_limits<double>::infinity();
  for (int step = 0; step < 40; ++step) {
    const System<double>& system = evaluator.system(state);
    const ClosureDecomposition svd = decompose_closures(system, rank);
    const int k = static_cast<int>(svd.sigma.size());
    const Eigen::MatrixXd G = svd.U.leftCols(k) * svd.sigma.asDiagonal() * svd.V.leftCols(k).transpose();
    // W = Σ u_k D²g_k, by polarisation
    const auto along = [&](const Eigen::VectorXd& xi) {
      const std::vector<double> c = curvature(state, velocities(model, xi));
      double sum = 0;
      for (int r = 0; r < rows; ++r) sum += u[r] * c[r] * scaling.row[r];
      return sum;
    };
    Eigen::MatrixXd W(nv, nv);
    for (int i = 0; i < nv; ++i) W(i, i) = along(Eigen::VectorXd::Unit(nv, i));
    for (int i = 0; i < nv; ++i)
      for (int j = 0; j < i; ++j)
        W(i, j) = W(j, i) =
            (along(Eigen::VectorXd::Unit(nv, i) + Eigen::VectorXd::Unit(nv, j)) - W(i, i) - W(j, j)) / 2;
    Eigen::VectorXd F(rows + nv + 1);
    F << scaled_violation(system), G.transpose() * u, (u.squaredNorm() - 1) / 2;
    const double error = F.cwiseAbs().maxCoeff();
    if (error == 0 || (error < 1e-12 && error > last / 2)) {
      SingularPoint result{state, decompose_closures(system, rank - 1), {}};
      if (result.decomposition.sigma_at(rank) > clear_singular_value) return std::nullopt;
      result.tangents = SecondOrder(model, state, result.decomposition).tangents();
      return result;
    }
    last = error;
    Eigen::MatrixXd slope = Eigen::MatrixXd::Zero(rows + nv + 1, nv + rows);
    slope.topLeftCorner(rows, nv) = G;
    slope.block(rows, 0, nv, nv) = W;
    slope.block(rows, nv, nv, rows) = G.transpose();
    slope.block(rows + nv, nv, 1, rows) = u.transpose();
    const Eigen::VectorXd move = least_squares(slope, F, 1e-8);
    if (!move.allFinite() || move.head(nv).norm() > 1) return std::nullopt;
    state.q = moved(model, state.q, velocities(model, -move.head(nv)));
    u -= move.tail(rows);
  }
  return std::nullopt;
}

}  // namespace lanc
