// A motion followed in minimal coordinates: steps in the independent coordinate, the dependent ones by Newton (19), and
// another coordinate where that one comes to a limit point.
#pragma once

#include <optional>
#include <vector>

#include "lib/closure/explicit.h"

namespace lanc {

/// A change of the independent coordinate, and where on the way it happened.
struct WalkChange {
  double arc;
  State<double> state;
  IndependentChange change;
};

/// For mechanisms with one freedom. Keeps its choice as ExplicitClosures does; a step that would pass a limit point is
/// refused by Newton's method or turns back, and is halved, so that the walk comes near enough to see the condition of
/// G^d grow beyond ExplicitOptions::leave. Bound to a model; a state on which the rank drops ends the walk. Tested by
/// tests/lib/explicit_test.cpp.
class ExplicitWalk {
 public:
  /// From an assembled state, in the direction of `towards` (scaled velocities; empty: the independent coordinate
  /// grows). Throws InputError unless the mobility there is 1.
  ExplicitWalk(const Model& model, const State<double>& start, ExplicitOptions options = {},
               const Eigen::VectorXd& towards = {});

  const State<double>& here() const { return state_; }
  double arc() const { return arc_; }  // sum of chords, in scaled velocities
  /// J*, scaled and of length 1, in the direction of the walk.
  const Eigen::VectorXd& tangent() const { return tangent_; }
  int independent() const { return conditions_.independent.front(); }
  const ExplicitConditions& conditions() const { return conditions_; }
  const std::vector<WalkChange>& changes() const { return changes_; }

  /// A step of about arc length h > 0: the independent coordinate changes by h times its part of the tangent. Halves
  /// h until β^d is found, near where the tangent leads. False when it is not: at a limit point that the candidates or
  /// a large ExplicitOptions::leave do not let it pass, or where the rank drops.
  bool advance(double h);

 private:
  /// The conditions at a state with the choice of `closures`; nothing where the rank has dropped.
  std::optional<ExplicitConditions> conditions_at(const State<double>& state, ExplicitClosures& closures) const;
  Eigen::VectorXd tangent_of(const ExplicitConditions& conditions) const;
  double distance(const State<double>& a, const State<double>& b) const;
  bool step(double h);

  Model model_;
  ExplicitClosures closures_;
  State<double> state_;
  ExplicitConditions conditions_;
  Eigen::VectorXd tangent_;
  double arc_ = 0;
  std::vector<WalkChange> changes_;
};

}  // namespace lanc
