// Least distance under nonlinear conditions and bounds, by Ipopt. No type of Ipopt shows here.
#pragma once

#include <functional>
#include <string_view>
#include <vector>

namespace lanc {

/// Minimise ½ Σ weight (x − target)² subject to g(x) = 0 and lower ≤ x ≤ upper. The functions return false where they
/// have no value; steps that lead there are shortened.
struct LeastDistanceProblem {
  using Vector = std::vector<double>;

  Vector target, weight, lower, upper;  // one per unknown; ±infinity: no bound
  int conditions = 0;
  std::function<bool(const Vector& x, Vector& g)> residual;
  std::vector<int> rows, columns;  // of the entries of ∂g/∂x
  std::function<bool(const Vector& x, Vector& values)> jacobian;
  /// Σ multiplier_k ∇²g_k of the first `curved` unknowns, the others enter g linearly: lower triangle, row by row,
  /// `values` filled. Empty: approximated from gradients (limited-memory BFGS).
  std::function<bool(const Vector& x, const Vector& multiplier, Vector& values)> curvature;
  int curved = 0;
  std::function<bool()> interrupted;  // asked at every iteration; may be empty
};

enum class LeastDistanceStatus : unsigned char {
  solved,
  infeasible,      // ends where |g| has a minimum that is not zero
  too_many_steps,  // or steps too small to go on
  interrupted,
  not_finite,  // no value at the start
  failed       // Ipopt says no more
};

struct LeastDistanceResult {
  LeastDistanceStatus status = LeastDistanceStatus::failed;
  std::vector<double> x, multiplier;
  std::vector<double> lower_force, upper_force;  // multipliers of the bounds, not negative: how hard they are pushed
  int steps = 0;
};

/// Whether this library was built with Ipopt (LANC_WITH_IPOPT).
bool has_ipopt();

/// Ipopt's answer from `start`: a local minimum, to 1e-10 in gradient and conditions, bounds kept. Prints nothing and
/// reads no options file. One call at a time in a program (the linear solver MUMPS has global data); others wait. Built
/// without Ipopt: std::logic_error. Wächter & Biegler 2006, Math. Program. 106:25. Tested by tests/lib/ipopt_test.cpp.
LeastDistanceResult solve_least_distance(const LeastDistanceProblem& problem, const std::vector<double>& start,
                                         int most_steps = 300);

}  // namespace lanc
