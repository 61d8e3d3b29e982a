#include "experiments/solve/answer.h"

#include <cmath>

#include "lib/report/phases.h"
#include "lib/system/equations.h"
#include "lib/system/mass_matrix.h"

namespace lanc {
namespace {

/// A whole number where it is one: counts, but also what a library counts in double.
Json flops_number(double value) {
  return value == std::floor(value) && std::abs(value) < 9e15 ? Json(static_cast<std::int64_t>(value))
                                                              : json_number(value);
}

/// Measurements of one metric, by phase.
template <class Number>
Json by_phase(const std::vector<Measurement>& rows, std::string_view metric, Number number) {
  Json phases = Json::object();
  for (const Measurement& row : rows)
    if (row.metric == metric) phases[row.phase] = number(row.value);
  return phases;
}

/// Operations by phase: counted where the arithmetic is ours, else by the library's counter; null where neither is.
Json count_flops(const FormulationInfo& info, const StateInput& input, const Formulation<double>& formulation) {
  if (info.create_count)
    return by_phase(measurements(count_phases(info, input.model, input.state)), "flops", flops_number);
  const auto library = formulation.statistics();
  if (!library) return nullptr;
  Evaluator<Count> evaluator(input.model);
  const State<Count> state = cast<Count>(input.state);
  const Tally before = Count::tally();
  evaluator.system(state);
  const auto kinematics = static_cast<double>((Count::tally() - before).flops());
  return {{"kinematics", flops_number(kinematics)},
          {"assemble", 0},  // copies coefficients
          {"factorise", flops_number(library->factorise_flops)},
          {"solve", flops_number(library->solve_flops)},
          {"total", flops_number(kinematics + library->factorise_flops + library->solve_flops)}};
}

Json measure_seconds(const FormulationInfo& info, const StateInput& input) {
  PhaseTimer timer(info.create_double, input.model, input.state);
  Json seconds = by_phase(timer.repetition(), "time", json_number);
  seconds["analyse"] = timer.analyse_seconds();
  return seconds;
}

}  // namespace

Answer answer(const FormulationInfo& info, const StateInput& input) {
  Answer result;
  result.info = &info;
  result.solution = Solution<double>(input.model);
  if (auto objection = info.objection(input.model)) {
    result.outcome = {Status::objection, *std::move(objection)};
    return result;
  }
  Evaluator<double> evaluator(input.model);
  const System<double>& system = evaluator.system(input.state, input.loads);
  const auto formulation = info.create_double(input.model);
  result.outcome = formulation->solve(system, result.solution);
  if (!result.outcome.has_answer()) return result;
  result.residual = backward_error(system, result.solution).componentwise;
  result.flops = count_flops(info, input, *formulation);
  result.seconds = measure_seconds(info, input);
  return result;
}

double mass_matrix_condition(const StateInput& input) {
  constexpr int most_velocities = 500;
  if (input.model.nv() > most_velocities) return std::numeric_limits<double>::quiet_NaN();
  Evaluator<double> evaluator(input.model);
  return equilibrated_condition(mass_matrix(evaluator.system(input.state, input.loads)));
}

}  // namespace lanc
