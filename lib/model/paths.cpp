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

std::int64_t VelocityPaths::entries(const Model& model) {
  const VelocityPaths paths(model);
  std::int64_t sum = 0;
  for (const int d : paths.depth_) sum += d;
  return sum;
}

}  // namespace lanc
