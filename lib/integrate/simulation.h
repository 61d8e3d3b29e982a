// The motion of a mechanism: formulation, stabilisation and integrator put together.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "lib/formulation/formulation.h"
#include "lib/integrate/stabilisation.h"
#include "lib/integrate/stepper.h"
#include "lib/system/energy.h"
#include "lib/system/power.h"

namespace lanc {

/// What to do where the rank of the closure conditions drops for a moment.
enum class SingularPolicy : unsigned char {
  stop,   // end there: what follows is not determined by the conditions
  pass,   // go on with the present velocities; directions that the conditions leave free there are carried by inertia
  branch  // go on along the branch SimulationOptions::branch
};

struct SimulationOptions {
  std::string formulation, integrator, stabilisation;
  double tolerance = 1e-8;       // integrators that choose their steps
  double step = 1e-3;            // s; integrators with fixed steps
  double baumgarte_time = 0;     // s, 1/α; 0: see baumgarte_rule()
  double spectral_radius = 0.8;  // at infinite frequency, of generalized-alpha
  SingularPolicy singular = SingularPolicy::stop;
  int branch = 1;               // of those that cross, by how straight they go on from the velocities there
  std::vector<int> candidates;  // velocities that may be chosen as independent ones (minimal); empty: all
  Loads<double> loads;          // constant
};

/// 1/α where none is given: ten steps of a fixed-step integrator (α h = 0.1 is far inside of every stability region);
/// else a twentieth of √(L/g) of the model's length and gravity, 9.81 m/s² where it has none.
double baumgarte_rule(const Model& model, const SimulationOptions& options, bool fixed_step);

/// Why an integrator and a stabilisation do not go together, or nothing.
std::optional<std::string> objection(const IntegratorInfo& integrator, Stabilisation stabilisation);

/// One instant of a motion, evaluated.
struct Instant {
  MotionPoint point;
  Outcome outcome;
  Solution<double> solution;
  Energy<double> energy;
  double energy_drift = 0;  // J: E − E at the start − work since
  double position_violation = 0, velocity_violation = 0, acceleration_violation = 0;  // scaled; worst row
  double choice_condition = 0;                                                        // of G^d; NaN: no choice
};

/// A step that was taken, and how far from singular the closure conditions were at its end.
struct PassedStep {
  MotionPoint point;
  double sigma = 0;  // σ_r
};

/// A crossing of branches at which one was chosen.
struct BranchChange {
  double t = 0;
  int choice = 0, branches = 0;
  double energy_change = 0;  // J, of the jump of velocities; counted as work
};

/// Everything a run has to remember to go on the same way, bit by bit.
struct Checkpoint {
  MotionPoint point;
  double next_step = 0;     // s
  double start_energy = 0;  // J
  int rank = -1;            // held
  std::vector<int> independent;
  std::vector<PassedStep> passed;  // the last ones
  StepperCounts steps;
  MotionCounts evaluations;
};

/// Integrates from a consistent state. Tested by tests/integrate/.
class Simulation {
 public:
  /// Throws InputError when the names are none, do not go together, or the formulation objects to the model.
  Simulation(const Model& model, SimulationOptions options);
  ~Simulation();

  /// Decides the rank at the start. The start should be assembled and its velocities consistent.
  Outcome begin(const State<double>& start);
  /// Goes on from a checkpoint.
  Outcome resume(const Checkpoint& checkpoint);
  /// Makes a checkpoint, and begins anew from it, as a resumed run does: so both take the same steps.
  Checkpoint renew();

  /// One step of the integrator, at most to `limit`. Other statuses than solved and redundant end the run; the state is
  /// then that of the last good step.
  Outcome step(double limit);

  /// Whether there is a motion: begin() was successful, or resume() called.
  bool begun() const;
  double t() const;
  MotionPoint point() const;
  Instant instant();
  double next_step() const;
  StepperCounts steps() const;
  MotionCounts evaluations() const;
  int held_rank() const;
  /// Changes of the independent velocities since begin() or resume() or renew().
  std::span<const IndependentChange> changes() const;
  /// Branches that were chosen, since the object was made.
  std::span<const BranchChange> branch_changes() const;

 private:
  Outcome watch_rank();
  bool take_branch(const MotionPoint& crossing);
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace lanc
