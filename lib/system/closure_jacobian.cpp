#include "lib/system/closure_jacobian.h"

namespace lanc {

int common_ancestor(const Model& model, int a, int b) {
  while (a != b) (a > b ? a : b) = model.link(a > b ? a : b).parent;  // ground is −1, below every body
  return a;
}

template <class S>
ClosureJacobian<S>::ClosureJacobian(const Model& model) : model_(model) {
  const ClosureSet& set = model.closures();
  starts_.assign(1, 0);
  std::vector<int> on_loop;
  for (const Closure& c : set.closures) {
    const int until = common_ancestor(model, c.body_a, c.body_b);
    on_loop.clear();
    for (const int end : {c.body_a, c.body_b}) {
      walks_.push_back({end, until});
      for (int i = end; i != until; i = model.link(i).parent)
        for (int k = model.link(i).v; k < model.link(i).v + model.link(i).nv; ++k) on_loop.push_back(k);
    }
    for (int row = 0; row < c.conditions().count; ++row) {
      columns_.insert(columns_.end(), on_loop.begin(), on_loop.end());
      starts_.push_back(static_cast<int>(columns_.size()));
    }
  }
  for (const Coupler& c : set.couplers) {
    for (const Coupler::Term& term : c.terms) columns_.push_back(term.v);
    starts_.push_back(static_cast<int>(columns_.size()));
  }
  values_.resize(columns_.size());
}

template <class S>
void ClosureJacobian<S>::evaluate(const System<S>& system) {
  const ClosureSet& set = model_.closures();
  S* entry = values_.data();
  const Walk* walk = walks_.data();
  for (const Closure& c : set.closures) {
    for (int k = c.row; k < c.row + c.conditions().count; ++k) {
      const auto& row = system.closure_rows[k];
      for (const auto& [end, wrench] : {std::pair{walk[0], row.a}, std::pair{walk[1], row.b}}) {
        Wrench<S> w = wrench;
        for (int i = end.body; i != end.until;) {
          const Link& link = model_.link(i);
          for (int v = link.v; v < link.v + link.nv; ++v)
            *entry++ = project(model_.column_kind(v), system.columns[v], w);
          if (link.parent != end.until) w = moved_inward(system.bodies[i].r, w);
          i = link.parent;
        }
      }
    }
    walk += 2;
  }
  for (const Coupler& c : set.couplers)
    for (const Coupler::Term& term : c.terms) *entry++ = S(term.factor);
}

template class ClosureJacobian<double>;
template class ClosureJacobian<long double>;
template class ClosureJacobian<Count>;

}  // namespace lanc
