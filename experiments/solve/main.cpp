// Forward dynamics at one state: η̇, â, f̂ and drive forces, by any formulation, or compared over several.
#include <fmt/format.h>

#include <algorithm>

#include "experiments/solve/answer.h"
#include "lib/report/experiment.h"

namespace {

using namespace lanc;

/// The formulations that match a name, a glob or "all". Throws InputError when there is none.
std::vector<const FormulationInfo*> chosen(const std::string& pattern) {
  std::vector<std::string> names;
  for (const FormulationInfo& info : formulations()) names.emplace_back(info.name);
  std::vector<const FormulationInfo*> infos;
  for (const std::string& name : matching(names, pattern == "all" ? "*" : pattern))
    if (const FormulationInfo* info = find_formulation(name)) infos.push_back(info);
  if (infos.empty())
    throw InputError(
        fmt::format("there is no formulation '{}'; choose from {}, or all", pattern, fmt::join(names, ", ")));
  return infos;
}

StateOutput run(const StateInput& input, const std::string& pattern, const std::string& folder) {
  const auto infos = chosen(pattern);
  if (!folder.empty()) export_matrices(input, folder);
  std::vector<Answer> answers;
  for (const FormulationInfo* info : infos) answers.push_back(answer(*info, input));
  const double condition = mass_matrix_condition(input);

  const bool single = answers.size() == 1;
  const auto usable = [](const Answer& a) { return a.outcome.usable(); };
  const auto fine = [&](const Answer& a) { return usable(a) || (!single && a.outcome.status == Status::objection); };
  StateOutput output;
  output.exit_code =
      std::any_of(answers.begin(), answers.end(), usable) && std::all_of(answers.begin(), answers.end(), fine) ? 0 : 1;
  if (input.format == Format::text) {
    output.text = single ? to_text(answers[0], input, condition) : comparison(answers, input);
  } else if (single) {
    output.text = json_text(to_json(answers[0], input, condition));
  } else {
    Json all = Json::object();
    for (const Answer& a : answers) all[std::string(a.info->name)] = to_json(a, input, condition);
    output.text = json_text(all);
  }
  return output;
}

}  // namespace

int main(int argc, char** argv) {
  const lanc::FormulationInfo* const preset = lanc::default_formulation();
  std::string formulation(preset ? preset->name : "all"), folder;
  lanc::StateProgram program("solve",
                             "Forward dynamics: accelerations, joint wrenches and drive forces of a mechanism at one "
                             "state.\nExit code 0 only when solved (or redundant), 1 for any other status, 2 for bad "
                             "input.",
                             true);
  program.option("--formulation", formulation, "name, glob or 'all' (a comparison); see --list-formulations");
  program.option("--export", folder, "folder to write mass matrix, closure Jacobian and eq. 14 to (Matrix Market)");
  return program.run(argc, argv, [&](const lanc::StateInput& input) { return run(input, formulation, folder); });
}
