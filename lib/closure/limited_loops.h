// From a guess to g = 0 within joint limits, as near as possible to preferred positions. Private to lib/closure.
//
// The unknowns are position coordinates q, not velocities about a moving point: limits and preferred values are those
// of q, so that bounds are bounds and the distance is one quadratic function. Euler parameters keep their norm by one
// condition more, and g is evaluated at the normalised ones; the derivative of that function is G 4Hᵀ / |e|, H of
// eq. 1, since HᵀH = 1/4.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "lib/closure/scaling.h"
#include "lib/system/closure_jacobian.h"
#include "lib/system/evaluator.h"

namespace lanc {

/// Units and limits of position coordinates, q = scale x: x in radians or model lengths; of Euler parameters x = 2e, so
/// that differences are angles, but for their cube.
struct PositionSpace {
  std::vector<double> scale, lower, upper;  // limits in SI units, ±infinity where there is none
  std::vector<bool> turn;                   // the same place after 2π

  explicit PositionSpace(const Model& model);
  /// Turned into the limits by whole turns where that can be, or as it is.
  double turned(int coordinate, double q) const;
};

/// Closure rows that share velocities, with the positions that move them; or the Euler parameters of one joint.
struct LimitedPart {
  std::vector<int> rows, positions;
  std::vector<int> quaternions;  // where in `positions` four Euler parameters begin
  std::vector<int> joints;       // to which these belong, as bodies
};

enum class LimitedEnd : unsigned char { closed, open, interrupted, not_finite };

/// How one attempt ended.
struct LimitedAttempt {
  LimitedEnd end = LimitedEnd::open;
  std::vector<double> q;      // of the part's positions, within limits
  double violation = 0;       // largest scaled |g|
  double distance = 0;        // from the preferred positions, scaled, Euclidean
  std::vector<int> at_limit;  // coordinates of the model that are held by a limit
  int steps = 0;              // of Ipopt
};

/// Least ½|x − preferred|² with g = 0 within limits: Ipopt with every condition softened, g + c = s/√ρ and ½|s|² added,
/// which bears redundant and contradictory rows, and the shift c raised by what stays open until nothing does (method
/// of multipliers; where that stops to help, the loop is open). Then Newton steps of least norm with coordinates at
/// their limits held fast, down to rounding. Every step of Ipopt: two evaluations of the model per position, O(n) each,
/// for second derivatives; a few in all, and BFGS, for loops of many positions.
class LimitedLoops {
 public:
  LimitedLoops(const Model& model, double tolerance);

  const PositionSpace& space() const { return space_; }
  /// Those of loops first, in the order of closure_components; then Euler parameters with limits on no loop.
  const std::vector<LimitedPart>& parts() const { return parts_; }
  /// From `state`, which holds the other parts and the start of this one. `preferred`: all positions.
  LimitedAttempt run(int part, const State<double>& state, const std::vector<double>& preferred,
                     const std::function<bool()>& interrupted);
  /// Scaled g of all rows.
  std::vector<double> residual(const State<double>& state);
  /// max(1, distance of the farthest body from the origin / model length), where last evaluated.
  double extent();
  Evaluator<double>& evaluator() { return evaluator_; }

 private:
  struct Problem;
  void add_part(LimitedPart part);
  void put(const LimitedPart& part, const std::vector<double>& x);
  bool residual(const LimitedPart& part, const std::vector<double>& x, Eigen::VectorXd& g);
  bool jacobian(const LimitedPart& part, const std::vector<double>& x, Eigen::MatrixXd& J);
  bool curvature(const LimitedPart& part, const std::vector<double>& x, const Eigen::VectorXd& multiplier,
                 std::vector<double>& values);
  std::vector<std::pair<int, int>> pattern(const LimitedPart& part) const;
  bool is_answer(const LimitedPart& part, const std::vector<double>& x, const std::vector<double>& preferred);
  std::vector<bool> seek(Problem& problem, std::vector<double>& x, LimitedAttempt& attempt);
  void polish(const LimitedPart& part, const std::vector<double>& preferred, std::vector<bool> fixed,
              LimitedAttempt& attempt);

  Model model_;
  double tolerance_;
  ClosureScaling scaling_;
  PositionSpace space_;
  Evaluator<double> evaluator_;
  ClosureJacobian<double> jacobian_;
  std::vector<LimitedPart> parts_;
  std::vector<int> local_;  // of a position: its place in the part that has it, or −1
  State<double> state_;
};

}  // namespace lanc
