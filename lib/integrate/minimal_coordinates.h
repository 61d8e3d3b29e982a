// y = (q, η_s, work): independent velocities are integrated; dependent coordinates and velocities follow from the
// closure conditions at every evaluation (theory, section 3). Private to lib/integrate.
#pragma once

#include "lib/integrate/motion_solver.h"

namespace lanc {

/// All q are carried along: those of dependent coordinates are the guess from which Newton's method finds them, so that
/// it stays on the branch, and joints with Euler parameters need no charts. Other independent velocities are chosen
/// between two steps, when the condition of G^d has become bad (ExplicitClosures).
class MinimalCoordinates : public OdeForm {
 public:
  /// At a consistent state. `solver` holds the rank and must outlive this. `chosen`: the independent velocities to begin
  /// with; none: the best. `candidates`: those that may be chosen; none: all.
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
  /// All coordinates and velocities at y; nothing where the dependent ones cannot be found.
  std::optional<MotionPoint> complete(double t, const double* y) const;
  const ExplicitConditions& conditions(const State<double>& state, ExplicitClosures& closures) const;
  void set_scale();

  MotionSolver& solver_;
  int nq_;
  mutable ClosureRank<double> rank_;
  mutable Evaluator<double> evaluator_;
  ExplicitClosures choice_;         // changes between steps
  mutable ExplicitClosures fixed_;  // within a step
  std::vector<int> independent_;
  mutable ExplicitConditions dependent_;  // the split, for solve_dependent()
  std::vector<double> scale_;
};

}  // namespace lanc
