#include "lib/solve/ipopt.h"

// The order matters to Ipopt 3.11: its other headers use what the first one declares.
#include <IpIpoptApplication.hpp>
#include <IpSolveStatistics.hpp>
#include <IpTNLP.hpp>
#include <algorithm>
#include <limits>
#include <mutex>

namespace lanc {
namespace {

using Ipopt::Index;
using Ipopt::Number;
using Vector = std::vector<double>;

/// Ipopt's view of the problem.
class LeastDistance final : public Ipopt::TNLP {
 public:
  LeastDistance(const LeastDistanceProblem& problem, const Vector& start, LeastDistanceResult& result)
      : problem_(problem),
        start_(start),
        result_(result),
        x_(start.size()),
        g_(problem.conditions),
        multiplier_(problem.conditions),
        jacobian_(problem.rows.size()),
        curvature_(triangle()) {}

  bool get_nlp_info(Index& n, Index& m, Index& nnz_jac, Index& nnz_hessian, IndexStyleEnum& style) override {
    n = size(), m = problem_.conditions;
    nnz_jac = static_cast<Index>(problem_.rows.size());
    nnz_hessian = static_cast<Index>(triangle()) + n - problem_.curved;
    style = C_STYLE;
    return true;
  }

  bool get_bounds_info(Index n, Number* lower, Number* upper, Index m, Number* g_lower, Number* g_upper) override {
    constexpr double unbounded = 2e19;  // from 1e19 on Ipopt takes a bound for none
    for (Index i = 0; i < n; ++i) {
      lower[i] = std::max(problem_.lower[i], -unbounded);
      upper[i] = std::min(problem_.upper[i], unbounded);
    }
    std::fill(g_lower, g_lower + m, 0.0);
    std::fill(g_upper, g_upper + m, 0.0);
    return true;
  }

  bool get_starting_point(Index n, bool, Number* x, bool, Number*, Number*, Index, bool, Number*) override {
    std::copy(start_.begin(), start_.begin() + n, x);
    return true;
  }

  bool eval_f(Index n, const Number* x, bool, Number& value) override {
    value = 0;
    for (Index i = 0; i < n; ++i) {
      const double d = x[i] - problem_.target[i];
      value += problem_.weight[i] * d * d / 2;
    }
    return true;
  }

  bool eval_grad_f(Index n, const Number* x, bool, Number* gradient) override {
    for (Index i = 0; i < n; ++i) gradient[i] = problem_.weight[i] * (x[i] - problem_.target[i]);
    return true;
  }

  bool eval_g(Index n, const Number* x, bool, Index m, Number* g) override {
    x_.assign(x, x + n);
    if (!problem_.residual(x_, g_)) return false;
    std::copy(g_.begin(), g_.begin() + m, g);
    return true;
  }

  bool eval_jac_g(Index n, const Number* x, bool, Index, Index entries, Index* rows, Index* columns,
                  Number* values) override {
    if (values == nullptr) {
      std::copy(problem_.rows.begin(), problem_.rows.end(), rows);
      std::copy(problem_.columns.begin(), problem_.columns.end(), columns);
      return true;
    }
    x_.assign(x, x + n);
    if (!problem_.jacobian(x_, jacobian_)) return false;
    std::copy(jacobian_.begin(), jacobian_.begin() + entries, values);
    return true;
  }

  /// Lower triangle of the curved unknowns, then the diagonal of the others.
  bool eval_h(Index n, const Number* x, bool, Number factor, Index m, const Number* multiplier, bool, Index,
              Index* rows, Index* columns, Number* values) override {
    Index entry = 0;
    if (values == nullptr) {
      for (Index i = 0; i < problem_.curved; ++i)
        for (Index j = 0; j <= i; ++j, ++entry) rows[entry] = i, columns[entry] = j;
      for (Index i = problem_.curved; i < n; ++i, ++entry) rows[entry] = columns[entry] = i;
      return true;
    }
    x_.assign(x, x + n);
    multiplier_.assign(multiplier, multiplier + m);
    if (!problem_.curvature(x_, multiplier_, curvature_)) return false;
    std::copy(curvature_.begin(), curvature_.end(), values);
    for (Index i = 0; i < problem_.curved; ++i) values[entry += i] += factor * problem_.weight[i], ++entry;
    for (Index i = problem_.curved; i < n; ++i) values[entry++] = factor * problem_.weight[i];
    return true;
  }

  bool intermediate_callback(Ipopt::AlgorithmMode, Index step, Number, Number, Number, Number, Number, Number, Number,
                             Number, Index, const Ipopt::IpoptData*, Ipopt::IpoptCalculatedQuantities*) override {
    result_.steps = step;
    return !problem_.interrupted || !problem_.interrupted();
  }

  void finalize_solution(Ipopt::SolverReturn, Index n, const Number* x, const Number* z_lower, const Number* z_upper,
                         Index m, const Number*, const Number* multiplier, Number, const Ipopt::IpoptData*,
                         Ipopt::IpoptCalculatedQuantities*) override {
    result_.x.assign(x, x + n);
    result_.multiplier.assign(multiplier, multiplier + m);
    result_.lower_force.assign(z_lower, z_lower + n);
    result_.upper_force.assign(z_upper, z_upper + n);
  }

 private:
  Index size() const { return static_cast<Index>(problem_.target.size()); }
  std::size_t triangle() const { return static_cast<std::size_t>(problem_.curved) * (problem_.curved + 1) / 2; }

  const LeastDistanceProblem& problem_;
  const Vector& start_;
  LeastDistanceResult& result_;
  Vector x_, g_, multiplier_, jacobian_, curvature_;
};

LeastDistanceStatus status_of(Ipopt::ApplicationReturnStatus status) {
  switch (status) {
    case Ipopt::Solve_Succeeded:
    case Ipopt::Solved_To_Acceptable_Level: return LeastDistanceStatus::solved;
    case Ipopt::Infeasible_Problem_Detected: return LeastDistanceStatus::infeasible;
    case Ipopt::Search_Direction_Becomes_Too_Small:
    case Ipopt::Restoration_Failed:
    case Ipopt::Maximum_Iterations_Exceeded: return LeastDistanceStatus::too_many_steps;
    case Ipopt::User_Requested_Stop: return LeastDistanceStatus::interrupted;
    case Ipopt::Invalid_Number_Detected: return LeastDistanceStatus::not_finite;
    default: return LeastDistanceStatus::failed;
  }
}

}  // namespace

bool has_ipopt() { return true; }

LeastDistanceResult solve_least_distance(const LeastDistanceProblem& problem, const std::vector<double>& start,
                                         int most_steps) {
  static std::mutex one_at_a_time;
  const std::lock_guard<std::mutex> lock(one_at_a_time);
  Ipopt::SmartPtr<Ipopt::IpoptApplication> application = new Ipopt::IpoptApplication(false);
  application->RethrowNonIpoptException(true);
  Ipopt::OptionsList& options = *application->Options();
  options.SetIntegerValue("print_level", 0);
  options.SetStringValue("sb", "yes");
  options.SetNumericValue("tol", 1e-10);
  options.SetNumericValue("acceptable_tol", 1e-8);
  options.SetIntegerValue("max_iter", most_steps);
  options.SetNumericValue("bound_relax_factor", 0.0);  // by default bounds are widened by 1e-8
  options.SetStringValue("nlp_scaling_method", "none");
  options.SetStringValue("hessian_approximation", problem.curvature ? "exact" : "limited-memory");
  LeastDistanceResult result;
  if (application->Initialize("") != Ipopt::Solve_Succeeded) return result;
  const Ipopt::SmartPtr<Ipopt::TNLP> distance = new LeastDistance(problem, start, result);
  result.status = status_of(application->OptimizeTNLP(distance));
  if (result.x.empty()) {  // it ended before it began
    result.x = start;
    result.multiplier.assign(problem.conditions, 0.0);
    result.lower_force.assign(start.size(), 0.0);
    result.upper_force = result.lower_force;
  }
  return result;
}

}  // namespace lanc
