#include "formulations/recursive-loops/quotient_graph.h"

#include <algorithm>
#include <iterator>

namespace lanc {
namespace {

using Set = std::vector<int>;  // ascending

void insert(Set& set, int x) {
  const auto at = std::lower_bound(set.begin(), set.end(), x);
  if (at == set.end() || *at != x) set.insert(at, x);
}

void erase(Set& set, int x) {
  const auto at = std::lower_bound(set.begin(), set.end(), x);
  if (at != set.end() && *at == x) set.erase(at);
}

/// set ∪ others without x.
void unite(Set& set, const Set& others, int x) {
  Set all;
  all.reserve(set.size() + others.size());
  std::set_union(set.begin(), set.end(), others.begin(), others.end(), std::back_inserter(all));
  erase(all, x);
  set.swap(all);
}

}  // namespace

QuotientGraph::QuotientGraph(const Model& model, EliminationRule rule)
    : model_(model), rule_(rule), bodies_(model.bodies()), body_gone_(model.bodies()), couplers_on_(model.bodies()) {
  for (const Link& link : model.links())
    if (link.parent != ground) ++bodies_[link.parent].children_left;
  const ClosureSet& set = model.closures();
  closures_.resize(set.closures.size() + set.couplers.size());
  closure_gone_.resize(closures_.size());
  int c = 0;
  for (const lanc::Closure& closure : set.closures) {
    closures_[c].row = closure.row, closures_[c].rows = closure.conditions().count;
    for (const int body : {closure.body_a, closure.body_b})
      if (body == ground)
        closures_[c].grounded = true;
      else
        meet(c, body);
    ++c;
  }
  for (const Coupler& coupler : set.couplers) {
    closures_[c].row = coupler.row, closures_[c].rows = 1;
    for (const Coupler::Term& term : coupler.terms) {
      const int body = model.body_of_velocity(term.v);
      meet(c, body);
      insert(couplers_on_[body], c);
    }
    closures_[c].velocities_left = static_cast<int>(closures_[c].bodies.size());
    ++c;
  }
  for (int i = 0; i < model.bodies(); ++i) consider(i);
  for (c = 0; c < closures(); ++c) consider(-1 - c);
}

void QuotientGraph::meet(int closure, int body) {
  insert(closures_[closure].bodies, body);
  insert(bodies_[body].closures, closure);
  insert(bodies_[body].met, closure);
}

bool QuotientGraph::admitted(int node) const {
  if (node >= 0) return !body_gone_[node] && bodies_[node].children_left == 0;
  const Closure& c = closures_[-1 - node];
  const bool all = c.grounded || rule_ == EliminationRule::bodies_first;
  return !closure_gone_[-1 - node] && c.velocities_left == 0 && c.bodies.size() <= (all ? 0u : 1u);
}

int QuotientGraph::degree(int node) const {
  int rows = 0;
  for (const int c : node >= 0 ? bodies_[node].closures : closures_[-1 - node].closures) rows += closures_[c].rows;
  constexpr int of_body = 6;
  if (node < 0 && !closures_[-1 - node].bodies.empty()) rows += of_body;
  return rows;
}

bool QuotientGraph::next(int& node) {
  while (!queue_.empty()) {
    const auto [key, candidate] = queue_.top();
    queue_.pop();
    if (!admitted(candidate)) continue;
    if (const int now = degree(candidate); now != key) {  // degrees may have changed since
      if (now > key) {
        queue_.emplace(now, candidate);
        continue;
      }
    }
    node = candidate;
    return true;
  }
  return false;
}

void QuotientGraph::eliminate_body(int i) {
  body_gone_[i] = true;
  const int parent = model_.link(i).parent;
  if (parent != ground) --bodies_[parent].children_left;
  for (const int c : couplers_on_[i]) --closures_[c].velocities_left;
  const Set& around = bodies_[i].closures;
  for (const int c : around) {
    erase(closures_[c].bodies, i);
    if (parent == ground)
      closures_[c].grounded = true;
    else
      meet(c, parent);
    unite(closures_[c].closures, around, c);
  }
  for (const int c : around) consider(-1 - c);
  if (parent != ground) consider(parent);
}

void QuotientGraph::eliminate_closure(int c) {
  closure_gone_[c] = true;
  const Set around = closures_[c].closures;
  const Set& bodies = closures_[c].bodies;
  for (const int i : bodies) erase(bodies_[i].closures, c);
  for (const int d : around) {
    erase(closures_[d].closures, c);
    unite(closures_[d].closures, around, d);
    for (const int i : bodies) meet(d, i);
    if (closures_[c].grounded) closures_[d].grounded = true;
  }
  for (const int d : around) consider(-1 - d);
  for (const int i : bodies) consider(i);
}

}  // namespace lanc
