// Random closed mechanisms, assembled by construction, with redundancy of known cause.
#pragma once

#include <string>

#include "lib/io/mechanism.h"
#include "lib/io/random_tree.h"

namespace lanc {

/// Why closure conditions are redundant.
enum class RedundancyCause : unsigned char {
  any,        // each loop and each mechanism draws its own, or none
  none,       // every loop's conditions are independent of all others'
  parallel,   // a planar sub-loop, hinges parallel, cut at a hinge: 3 of 5 rows
  bennett,    // a Bennett linkage: 3 of 5 rows
  duplicate,  // a closure is there twice, or again with less conditions
};

struct RandomLoopsOptions {
  int loops = 1;
  RandomTreeOptions tree;  // `bodies` is chosen here; `kinds` holds for joints and for closures
  RedundancyCause cause = RedundancyCause::any;
};

/// A random tree and `loops` loops. Closure frames are placed by the poses of the drawn state, so that it is assembled
/// to rounding; velocities are made consistent. Conditions meant to be independent are so clearly: a row keeps a
/// twentieth of its length beside all others. At least one freedom is left. Gravity and name are the caller's, in
/// `frame`. Throws InputError when the kinds leave no room for the loops. Tested by tests/io/closures_test.cpp.
Mechanism random_loops(const RandomLoopsOptions& options, const ModelSpec& frame, Draw& draw);

}  // namespace lanc
