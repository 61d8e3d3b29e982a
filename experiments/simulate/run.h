// One run of the program: what was asked for, and how it is done.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "lib/integrate/quantities.h"
#include "lib/integrate/simulation.h"
#include "lib/report/progress.h"
#include "lib/report/report.h"
#include "lib/report/state_program.h"

namespace lanc {

struct RunOptions {
  SimulationOptions simulation;
  double end = 10, interval = 0.01;  // s
  int checkpoint_every = 50;         // rows of output
  bool resume = false, quiet = false;
  QuantityChoice quantities;
  std::vector<std::string> stop_when;
  std::string parameters;  // for the column of that name: what decides the numbers, but t
};

/// Integrates, writes the CSV, checkpoints, and says how it ended. Exit code 0 when it came to its end or a stop
/// condition was met, 1 when a status ended it.
StateOutput run(const StateInput& input, const RunOptions& options);

/// "QUANTITY<VALUE" or "QUANTITY>VALUE".
struct StopCondition {
  std::string text, quantity;
  double value = 0;
  bool above = true;

  /// Negative until it is met.
  double distance(const std::vector<Quantity>& quantities) const;
};
StopCondition read_stop_condition(const std::string& text);

/// Between the checkpoint, where it is not met, and t: the first instant at which it is, to 1e-12 of the time between.
/// Left there. By repeating the steps in between and secants.
void locate(const StopCondition& condition, const Checkpoint& before, double t, Simulation& simulation,
            Quantities& quantities);

// The file beside the CSV from which --resume goes on.
std::string checkpoint_name(const std::string& csv);
void write_checkpoint(const std::string& csv, const Checkpoint& checkpoint);
/// Nothing where there is none. Throws InputError when it cannot be read.
std::optional<Checkpoint> read_checkpoint(const std::string& csv, const Model& model);

}  // namespace lanc
