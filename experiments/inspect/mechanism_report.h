// What a mechanism is, before any dynamics.
#pragma once

#include "lib/report/solution_report.h"
#include "lib/report/state_program.h"

namespace lanc {

/// What one should know about a body or a joint before trusting results.
struct Warning {
  std::string about, text;
};
std::vector<Warning> warnings(const Model& model);

/// The object of the command-line contract (README of this program).
Json to_json(const StateInput& input);
std::string to_text(const StateInput& input);

}  // namespace lanc
