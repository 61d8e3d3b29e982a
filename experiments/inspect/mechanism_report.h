// What a mechanism is, before any dynamics.
#pragma once

#include "lib/closure/mobility.h"
#include "lib/report/solution_report.h"
#include "lib/report/state_program.h"

namespace lanc {

/// What one should know about a body or a joint before trusting results.
struct Warning {
  std::string about, text;
};
std::vector<Warning> warnings(const Model& model);

/// What is told of a mechanism at a state.
struct MechanismReport {
  const StateInput& input;
  Mobility mobility;
  bool absolute = false;  // with the ranks in absolute coordinates
};

inline std::string named(const std::string& body) { return body.empty() ? "ground" : body; }

/// The object of the command-line contract (README of this program).
Json to_json(const MechanismReport& report);
std::string to_text(const MechanismReport& report);
/// Loops, counts, ranks, verdict and reactions, for an engineer.
std::string mobility_text(const MechanismReport& report);

}  // namespace lanc
