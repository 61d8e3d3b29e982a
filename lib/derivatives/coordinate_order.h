// Velocity coordinates in depth-first order: what a joint carries follows it without a gap, so that recursions over
// many columns run along arrays.
// Private to lib/derivatives.
#pragma once

#include <vector>

#include "lib/model/model.h"

namespace lanc {

struct CoordinateOrder {
  explicit CoordinateOrder(const Model& model);

  bool same = true;             // as the model's own order
  bool chain = true;            // every coordinate is on the path of all that follow: no entry of M̄ is zero
  std::vector<int> bodies;      // depth-first
  std::vector<int> place;       // per coordinate
  std::vector<int> coordinate;  // per place
  // per body: places of the coordinates of its joint and of all it carries, and the end of those of its whole tree
  std::vector<int> begin, end, tree_end;
};

}  // namespace lanc
