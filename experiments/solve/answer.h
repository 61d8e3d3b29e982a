// One formulation's answer at one state, judged and measured.
#pragma once

#include <map>

#include "lib/formulation/formulation.h"
#include "lib/report/solution_report.h"
#include "lib/report/state_program.h"
#include "lib/system/evaluator.h"

namespace lanc {

struct Answer {
  const FormulationInfo* info = nullptr;
  Outcome outcome;
  Solution<double> solution;
  double residual = std::numeric_limits<double>::quiet_NaN();
  Json flops, seconds;  // by phase, or null
};

/// Solves, and measures where the answer is usable.
Answer answer(const FormulationInfo& info, const StateInput& input);

/// Condition number of M̄ scaled to unit diagonal; NaN for more than 500 velocities, where it costs too much.
double mass_matrix_condition(const StateInput& input);

/// The object of the command-line contract (README of this program).
Json to_json(const Answer& answer, const StateInput& input, double condition);
std::string to_text(const Answer& answer, const StateInput& input, double condition);
/// One line a formulation, with the difference of η̇ from the first usable answer.
std::string comparison(const std::vector<Answer>& answers, const StateInput& input);

/// Writes M̄, G, eq. 14 and their rows' names into the folder, which is made if need be.
void export_matrices(const StateInput& input, const std::string& folder);

}  // namespace lanc
