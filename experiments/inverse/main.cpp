// Inverse dynamics at one state: the forces that make the joints accelerate as given.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "lib/formulation/outcome.h"
#include "lib/model/error.h"
#include "lib/report/solution_report.h"
#include "lib/report/state_program.h"
#include "lib/system/equations.h"
#include "lib/system/evaluator.h"
#include "lib/system/finite.h"

namespace {

using namespace lanc;

struct Answer {
  Status status = Status::solved;
  std::string message;
  Solution<double> solution;
  std::vector<double> tau;
  double residual = std::numeric_limits<double>::quiet_NaN();
};

Answer solve(const StateInput& input, const std::optional<std::vector<double>>& vdot) {
  const Model& model = input.model;
  Answer answer;
  answer.solution = Solution<double>(model);
  if (vdot) answer.solution.vdot = *vdot;
  if (static_cast<int>(answer.solution.vdot.size()) != model.nv())
    throw InputError(fmt::format("--vdot has {} numbers, the model needs {}{}", answer.solution.vdot.size(), model.nv(),
                                 model.nv() > 12 ? "" : fmt::format(": {}", fmt::join(model.velocity_names(), ", "))));
  for (const double x : answer.solution.vdot)
    if (!std::isfinite(x)) throw InputError("--vdot holds a number that is not finite");
  Evaluator<double> evaluator(model);
  System<double> system = evaluator.system(input.state, input.loads);
  inverse_dynamics(system, answer.solution, answer.tau);
  const std::string cause = not_finite_because(system);
  for (int k = 0; k < model.nv(); ++k) system.rhs.tau[k] += answer.tau[k];
  answer.residual = backward_error(system, answer.solution).componentwise;
  if (!std::isfinite(answer.residual)) {
    answer.status = Status::not_finite;
    answer.message = cause.empty() ? "the answer overflows; are the accelerations and loads meant to be so large?"
                                   : "coefficients of eq. 14 cannot be used: " + cause;
  }
  return answer;
}

Json to_json(const Answer& answer, const StateInput& input) {
  const bool usable = answer.status == Status::solved;
  const auto if_usable = [&](Json value) { return usable ? std::move(value) : Json(nullptr); };
  return {{"status", to_string(answer.status)},
          {"message", answer.message},
          {"names", json_names(input.model)},
          {"vdot", answer.solution.vdot},
          {"tau", if_usable(answer.tau)},
          {"acceleration", if_usable(json_rows(answer.solution.acceleration))},
          {"wrench", if_usable(json_rows(answer.solution.wrench))},
          {"lambda", Json::array()},
          {"drive_force", if_usable(answer.solution.drive_force)},
          {"residual", json_number(answer.residual)}};
}

std::string to_text(const Answer& answer, const StateInput& input) {
  const Model& model = input.model;
  std::string text = fmt::format("Inverse dynamics of {}: {}\n", model.name(), to_string(answer.status));
  if (answer.status != Status::solved) return text + answer.message + "\n";
  text += fmt::format("t = {} s, residual {:.2g} (componentwise backward error of eq. 14)\n", input.state.t,
                      answer.residual);
  TextTable table({"velocity", "acceleration", "unit", "force", "unit"});
  const std::vector<std::string> names = model.velocity_names();
  for (int i = 0; i < model.bodies(); ++i) {
    const Link& link = model.link(i);
    for (int k = 0; k < link.nv; ++k) {
      const std::string_view unit = link.kind.traits().v_units[k];
      table.row({names[link.v + k], table_number(answer.solution.vdot[link.v + k]), acceleration_unit(unit),
                 table_number(answer.tau[link.v + k]), force_unit(unit.substr(0, unit.find('/')))});
    }
  }
  if (!table.empty()) text += "\nForces of the joints beyond their springs, dampers and friction\n" + table.text();
  return text + drive_table(model, answer.solution.drive_force) +
         acceleration_table(model, answer.solution.acceleration) + wrench_table(model, answer.solution.wrench);
}

}  // namespace

int main(int argc, char** argv) {
  std::optional<std::vector<double>> vdot;
  lanc::StateProgram program("inverse",
                             "Inverse dynamics: the joint forces that give the accelerations --vdot at one state, and "
                             "the drive forces of prescribed motions.\nExit code 0 when solved, 1 for any other "
                             "status, 2 for bad input.",
                             true);
  program.numbers("--vdot", vdot, "accelerations, one per velocity coordinate (default: 0)");
  return program.run(argc, argv, [&](const lanc::StateInput& input) -> lanc::StateOutput {
    const Answer answer = solve(input, vdot);
    return {input.format == lanc::Format::json ? lanc::json_text(to_json(answer, input)) : to_text(answer, input),
            answer.status == lanc::Status::solved ? 0 : 1};
  });
}
