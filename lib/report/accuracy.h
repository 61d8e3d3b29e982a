// How right an answer is: against a reference in higher precision, and by its backward error.
#pragma once

#include "lib/formulation/formulation.h"
#include "lib/report/report.h"
#include "lib/system/evaluator.h"

namespace lanc {

/// η̇, â and f̂ of one state in long double, refined until refinement changes nothing more. Kept rounded to double: half
/// a unit in the last place.
class Reference {
 public:
  /// By the first recursive formulation of the register that is offered in long double. Throws InputError when there is
  /// none. Coefficients are evaluated in long double, too: errors are those of the whole computation.
  /// Where loops are closed the last one of them is taken, and the rank may be given.
  Reference(const Model& model, const State<double>& state, RankPolicy policy = {});

  /// Size of the last refinement of the reference relative to η̇.
  double last_refinement() const { return last_refinement_; }

  /// Rows (phase solve): error_vdot, error_acceleration, error_wrench, each max|difference| / max|reference|, and the
  /// componentwise and normwise backward errors of eq. 14.
  std::vector<Measurement> errors(const System<double>& system, const Solution<double>& solution,
                                  const std::string& status, const std::string& suffix = {}) const;

 private:
  Solution<double> exact_;
  double last_refinement_ = 0;
};

}  // namespace lanc
