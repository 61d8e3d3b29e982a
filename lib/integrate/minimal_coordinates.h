// y = (q, η_s, work): independent velocities are integrated; dependent coordinates and velocities follow from the
// closure conditions at every evaluation (theory, section 3).
// Private to lib/integrate.
#pragma once

#include "lib/integrate/motion_solver.h"
#include "lib/solve/dense_algebra.h"
#include "lib/system/closure_jacobian.h"

namespace lanc {

/// All q are carried along: those of dependent coordinates are the guess from which Newton's method finds them, so that
/// it stays on the branch, and joints with Euler parameters need no charts. Other independent velocities are chosen
/// between two steps, when the condition of G^d has become bad (ExplicitClosures).
///
/// Dependent coordinates and velocities are found in long double: near a singular configuration of distance σ their
/// errors are ε/σ and ε/σ², and those of the accelerations ε/σ³, while the motion itself is smooth there.
class MinimalCoordinates : public OdeForm {
 public:
  /// At a consistent state. `solver` holds the rank and must outlive this. `chosen`: the independent velocities to
  /// begin with; none: the best. `candidates`: those that may be chosen; none: all.
  MinimalCoordinates(MotionSolver& solver, const State<double>& start, const std::vector<int>& chosen,
                     const std::vector<int>& candidates);

  int size() const override { return nq_ + static_cast<int>(independent_.size()) + 1; }
  void pack(const MotionPoint& point, double* y) const override;
  MotionPoint unpack(double t, const double* y) const override;
  const std::vector<double>& scale() const override { return scale_; }
  Evaluation rate(double t, const double* y, double* ydot) override;
  Evaluation jacobian(double t, const double* y, double* J) override;
  Settled settle(double t, std::span<double> y) override;
  double condition() const override { return choice_.condition(); }
  std::vector<int> independent() const override { return independent_; }
  std::span<const IndependentChange> changes() const override { return choice_.changes(); }

 private:
  using Real = long double;

  /// All coordinates and velocities at y; nothing where the dependent ones cannot be found.
  std::optional<MotionPoint> complete(double t, const double* y) const;
  bool find_positions(State<Real>& state) const;
  bool find_velocities(State<Real>& state) const;
  /// Evaluates at the state: the independent rows, scaled, of g or of ġ.
  Eigen::VectorXd violation(const State<Real>& state, bool of_velocities) const;
  void factorise() const;
  double inverse_size() const;
  /// −G_d⁻¹ violation as velocities.
  std::vector<Real> correction(const Eigen::VectorXd& violation) const;
  /// The choice at a state of all that is kept between two steps. Whether it changed.
  bool choose(const State<double>& state);

  MotionSolver& solver_;
  int nq_;
  ClosureScaling scaling_;
  ClosureRank<double> rank_;
  ExplicitClosures choice_;
  std::vector<int> independent_, dependent_, rows_;
  std::vector<double> scale_;
  mutable Evaluator<Real> evaluator_;
  mutable ClosureJacobian<Real> jacobian_;
  mutable const System<Real>* system_ = nullptr;
  mutable Lu<double> dependent_columns_;
};

}  // namespace lanc
