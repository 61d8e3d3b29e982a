// Answers as JSON and as text.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "experiments/solve/answer.h"

namespace lanc {
namespace {

std::string headline(const Answer& answer, const StateInput& input) {
  std::string text =
      fmt::format("{} by {}: {}\n", input.model.name(), answer.info->name, to_string(answer.outcome.status));
  if (!answer.outcome.message.empty()) text += answer.outcome.message + "\n";
  return text;
}

/// "12.3 µs" and the like.
std::string duration(const Json& seconds) {
  if (!seconds.is_number()) return "-";
  const double s = seconds.get<double>();
  if (std::abs(s) < 1e-6) return fmt::format("{:.0f} ns", s * 1e9);
  if (std::abs(s) < 1e-3) return fmt::format("{:.3g} µs", s * 1e6);
  if (std::abs(s) < 1) return fmt::format("{:.3g} ms", s * 1e3);
  return fmt::format("{:.3g} s", s);
}

std::string count(const Json& flops) { return flops.is_number() ? fmt::format("{:.0f}", flops.get<double>()) : "-"; }

Json phase(const Json& object, const char* name) {
  return object.is_object() && object.contains(name) ? object[name] : Json(nullptr);
}

std::string velocity_table(const StateInput& input, const Solution<double>& solution) {
  const Model& model = input.model;
  TextTable table({"velocity", "value", "unit", "acceleration", "unit"});
  const std::vector<std::string> names = model.velocity_names();
  for (int i = 0; i < model.bodies(); ++i) {
    const Link& link = model.link(i);
    for (int k = 0; k < link.nv; ++k) {
      const std::string_view unit = link.kind.traits().v_units[k];
      table.row({names[link.v + k], table_number(input.state.v[link.v + k]), std::string(unit),
                 table_number(solution.vdot[link.v + k]), acceleration_unit(unit)});
    }
  }
  return table.empty() ? "\nNo velocity coordinates\n" : "\nJoint accelerations\n" + table.text();
}

std::string multiplier_table(const Model& model, const Answer& answer) {
  const Outcome& outcome = answer.outcome;
  TextTable table({"closure condition", "multiplier", "unit"});
  const ClosureSet& set = model.closures();
  for (int k = 0; k < set.rows(); ++k)
    table.row({set.row_names[k], table_number(answer.solution.lambda[k]), set.row_is_length[k] ? "N" : "N m"});
  if (table.empty()) return {};
  return fmt::format(
             "\nClosure multipliers: rank {} of {} conditions, {} redundant; singular values {:.2e} and, next, "
             "{:.2e}\n",
             outcome.rank, set.rows(), outcome.redundant, outcome.sigma, outcome.next_sigma) +
         table.text();
}

std::string cost_table(const Answer& answer) {
  TextTable table({"phase", "flops", "time"});
  for (const char* name : {"kinematics", "analyse", "rank", "assemble", "factorise", "solve", "total"})
    table.row({name, count(phase(answer.flops, name)), duration(phase(answer.seconds, name))});
  return "\nCost (analyse: once a model, not in the total)\n" + table.text();
}

double difference(const std::vector<double>& a, const std::vector<double>& b) {
  double change = 0, size = 0;
  for (std::size_t k = 0; k < a.size(); ++k) {
    change = std::max(change, std::abs(a[k] - b[k]));
    size = std::max(size, std::abs(b[k]));
  }
  return size > 0 ? change / size : change;
}

}  // namespace

Json to_json(const Answer& answer, const StateInput& input, double condition) {
  const Outcome& outcome = answer.outcome;
  const bool usable = outcome.has_answer();
  const auto if_usable = [&](Json value) { return usable ? std::move(value) : Json(nullptr); };
  Json vdot = Json::array(), drives = Json::array(), lambda = Json::array();
  for (const double x : answer.solution.lambda) lambda.push_back(json_number(x));
  for (const double x : answer.solution.vdot) vdot.push_back(json_number(x));
  for (const double x : answer.solution.drive_force) drives.push_back(json_number(x));
  return {{"status", to_string(answer.outcome.status)},
          {"message", answer.outcome.message},
          {"names", json_names(input.model)},
          {"vdot", if_usable(vdot)},
          {"acceleration", if_usable(json_rows(answer.solution.acceleration))},
          {"wrench", if_usable(json_rows(answer.solution.wrench))},
          {"lambda", if_usable(lambda)},
          {"drive_force", if_usable(drives)},
          {"rank", outcome.rank},
          {"redundant", outcome.redundant},
          {"sigma",
           {outcome.rank > 0 ? json_number(outcome.sigma) : Json(nullptr),
            outcome.redundant > 0 ? json_number(outcome.next_sigma) : Json(nullptr)}},
          {"residual", json_number(answer.residual)},
          {"condition", json_number(condition)},
          {"flops", answer.flops},
          {"seconds", answer.seconds}};
}

std::string to_text(const Answer& answer, const StateInput& input, double condition) {
  std::string text = headline(answer, input);
  if (!answer.outcome.has_answer()) return text;
  const Solution<double>& solution = answer.solution;
  text +=
      fmt::format("t = {} s, residual {:.2g} (componentwise backward error of eq. 14)", input.state.t, answer.residual);
  if (!std::isnan(condition)) text += fmt::format(", condition {:.3g} (of M̄ scaled to unit diagonal)", condition);
  return text + "\n" + velocity_table(input, solution) + drive_table(input.model, solution.drive_force) +
         acceleration_table(input.model, solution.acceleration) + wrench_table(input.model, solution.wrench) +
         multiplier_table(input.model, answer) + cost_table(answer);
}

std::string comparison(const std::vector<Answer>& answers, const StateInput& input) {
  const auto first =
      std::find_if(answers.begin(), answers.end(), [](const Answer& a) { return a.outcome.has_answer(); });
  TextTable table({"formulation", "status", "flops", "time", "residual", "difference"}, 2);
  std::vector<std::pair<std::string, std::string>> messages;  // and whose they are, once each
  for (const Answer& a : answers) {
    const bool usable = a.outcome.has_answer();
    table.row({std::string(a.info->name), std::string(to_string(a.outcome.status)), count(phase(a.flops, "total")),
               duration(phase(a.seconds, "total")), usable ? fmt::format("{:.1e}", a.residual) : "-",
               usable ? fmt::format("{:.1e}", difference(a.solution.vdot, first->solution.vdot)) : "-"});
    if (a.outcome.message.empty()) continue;
    const auto same = std::find_if(messages.begin(), messages.end(),
                                   [&](const auto& entry) { return entry.first == a.outcome.message; });
    if (same == messages.end())
      messages.emplace_back(a.outcome.message, a.info->name);
    else
      same->second += fmt::format(", {}", a.info->name);
  }
  std::string text = fmt::format("{}: {} bodies, {} velocities, t = {} s\n", input.model.name(), input.model.bodies(),
                                 input.model.nv(), input.state.t);
  if (first != answers.end())
    text += fmt::format("difference: of η̇, relative to {}; time and flops: one evaluation with kinematics\n",
                        first->info->name);
  text += table.text();
  for (const auto& [message, names] : messages) text += fmt::format("  {}: {}\n", names, message);
  return text;
}

}  // namespace lanc
