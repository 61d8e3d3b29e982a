#include "lib/report/accuracy.h"

#include <algorithm>
#include <cmath>

#include "lib/model/error.h"
#include "lib/system/equations.h"

namespace lanc {

namespace {

double largest(const Vec3<double>& a) { return std::max({std::abs(a.x), std::abs(a.y), std::abs(a.z)}); }

/// max|a − b| / max|b|, where b is the reference.
class RelativeError {
 public:
  void add(double a, double b) {
    difference_ = worse(difference_, std::abs(a - b));
    size_ = std::max(size_, std::abs(b));
  }
  void add(const Vec3<double>& a, const Vec3<double>& b) {
    difference_ = worse(difference_, largest(a - b));
    size_ = std::max(size_, largest(b));
  }
  double value() const { return difference_ == 0 ? 0 : difference_ / size_; }

 private:
  static double worse(double a, double b) { return std::isnan(b) || b > a ? b : a; }
  double difference_ = 0, size_ = 0;
};

Vec3<double> rounded(const Vec3<long double>& a) { return {to_double(a.x), to_double(a.y), to_double(a.z)}; }

}  // namespace

Reference::Reference(const Model& model, const State<double>& state, RankPolicy policy) : exact_(model) {
  const FormulationInfo* info = nullptr;
  for (const FormulationInfo& f : formulations())
    if (f.recursive && f.create_long_double && (!info || model.has_closures())) info = &f;
  if (!info) throw InputError("no recursive formulation in long double to make a reference with");
  Evaluator<long double> evaluator(model);
  const System<long double>& system = evaluator.system(cast<long double>(state));
  const auto formulation = info->create_long_double(model);
  Solution<long double> solution(model);
  if (const Outcome outcome = formulation->solve(system, solution, policy); !outcome.usable())
    throw InputError("the reference in long double failed: " + outcome.message);
  constexpr int most_steps = 5;
  for (int k = 0; k < most_steps; ++k) {
    last_refinement_ = formulation->refine(system, solution);
    if (last_refinement_ < 1e-18) break;
  }
  std::transform(solution.vdot.begin(), solution.vdot.end(), exact_.vdot.begin(),
                 [](long double x) { return to_double(x); });
  for (int i = 0; i < model.bodies(); ++i) {
    exact_.acceleration[i] = {rounded(solution.acceleration[i].angular), rounded(solution.acceleration[i].linear)};
    exact_.wrench[i] = {rounded(solution.wrench[i].moment), rounded(solution.wrench[i].force)};
  }
}

std::vector<Measurement> Reference::errors(const System<double>& system, const Solution<double>& solution,
                                           const std::string& status, const std::string& suffix) const {
  RelativeError vdot, angular, linear, moment, force;
  for (std::size_t k = 0; k < exact_.vdot.size(); ++k) vdot.add(solution.vdot[k], exact_.vdot[k]);
  for (std::size_t i = 0; i < exact_.wrench.size(); ++i) {
    angular.add(solution.acceleration[i].angular, exact_.acceleration[i].angular);
    linear.add(solution.acceleration[i].linear, exact_.acceleration[i].linear);
    moment.add(solution.wrench[i].moment, exact_.wrench[i].moment);
    force.add(solution.wrench[i].force, exact_.wrench[i].force);
  }
  const BackwardError backward = backward_error(system, solution);
  return {{"solve", "error_vdot" + suffix, vdot.value(), "1", status},
          {"solve", "error_acceleration" + suffix, std::max(angular.value(), linear.value()), "1", status},
          {"solve", "error_wrench" + suffix, std::max(moment.value(), force.value()), "1", status},
          {"solve", "backward_error_componentwise" + suffix, backward.componentwise, "1", status},
          {"solve", "backward_error_normwise" + suffix, backward.normwise, "1", status}};
}

}  // namespace lanc
