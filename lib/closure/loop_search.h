// From a guess to g = 0, for loops that hang together: damped, then plain Newton steps. Private to lib/closure.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "lib/closure/components.h"
#include "lib/closure/scaling.h"
#include "lib/system/closure_jacobian.h"
#include "lib/system/evaluator.h"

namespace lanc {

enum class LoopEnd : unsigned char {
  running,
  closed,
  stationary,  // |g|² has a minimum here, and it is not zero
  stalled,     // too many steps
  not_finite   // g cannot be evaluated here (a motion outside its table)
};

/// One part of the mechanism: closure rows that share velocities, and these. Everything scaled (lib/closure/scaling.h).
struct Loop {
  ClosureComponent part;
  std::vector<int> positions;  // indices into q that its velocities change
  Eigen::VectorXd g;
  LoopEnd end = LoopEnd::running;
  // of the factorisation of G at the place last accepted
  Eigen::MatrixXd G, U, V;
  Eigen::VectorXd sigma, step;
  double damping = 0, predicted = 0;
  int steps = 0;
  bool fresh = true;  // G is to be read and factorised
  bool newton = false, newton_failed = false;

  double largest() const { return g.size() > 0 ? g.lpNorm<Eigen::Infinity>() : 0; }
};

/// Levenberg-Marquardt with damping proportional to |g|, which keeps quadratic convergence where G lacks rank (Fan &
/// Yuan 2005), then Newton steps of minimum norm by truncated singular values until rounding stops them. Steps are
/// limited to half a radian or half the model's length, so that a loop closes on the branch it is near to. Closures
/// that stand the wrong way round are turned over first. Every step: O(n), and O(rows · velocities · min) per loop.
class LoopSearch {
 public:
  LoopSearch(const Model& model, double tolerance, int steps);

  const std::vector<Loop>& loops() const { return loops_; }
  /// Moves the positions of `state` until every loop named has ended. The others are left alone.
  void run(State<double>& state, const std::vector<int>& which);
  /// g of all loops at a state.
  void evaluate(const State<double>& state);
  /// max(1, distance of the farthest body from the origin / model length): rounding errors of g grow with it.
  double extent() const { return extent_; }
  Evaluator<double>& evaluator() { return evaluator_; }

 private:
  void turn_over(State<double>& state, const std::vector<int>& which);
  void begin(Loop& loop);
  void read(Loop& loop) const;
  void prepare(Loop& loop);
  void propose(Loop& loop) const;
  /// The loop's step into the change of all velocities, SI units.
  void put(const Loop& loop, std::vector<double>& change) const;
  bool judge(Loop& loop, const Eigen::VectorXd& before) const;

  Model model_;
  double tolerance_;
  int most_steps_;
  ClosureScaling scaling_;
  Evaluator<double> evaluator_;
  ClosureJacobian<double> jacobian_;
  std::vector<Loop> loops_;
  std::vector<double> g_;
  double extent_ = 1;
};

}  // namespace lanc
