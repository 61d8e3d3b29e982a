// Assembly within the limits of joints, as near as possible to preferred positions.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "lib/closure/assembly.h"

namespace lanc {

struct LimitedAssemblyOptions {
  double tolerance = 1e-12;  // as in AssemblyOptions
  /// The preferred positions, the nearest assembly without limits, then departures of all sizes, until a loop closes.
  int starts = 24;
  int compared = 8;        // of these at least, for the nearest of the answers
  std::uint64_t seed = 1;  // of the departures
  /// Positions to be as near to as can be; empty: those of the state. Angles outside their limits are first turned
  /// around where that helps.
  std::vector<double> preferred;
  std::function<bool()> interrupted;  // asked often; may be empty
};

/// A position coordinate at or beyond a limit, SI units.
struct ReachedLimit {
  int coordinate = 0;  // index into q
  bool upper = false;
  double limit = 0, value = 0;
};

struct LimitedAssemblyResult : AssemblyResult {
  std::vector<ReachedLimit> reached;  // coordinates at their limits
  double distance = 0;                // from the preferred positions: Euclidean, of angles and model lengths
};

/// Positions with g = 0 (as in assemble()) and all coordinates within the limits of their joints, exactly, that are
/// nearest to the preferred ones: least squares of changes in radians and model lengths (of Euler parameters: twice
/// their change, which is the angle turned, but for its cube). A local minimum, the best of several starts. A loop
/// that cannot be closed so keeps the state where it is least open, and the message says what stays open, which limits
/// are reached, and whether it closes without limits. Throws InputError when `preferred` cannot be used, or when this
/// library was built without Ipopt (LANC_WITH_IPOPT). Cost: tens of evaluations of the model per position and start.
/// Tested by tests/lib/assembly_limits_test.cpp.
LimitedAssemblyResult assemble_within_limits(const Model& model, State<double> state,
                                             const LimitedAssemblyOptions& options = {});

/// Limits that positions violate. O(n). Tested by tests/lib/assembly_limits_test.cpp.
std::vector<ReachedLimit> violated_limits(const Model& model, const std::vector<double>& q);

/// "'joint.coordinate' at its upper limit 0.5 rad" or "... 0.1 rad beyond its upper limit 0.5 rad", commas between.
std::string to_text(const Model& model, const std::vector<ReachedLimit>& limits);

}  // namespace lanc
