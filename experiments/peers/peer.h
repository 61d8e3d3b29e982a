// A peer: another library's dynamics of one of our models, beside ours. One file each; it is compiled where CMake finds
// the library, and puts itself into the register.
#pragma once

#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "lib/io/mechanism.h"

namespace lanc::peers {

/// What is asked of one evaluation: η̇ of a state under gravity, or τ for a given η̇.
enum class Task : unsigned char { forward, inverse };

constexpr std::string_view to_string(Task task) { return task == Task::forward ? "forward" : "inverse"; }
/// In the CSV.
inline std::string parameters(Task task) { return "task=" + std::string(to_string(task)); }

/// A model of ours in a peer, at the state and, for inverse dynamics, with the η̇ that it was built with.
class PeerModel {
 public:
  virtual ~PeerModel() = default;
  /// What is timed: positions and velocities are set anew, so that nothing is left from the call before, and the task
  /// is done.
  virtual void call() = 0;
  /// What call() finds, in our velocity coordinates: η̇ or τ.
  virtual std::vector<double> answer() = 0;
};

/// Builds the model in the peer. Throws InputError naming what the peer cannot take.
using Build = std::unique_ptr<PeerModel> (*)(const Mechanism& mechanism, const std::vector<double>& vdot);

struct PeerInfo {
  std::string_view name;      // as in CSV files: "bullet"
  Task task = Task::forward;  // a peer may be there once for each
  std::string_view version;   // of the library that is linked
  std::string_view computes;  // functions that are timed, settings that matter
  Build build = nullptr;
  bool soft_loops = false;  // closure conditions hold approximately: its error is reported, and no ground to refuse it
};

/// All that were compiled, sorted by name, then task.
std::span<const PeerInfo> registered_peers();

/// A namespace-scope object of this type puts a peer into the register.
struct PeerRegistration {
  explicit PeerRegistration(const PeerInfo& info);
};

}  // namespace lanc::peers
