// All that can be reached by motion: branches followed until they come round, and the crossings from which others
// leave.
#pragma once

#include <functional>
#include <vector>

#include "lib/closure/branch.h"

namespace lanc {

struct Branch {
  std::vector<BranchPoint> points;  // with its arc length from the first
  bool closed = false;              // came round: the last point is the first again
};

/// Follows a branch by steps of arc length h until all bodies are where they were, however many turns joints made, or
/// it cannot be followed, or `most` steps are done. Before each step `each` gets the tracer and the length that will be
/// stepped, to locate what lies between. The start must not be a singular configuration.
Branch follow_round(BranchTracer tracer, double h, int most = 100000,
                    const std::function<void(const BranchTracer&, double h)>& each = {});

struct BranchMap {
  std::vector<Branch> branches;          // the first begins at the start
  std::vector<SingularPoint> crossings;  // in the order in which they were met
};
/// All branches that hang together with a regular start through crossings, each followed once. Tested by
/// tests/lib/branch_map_test.cpp.
BranchMap map_branches(const Model& model, const State<double>& start, int rank, double h, int most = 100000);

}  // namespace lanc
