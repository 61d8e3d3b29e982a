// The equations of motion as they stand, M̄ η̇ − b − Gᵀλ = 0 and g = 0, for integrators that solve them together.
// Private to lib/integrate.
#pragma once

#include <Eigen/Core>

#include "lib/integrate/full_coordinates.h"
#include "lib/system/closure_jacobian.h"

namespace lanc {

/// What is left of the equations at (q, η, η̇, λ); of closure conditions the independent rows only.
struct MotionResidual {
  Eigen::VectorXd balance;             // nv
  Eigen::VectorXd position, velocity;  // g and ġ
  double power = 0;                    // of all that does work, W
};

/// y = (q, η, work) as in FullCoordinates, with the residual beside. Formulations serve for the start only.
class ResidualForm : public FullCoordinates {
 public:
  explicit ResidualForm(MotionSolver& solver);

  /// Chooses the independent rows at a state, and the accelerations and multipliers there, by the formulation.
  Outcome start(const State<double>& state, Eigen::VectorXd& vdot, Eigen::VectorXd& lambda);
  int rows() const { return static_cast<int>(rows_.size()); }

  const MotionResidual& residual(const State<double>& state, const Eigen::VectorXd& vdot,
                                 const Eigen::VectorXd& lambda);
  /// Derivatives of the residual and of H(q) η with respect to q and η, of the independent rows. The columns of
  /// `velocity` for η are G.
  const MotionDerivatives& derivatives(const State<double>& state, const Eigen::VectorXd& vdot,
                                       const Eigen::VectorXd& lambda);
  /// Of the last residual(): M̄, and Gᵀμ.
  Eigen::MatrixXd mass() const;
  Eigen::VectorXd transposed(const Eigen::VectorXd& mu);
  const Model& model() const { return solver_.model(); }
  void fail(Status status, std::string message) { outcome_ = {status, std::move(message)}; }

 private:
  std::vector<double> all_rows(const Eigen::VectorXd& lambda) const;

  MotionSolver& solver_;
  ClosureRank<double> rank_;
  Evaluator<double> evaluator_;
  ClosureJacobian<double> jacobian_;
  Differentiator differentiator_;
  const System<double>* system_ = nullptr;
  std::vector<int> rows_;
  Solution<double> solution_;
  std::vector<double> tau_;
  MotionResidual residual_;
  MotionDerivatives derivatives_;
};

}  // namespace lanc
