#include "lib/integrate/residual_form.h"

#include "lib/solve/dense.h"
#include "lib/system/equations.h"
#include "lib/system/mass_matrix.h"

namespace lanc {

ResidualForm::ResidualForm(MotionSolver& solver)
    : FullCoordinates(solver, Stabilisation::none, 0),
      solver_(solver),
      rank_(solver.model()),
      evaluator_(solver.model()),
      jacobian_(solver.model()),
      differentiator_(solver.model(), solver.loads()),
      solution_(solver.model()),
      tau_(solver.model().nv()) {}

Outcome ResidualForm::start(const State<double>& state, Eigen::VectorXd& vdot, Eigen::VectorXd& lambda) {
  outcome_ = solver_.solve(state);
  if (!outcome_.usable()) return outcome_;
  const Solution<double>& solution = solver_.solution();
  vdot = Eigen::Map<const Eigen::VectorXd>(solution.vdot.data(), model().nv());
  rows_.clear();
  if (model().has_closures()) {
    const std::vector<char>& independent = rank_.decide(solver_.system(), solver_.policy()).independent;
    for (std::size_t k = 0; k < independent.size(); ++k)
      if (independent[k]) rows_.push_back(static_cast<int>(k));
  }
  // multipliers of these rows alone that do the same as those of all
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(rows());
  const Eigen::MatrixXd columns =
      differentiator_.at(state, solution.vdot, solution.lambda).velocity.rightCols(model().nv());
  const Eigen::MatrixXd G = columns(rows_, Eigen::all);
  const Eigen::Map<const Eigen::VectorXd> all(solution.lambda.data(),
                                              static_cast<Eigen::Index>(solution.lambda.size()));
  solver_.counts().add_derivatives(differentiator_.passes());
  lambda = none;
  if (rows() > 0) lambda = least_squares(G.transpose(), columns.transpose() * all);
  return outcome_;
}

std::vector<double> ResidualForm::all_rows(const Eigen::VectorXd& lambda) const {
  std::vector<double> all(model().closures().rows(), 0.0);
  for (int r = 0; r < rows(); ++r) all[rows_[r]] = lambda[r];
  return all;
}

const MotionResidual& ResidualForm::residual(const State<double>& state, const Eigen::VectorXd& vdot,
                                             const Eigen::VectorXd& lambda) {
  system_ = &evaluator_.system(state, solver_.loads());
  ++solver_.counts().kinematics, ++solver_.counts().rates;
  std::copy(vdot.begin(), vdot.end(), solution_.vdot.begin());
  solution_.lambda = all_rows(lambda);
  inverse_dynamics(*system_, solution_, tau_);
  residual_.balance = Eigen::Map<const Eigen::VectorXd>(tau_.data(), model().nv());
  residual_.position.resize(rows()), residual_.velocity.resize(rows());
  for (int r = 0; r < rows(); ++r) {
    residual_.position[r] = system_->closure_rows[rows_[r]].g;
    residual_.velocity[r] = system_->closure_rows[rows_[r]].rate;
  }
  residual_.power = power(evaluator_, *system_, state, solver_.loads(), solution_).total();
  return residual_;
}

const MotionDerivatives& ResidualForm::derivatives(const State<double>& state, const Eigen::VectorXd& vdot,
                                                   const Eigen::VectorXd& lambda) {
  const MotionDerivatives& all = differentiator_.at(state, {vdot.begin(), vdot.end()}, all_rows(lambda));
  solver_.counts().add_derivatives(differentiator_.passes());
  derivatives_.coordinate_rate = all.coordinate_rate;
  derivatives_.balance = all.balance;
  derivatives_.position = all.position(rows_, Eigen::all);
  derivatives_.velocity = all.velocity(rows_, Eigen::all);
  return derivatives_;
}

Eigen::MatrixXd ResidualForm::mass() const {
  const std::vector<double> M = mass_matrix(*system_);
  return Eigen::Map<const Eigen::MatrixXd>(M.data(), model().nv(), model().nv());
}

Eigen::VectorXd ResidualForm::transposed(const Eigen::VectorXd& mu) {
  Eigen::VectorXd result = Eigen::VectorXd::Zero(model().nv());
  if (rows() == 0) return result;
  jacobian_.evaluate(*system_);
  for (int r = 0; r < rows(); ++r)
    for (int p = jacobian_.starts()[rows_[r]]; p < jacobian_.starts()[rows_[r] + 1]; ++p)
      result[jacobian_.columns()[p]] += jacobian_.values()[p] * mu[r];
  return result;
}

}  // namespace lanc
