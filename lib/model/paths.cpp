#include "lib/model/paths.h"

namespace lanc {

VelocityPaths::VelocityPaths(const Model& model) : before_(model.nv()), depth_(model.nv()), last_(model.bodies()) {
  for (int i = 0; i < model.bodies(); ++i) {
    const Link& link = model.link(i);
    int last = link.parent == ground ? -1 : last_[link.parent];
    for (int k = link.v; k < link.v + link.nv; ++k) {
      before_[k] = last;
      depth_[k] = (last < 0 ? 0 : depth_[last]) + 1;
      last = k;
    }
    last_[i] = last;
  }
}

std::vector<int> VelocityPaths::preorder() const {
  const int n = static_cast<int>(before_.size());
  std::vector<int> carried(n, 1), next(n), order(n);  // next: place of the next one that is carried by a coordinate
  for (int k = n - 1; k >= 0; --k)
    if (before_[k] >= 0) carried[before_[k]] += carried[k];
  int next_root = 0;
  for (int k = 0; k < n; ++k) {
    int& place = before_[k] < 0 ? next_root : next[before_[k]];
    order[place] = k;
    next[k] = place + 1;
    place += carried[k];
  }
  return order;
}

std::int64_t VelocityPaths::entries(const Model& model) {
  const VelocityPaths paths(model);
  std::int64_t sum = 0;
  for (const int d : paths.depth_) sum += d;
  return sum;
}

}  // namespace lanc
