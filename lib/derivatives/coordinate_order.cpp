#include "lib/derivatives/coordinate_order.h"

namespace lanc {

CoordinateOrder::CoordinateOrder(const Model& model)
    : bodies(model.bodies()),
      place(model.nv()),
      coordinate(model.nv()),
      begin(model.bodies()),
      end(model.bodies()),
      tree_end(model.bodies()) {
  const int n = model.bodies();
  std::vector<int> size(n, 1), first(n),
      next(n);  // bodies a body carries, itself included; its place; the next child's
  for (int i = n - 1; i >= 0; --i)
    if (const int p = model.link(i).parent; p != ground) size[p] += size[i];
  int roots = 0;
  for (int i = 0; i < n; ++i) {
    int& free = model.link(i).parent == ground ? roots : next[model.link(i).parent];
    first[i] = free, free += size[i], next[i] = first[i] + 1;
    bodies[first[i]] = i;
  }
  std::vector<int> before(n + 1, 0);  // coordinates of the bodies before
  for (int b = 0; b < n; ++b) {
    const Link& link = model.link(bodies[b]);
    before[b + 1] = before[b] + link.nv;
    for (int k = 0; k < link.nv; ++k) {
      place[link.v + k] = before[b] + k, coordinate[before[b] + k] = link.v + k;
      same = same && before[b] + k == link.v + k;
    }
  }
  for (int i = 0; i < n; ++i) {
    begin[i] = before[first[i]], end[i] = before[first[i] + size[i]];
    chain = chain && (model.link(i).nv == 0 || end[i] == model.nv());
    tree_end[i] = model.link(i).parent == ground ? end[i] : tree_end[model.link(i).parent];
  }
}

}  // namespace lanc
