// Motion curves of mechanisms with one freedom: followed by arc length, through limit points of any coordinate and
// through configurations where branches cross (Allgower & Georg 1990, Numerical Continuation Methods).
#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>

#include "lib/closure/second_order.h"
#include "lib/model/model.h"

namespace lanc {

/// A point of a curve g = 0. Arc length and tangent are those of scaled velocities (lib/closure/scaling.h): radians,
/// and lengths in units of the model's.
struct BranchPoint {
  State<double> state;      // v: the tangent as velocities in SI units
  Eigen::VectorXd tangent;  // scaled, of length 1
  double arc = 0;
  /// σ_r of the scaled G with a sign that is carried along the curve and changes where another branch crosses it.
  double sigma = 0;
  Eigen::VectorXd left, right;  // the singular vectors of σ_r
};

/// Follows one branch. Bound to a model and the rank its closure conditions have on the branch. Dense: for mechanisms
/// up to some hundred velocities. Tested by tests/lib/branch_test.cpp.
class BranchTracer {
 public:
  /// From an assembled state, in the direction of `towards` (scaled velocities; empty: any). At a singular
  /// configuration `towards` must be one of the tangents (SecondOrder::tangents). Throws InputError unless nv − rank
  /// = 1.
  BranchTracer(const Model& model, const State<double>& start, int rank, const Eigen::VectorXd& towards = {});

  const Model& model() const { return model_; }
  const BranchPoint& here() const { return here_; }
  /// One step of arc length h (negative: backward): along the tangent, then back to g = 0 perpendicularly. Halves the
  /// step until the correction is small against it; the step it took is the change of here().arc. False when nothing
  /// converges: the curve cannot be followed.
  bool advance(double h);
  /// The point at arc length h from here, or nothing; here() stays.
  std::optional<BranchPoint> at(double h) const;
  /// The point between here and here + h where `event` changes its sign, to rounding; nothing when it does not.
  std::optional<BranchPoint> locate(double h, const std::function<double(const BranchPoint&)>& event) const;

 private:
  BranchPoint point(State<double> state, const Eigen::VectorXd& towards, const BranchPoint* before) const;

  Model model_;
  int rank_;
  BranchPoint here_;
};

/// A configuration of smaller rank, with the directions in which branches leave it.
struct SingularPoint {
  State<double> state;
  ClosureDecomposition decomposition;     // rank: the smaller one
  std::vector<Eigen::VectorXd> tangents;  // scaled, one of each pair ±
};
/// The singular configuration near a state, where G loses one more rank than `rank`: Gauss-Newton on g = 0, Gᵀu = 0,
/// uᵀu = 1. Nothing when there is none nearby.
std::optional<SingularPoint> locate_singular_point(const Model& model, const State<double>& near, int rank);

}  // namespace lanc
