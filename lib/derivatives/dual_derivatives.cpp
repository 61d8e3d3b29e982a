#include <cmath>

#include "lib/derivatives/closure_outcome.h"
#include "lib/derivatives/forward_derivatives.h"
#include "lib/derivatives/motion_derivatives.h"
#include "lib/solve/dense.h"
#include "lib/solve/dense_algebra.h"
#include "lib/system/mass_matrix.h"

namespace lanc {
namespace {
using Matrix = Eigen::MatrixXd;
}

DualDerivatives::DualDerivatives(const Model& model, const Loads<double>& loads)
    : model_(model), differentiator_(std::make_unique<Differentiator>(model, loads)) {
  if (model.has_closures()) rank_ = std::make_unique<ClosureRank<double>>(model);
}

DualDerivatives::~DualDerivatives() = default;

Outcome DualDerivatives::at(const System<double>& system, const State<double>& state, const Solution<double>& solution,
                            RankPolicy policy) {
  const int n = model_.nv(), nq = model_.nq();
  Outcome outcome;
  std::vector<double> lambda = solution.lambda;
  std::vector<int>& rows = result_.independent;
  Matrix G(0, n);
  if (rank_) {
    const ClosureDecision& decision = rank_->decide(system, policy);
    outcome = closure_outcome(decision);
    if (!outcome.usable()) return outcome;
    rows.clear();
    for (std::size_t k = 0; k < lambda.size(); ++k)
      if (decision.independent[k]) rows.push_back(static_cast<int>(k));
    const Matrix all = differentiator_->at(state, solution.vdot, lambda).velocity.rightCols(n);
    G = chosen_rows<double>(all, rows);
    const Eigen::VectorXd reaction = all.transpose() * Eigen::Map<const Eigen::VectorXd>(lambda.data(), all.rows());
    const Eigen::VectorXd those = least_squares(G.transpose(), reaction);
    std::fill(lambda.begin(), lambda.end(), 0.0);
    for (std::size_t k = 0; k < rows.size(); ++k) lambda[rows[k]] = those[static_cast<Eigen::Index>(k)];
  }
  const auto r = static_cast<Eigen::Index>(rows.size());
  const MotionDerivatives& d = differentiator_->at(state, solution.vdot, lambda);

  const std::vector<double> mass = mass_matrix(system);
  Matrix K(n + r, n + r), rhs = Matrix::Zero(n + r, 3 * n);
  K.setZero();
  K.topLeftCorner(n, n) = Eigen::Map<const Matrix>(mass.data(), n, n);
  K.topRightCorner(n, r) = -G.transpose();
  K.bottomLeftCorner(r, n) = G;
  const Matrix H = d.coordinate_rate.rightCols(n), acceleration = chosen_rows<double>(d.acceleration, rows);
  rhs.topLeftCorner(n, n) = -product<double>(d.balance.leftCols(nq), H);
  rhs.block(0, n, n, n) = -d.balance.rightCols(n);
  rhs.topRightCorner(n, n).setIdentity();
  rhs.bottomLeftCorner(r, n) = -product<double>(acceleration.leftCols(nq), H);
  rhs.block(n, n, r, n) = -acceleration.rightCols(n);
  Lu<double> lu;
  if (n > 0) lu.compute(K);
  const Matrix answer = n > 0 ? lu.solve(rhs) : rhs;

  const auto block = [&](Eigen::Index row, Eigen::Index height, Eigen::Index column, std::vector<double>& result) {
    result.resize(static_cast<std::size_t>(height) * n);
    Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(result.data(), height, n) =
        answer.block(row, column, height, n);
  };
  block(0, n, 0, result_.position), block(n, r, 0, result_.multiplier_position);
  block(0, n, n, result_.velocity), block(n, r, n, result_.multiplier_velocity);
  block(0, n, 2 * n, result_.force), block(n, r, 2 * n, result_.multiplier_force);
  if (!answer.allFinite())
    outcome.status = Status::singular,
    outcome.message = "the equations are singular here, or a force has no derivative";
  return outcome;
}

}  // namespace lanc
