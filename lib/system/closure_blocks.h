// Closures of one kind side by side in the lanes of a pack: a third of the time their rows take one by one.
#pragma once

#include <algorithm>
#include <vector>

#include "lib/model/closure_set.h"
#include "lib/spatial/block.h"

namespace lanc {

/// Closures first .. first + count − 1 of a model: side by side, with their frames in joint axes of the bodies, where
/// they are three or more of one kind; else one alone, to be taken as it is.
struct ClosureBlock {
  static constexpr int fewest = 3;
  using P = Packed<double>;
  int first = 0, count = 1;
  Mat3<P> axes_a{}, axes_b{};
  Vec3<P> point_a{}, point_b{};
};

/// Same conditions with the same numbers in them, and no motion, which is sampled one by one.
inline bool side_by_side(const Closure& a, const Closure& b) {
  return a.kind.index == b.kind.index && a.motion < 0 && b.motion < 0 && a.pitch == b.pitch && a.length == b.length;
}

/// All closures of the set, in their order.
inline std::vector<ClosureBlock> closure_blocks(const ClosureSet& set) {
  const std::vector<Closure>& all = set.closures;
  const int n = static_cast<int>(all.size());
  std::vector<ClosureBlock> blocks;
  for (int first = 0; first < n; first += blocks.back().count) {
    int count = 1;
    while (count < PackedScalar<double>::lanes && first + count < n && side_by_side(all[first], all[first + count]))
      ++count;
    ClosureBlock& block = blocks.emplace_back();
    block.first = first;
    if (count < ClosureBlock::fewest) continue;
    block.count = count;
    for (int lane = 0; lane < PackedScalar<double>::lanes; ++lane) {  // lanes left over repeat the last closure
      const Closure& c = all[first + std::min(lane, count - 1)];
      set_lane<double>(block.axes_a, lane, c.axes_a), set_lane<double>(block.axes_b, lane, c.axes_b);
      set_lane<double>(block.point_a, lane, c.point_a), set_lane<double>(block.point_b, lane, c.point_b);
    }
  }
  return blocks;
}

}  // namespace lanc
