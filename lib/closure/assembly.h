// Assembly: positions that satisfy g = 0, and velocities that satisfy G η + γ̄ = 0, near those given.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "lib/model/model.h"

namespace lanc {

struct AssemblyOptions {
  /// Largest scaled |g| (lib/closure/scaling.h) that is accepted; times the mechanism's extent in model lengths where
  /// that is larger than 1. Newton's method goes on beyond it until rounding stops it.
  double tolerance = 1e-12;
  int starts = 24;         // the guess, then ever larger departures from it, for the loops that do not close
  std::uint64_t seed = 1;  // of the departures
  int steps = 200;         // per start
};

enum class AssemblyStatus : unsigned char {
  assembled,
  infeasible,     // from every start |g|² ends in a minimum that is not zero
  bad_start,      // no start led anywhere
  flipped,        // the loop closes half a turn away from where it should only
  not_finite,     // a prescribed motion is not defined at this time
  beyond_limits,  // it closes, but limits of joints forbid it (assembly_limits.h)
  interrupted     // by the caller (assembly_limits.h)
};

/// How far a closure or a coupler is open: the worst of its rows that are lengths, and of those that are angles.
struct ClosureGap {
  std::string name;
  double length = 0;  // m
  double angle = 0;   // rad
};

struct AssemblyResult {
  AssemblyStatus status = AssemblyStatus::assembled;
  State<double> state;           // assembled, or the nearest that was found
  std::vector<ClosureGap> gaps;  // one per closure, then per coupler
  double violation = 0;          // largest scaled |g|
  double moved_length = 0;       // largest change of a position coordinate that is a length, m
  double moved_angle = 0;        // the same for angles; of Euler parameters: the angle turned, rad
  int starts = 1;                // that were needed
  std::string message;           // what stays open, by how much, and why; empty when assembled

  bool assembled() const { return status == AssemblyStatus::assembled; }
};

/// Closes all loops at the time of `state`, prescribed closures with their motions, from positions `state.q`, which may
/// be anywhere; velocities stay. Loops that share no velocity are closed apart. A state that is assembled is returned
/// as it is, up to rounding. Rank-deficient G is fine; flipped solutions are not accepted. Limits of joints are not
/// looked at. O(n) and dense singular values of each loop per step. Tested by tests/lib/assembly_test.cpp.
AssemblyResult assemble(const Model& model, State<double> state, const AssemblyOptions& options = {});

struct VelocityResult {
  bool consistent = true;
  State<double> state;
  double violation = 0;  // largest |Gη + γ̄|, scaled, relative to the largest scaled speed or 1
  double changed = 0;    // largest scaled change
  std::string message;   // what contradicts; empty when consistent
};

/// The velocities with Gη + γ̄ = 0 that differ least from state.v in the kinetic-energy metric ½ δᵀM̄δ; where M̄ is
/// singular, in that of M̄ plus the identity in scaled velocities, times the mean of M̄'s diagonal. When conditions
/// contradict one another: least squares, and not consistent. `state` must be assembled: rank is that of G there.
/// O(nv³). Tested by tests/lib/assembly_test.cpp.
VelocityResult consistent_velocities(const Model& model, State<double> state);

}  // namespace lanc
