// Which velocity coordinates move a body: the columns on its path to the ground, root first.
#pragma once

#include <cstdint>
#include <vector>

#include "lib/model/model.h"

namespace lanc {

/// The sparsity of J (eq. 11) and of M̄ in a tree. The path of velocity coordinate k ends with k itself; the path of a
/// coordinate on it is a beginning of it, so entries of one depth stand in one place. Sum of lengths: cost and memory
/// of whatever stores one number per (coordinate, coordinate on its path).
class VelocityPaths {
 public:
  explicit VelocityPaths(const Model& model);

  /// Number of coordinates on the path of coordinate k, itself included.
  int depth(int k) const { return depth_[k]; }
  /// The coordinate before k on its path, or −1.
  int before(int k) const { return before_[k]; }
  /// The last coordinate that moves body i, or −1; depth(last(i)) of them do.
  int last(int body) const { return last_[body]; }
  int body_depth(int body) const { return last_[body] < 0 ? 0 : depth_[last_[body]]; }
  /// Every coordinate once, each followed by all it carries (a preorder): along this order one array indexed by depth
  /// holds what belongs to the path of the present coordinate.
  std::vector<int> preorder() const;
  /// Σ depth over coordinates, without building anything.
  static std::int64_t entries(const Model& model);

 private:
  std::vector<int> before_, depth_, last_;
};

}  // namespace lanc
