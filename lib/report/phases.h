// What a formulation costs, phase by phase: operations counted, times measured from outside.
#pragma once

#include <memory>
#include <vector>

#include "lib/formulation/formulation.h"
#include "lib/report/report.h"
#include "lib/report/timing.h"
#include "lib/system/evaluator.h"

namespace lanc {

/// Operations of kinematics, assemble, factorise and solve at one state, in this order. The decision on the rank of
/// closure conditions works in double and is not counted.
struct PhaseCounts {
  Tally kinematics, assemble, factorise, solve;
  Outcome outcome;
};

/// Runs the formulation on Count. It must be offered for Count.
PhaseCounts count_phases(const FormulationInfo& info, const Model& model, const State<double>& state);

/// Rows: flops of every phase and in total; add, sub, mul, div, sqrt and trig in total.
std::vector<Measurement> measurements(const PhaseCounts& counts);

/// The rank at a state, to be held in what is timed, as along a motion: by pivots where the formulation can. Automatic
/// where no loop is closed or no rank is found.
RankPolicy held_rank(Factory<double> create, const Model& model, const State<double>& state);

/// Times one formulation on one model. Phases are timed cumulatively, since factorise() may overwrite what assemble()
/// made, and differences taken: a single one can be off by the noise of two.
class PhaseTimer {
 public:
  /// Binds (analyses) and solves once; outcome() says how that went, and analyse_seconds() what binding took.
  PhaseTimer(Factory<double> create, const Model& model, const State<double>& state, RankPolicy policy = {});

  const Outcome& outcome() const { return outcome_; }
  double analyse_seconds() const { return analyse_seconds_; }
  /// Bytes on the heap the bound formulation holds after its first solve; kinematics and solution not included.
  std::int64_t bytes() const { return bytes_; }
  const System<double>& system() const { return *system_; }
  Solution<double>& solution() { return solution_; }
  Formulation<double>& formulation() { return *formulation_; }

  /// One repetition: seconds of kinematics, assemble, factorise, solve and total, as rows. Where loops are closed also
  /// those of the decision on the rank, which is part of the total.
  std::vector<Measurement> repetition();

 private:
  State<double> state_;
  Evaluator<double> evaluator_;
  Solution<double> solution_;
  const System<double>* system_;
  std::unique_ptr<Formulation<double>> formulation_;
  Outcome outcome_;
  RankPolicy policy_;
  double analyse_seconds_ = 0;
  std::int64_t bytes_ = 0;
  Repeat kinematics_, rank_, assemble_, factorise_, solve_, total_;
};

}  // namespace lanc
