// Small motions about a state: mass, damping and stiffness in independent coordinates, eigenvalues; states of rest.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>

#include "lib/integrate/linearise.h"
#include "lib/model/error.h"
#include "lib/report/solution_report.h"
#include "lib/report/state_program.h"

namespace {

using namespace lanc;

Json matrix(const std::vector<double>& values, std::size_t n) {
  Json rows = Json::array();
  for (std::size_t r = 0; r < n; ++r) {
    Json row = Json::array();
    for (std::size_t c = 0; c < n; ++c) row.push_back(json_number(values[r * n + c]));
    rows.push_back(row);
  }
  return rows;
}

std::string table(const char* name, const std::vector<double>& values, std::size_t n) {
  std::string text = fmt::format("{}\n", name);
  for (std::size_t r = 0; r < n; ++r) {
    for (std::size_t c = 0; c < n; ++c) text += fmt::format(" {:>18.10g}", values[r * n + c]);
    text += "\n";
  }
  return text;
}

StateOutput tell(const StateInput& input, const State<double>& state, const Outcome& outcome,
                 const LinearisedMotion& motion) {
  const std::vector<std::string> names = input.model.velocity_names();
  std::vector<std::string> independent;
  for (const int k : motion.independent) independent.push_back(names[k]);
  const std::size_t n = independent.size();
  if (input.format == Format::json) {
    Json eigenvalues = Json::array();
    for (const auto& s : motion.eigenvalues) eigenvalues.push_back({json_number(s.real()), json_number(s.imag())});
    const Json document = {{"status", to_string(outcome.status)},
                           {"message", outcome.message},
                           {"t", state.t},
                           {"q", state.q},
                           {"v", state.v},
                           {"independent", independent},
                           {"condition", json_number(motion.condition)},
                           {"M", matrix(motion.M, n)},
                           {"C", matrix(motion.C, n)},
                           {"K", matrix(motion.K, n)},
                           {"eigenvalues", eigenvalues}};
    return {json_text(document), outcome.usable() ? 0 : 1};
  }
  std::string text =
      fmt::format("status {}{}{}\n", to_string(outcome.status), outcome.message.empty() ? "" : ": ", outcome.message);
  const std::vector<std::string> positions = input.model.position_names();
  for (std::size_t k = 0; k < positions.size(); ++k) text += fmt::format("q.{} = {:.15g}\n", positions[k], state.q[k]);
  if (!outcome.usable()) return {text, 1};
  text += fmt::format("\nIndependent coordinates: {}\n\n", fmt::join(independent, ", "));
  text += table("Mass matrix M", motion.M, n) + table("Damping matrix C", motion.C, n) +
          table("Stiffness matrix K", motion.K, n);
  text += "\nEigenvalues, 1/s             undamped frequency, rad/s    damping ratio\n";
  for (const auto& s : motion.eigenvalues)
    text += fmt::format("{:>+20.13g} {:>+20.13g} i  {:>18.12g} {:>12.6g}\n", s.real(), s.imag(), std::abs(s),
                        std::abs(s) > 0 ? -s.real() / std::abs(s) : 0.0);
  return {text, 0};
}

StateOutput run(const StateInput& input, const std::string& rest, const std::vector<std::string>& independent) {
  if (rest != "no" && rest != "nearest" && rest != "stable")
    throw InputError(fmt::format("--equilibrium '{}': choose no, nearest or stable", rest));
  const std::vector<int> chosen = velocities_named(input.model, "--independent", independent);
  State<double> state = input.state;
  Outcome outcome;
  LinearisedMotion motion;
  if (rest != "no") outcome = equilibrium(input.model, state, {.stable = rest == "stable"});
  if (outcome.usable()) outcome = linearise(input.model, state, chosen, motion);
  return tell(input, state, outcome, motion);
}

}  // namespace

int main(int argc, char** argv) {
  std::string rest = "no";
  std::vector<std::string> independent;
  lanc::StateProgram program("linearise",
                             "Small motions about a state: M, C and K in independent coordinates, and eigenvalues.\n"
                             "Exit code 0 only when solved (or redundant), 1 for any other status, 2 for bad input.",
                             false);
  program.option(
      "--equilibrium", rest,
      "no: about the state given; nearest: about the state of rest nearby; stable: a minimum of the potential");
  program.list("--independent", independent, "velocity to be independent; repeatable; default: the best");
  return program.run(argc, argv, [&](const lanc::StateInput& input) { return run(input, rest, independent); });
}
