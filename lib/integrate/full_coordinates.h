// y = (q, η, work): all coordinates of the tree; closure conditions by their accelerations.
// Private to lib/integrate.
#pragma once

#include "lib/derivatives/motion_derivatives.h"
#include "lib/integrate/motion_solver.h"
#include "lib/integrate/stabilisation.h"

namespace lanc {

class FullCoordinates : public OdeForm {
 public:
  /// `solver` holds the rank and must outlive this. alpha: of Baumgarte's stabilisation, 1/s.
  FullCoordinates(MotionSolver& solver, Stabilisation stabilisation, double alpha);

  int size() const override { return nq_ + nv_ + 1; }
  void pack(const MotionPoint& point, double* y) const override;
  MotionPoint unpack(double t, const double* y) const override;
  const std::vector<double>& scale() const override { return scale_; }
  Evaluation rate(double t, const double* y, double* ydot) override;
  Evaluation jacobian(double t, const double* y, double* J) override;
  Settled settle(double t, std::span<double> y) override;

 private:
  Outcome solve(State<double>& state);

  MotionSolver& solver_;
  Differentiator differentiator_;
  Stabilisation stabilisation_;
  double alpha_;
  int nq_, nv_;
  std::vector<double> scale_;
  RightHandSide<double> rhs_;
  Solution<double> answer_;
};

/// How an integrator takes the outcome of an evaluation inside of a step. On the way through a singular configuration
/// (RankPolicy::smallest) a shorter step may have no stage in it.
Evaluation evaluation_of(const Outcome& outcome, const RankPolicy& policy);

}  // namespace lanc
