// One published problem solved in one way, and held against what was published.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "lib/integrate/simulation.h"
#include "lib/io/mechanism.h"
#include "lib/report/reference_problem.h"

namespace lanc {

struct Comparison {
  Outcome outcome;
  double worst = 0;            // largest |error| / tolerance of all values
  std::string worst_quantity;  // and where
  double worst_t = 0;
  double error = 0;         // largest |error| of positions (q, points), in their own units, against recomputed values
                            // where there are any
  double energy_drift = 0;  // largest, relative to the largest energy (kinetic + |potential|) of the run, or 1 J
  double violation = 0;     // largest scaled |g|
  double seconds = 0;       // of processor time for the motion
  int values = 0;           // compared
  int held_rank = -1;
  StepperCounts steps;
  MotionCounts evaluations;

  bool passed() const { return outcome.usable() && values > 0 && worst <= 1; }
};

/// Integrates to every time for which there are values.
/// Throws InputError where names do not go together or a quantity is unknown.
Comparison compare(const ReferenceProblem& problem, const Mechanism& mechanism, const SimulationOptions& options);

/// One way to solve problems, of all that go together.
struct Way {
  const FormulationInfo* formulation;
  std::string integrator, stabilisation;

  SimulationOptions options(double tolerance, double step) const;
  /// key=value;key=value of what `options` holds beside the formulation.
  std::string parameters(double tolerance, double step) const;
};

/// The integrators and stabilisations of these globs that go together (all stabilisations count as one where a model
/// has no closed loops).
std::vector<std::pair<std::string, std::string>> pairs_of(const std::string& integrators,
                                                          const std::string& stabilisations, bool closed_loops);

/// A state of rest and small motions about it, for problems without `end`.
Comparison compare_rest(const ReferenceProblem& problem, const Mechanism& mechanism);

}  // namespace lanc
