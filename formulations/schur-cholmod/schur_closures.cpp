// The closure rows of the Schur complement.
#include <algorithm>

#include "formulations/schur-cholmod/schur_matrix.h"

namespace lanc {

template <class S>
void SchurMatrix<S>::find_ends() {
  using What = typename End::What;
  for (const Closure& c : model_.closures().closures)
    for (int k = c.row; k < c.row + c.conditions().count; ++k) {
      if (c.body_a != ground) ends_.push_back({k, c.body_a, What::a});
      if (c.body_b != ground) ends_.push_back({k, c.body_b, What::b});
    }
  for (const Coupler& c : model_.closures().couplers)
    for (const Coupler::Term& term : c.terms) {
      if (model_.armature()[term.v] != 0) {
        geared_.push_back({c.row, term.v, term.factor});
        continue;
      }
      const int body = model_.body_of_velocity(term.v), parent = model_.link(body).parent;
      ends_.push_back({c.row, body, What::coordinate, term.v, term.factor});
      if (parent != ground) ends_.push_back({c.row, parent, What::coordinate_of_child, term.v, term.factor});
    }
  end_w_.resize(ends_.size()), end_z_.resize(ends_.size());
}

/// Where φ of a freedom with armature stands: those of a joint come last, in order.
template <class S>
int SchurMatrix<S>::armature_unknown(int velocity) const {
  const int body = model_.body_of_velocity(velocity);
  const Link& link = model_.link(body);
  int at = joints_[body].start + joints_[body].size - 1;
  for (int k = link.v + link.nv - 1; k > velocity; --k) at -= model_.armature()[k] != 0;
  return at;
}

template <class S>
void SchurMatrix<S>::append_closures() {
  using With = typename Meeting::With;
  closure_start_ = size();
  find_ends();
  std::vector<std::vector<int>> children(model_.bodies()), met(model_.bodies());
  for (int i = 0; i < model_.bodies(); ++i)
    if (const int p = model_.link(i).parent; p != ground) children[p].push_back(i);
  std::vector<Column> columns(model_.closures().rows());
  for (int end = 0; end < static_cast<int>(ends_.size()); ++end) {
    const int body = ends_[end].body;
    Column& column = columns[ends_[end].row];
    met[body].push_back(end);
    const auto meet = [&](int joint, With with) {
      for (int a = 0; a < joints_[joint].size; ++a)
        column[joints_[joint].start + a].push_back({with, end, joints_[joint].first + a});
    };
    meet(body, With::joint);
    for (const int child : children[body]) meet(child, With::joint_of_child);
    for (const int other : met[body]) {
      column[closure_start_ + ends_[other].row].push_back({With::closure, end, other});
      if (other != end && ends_[other].row == ends_[end].row)  // a row with itself by way of two ends: both ways
        column[closure_start_ + ends_[other].row].push_back({With::closure, other, end});
    }
  }
  for (const Geared& g : geared_) columns[g.row][armature_unknown(g.velocity)];
  for (int k = 0; k < static_cast<int>(columns.size()); ++k) {
    columns[k][closure_start_ + k];
    for (auto& [row, terms] : columns[k]) {
      for (Meeting& m : terms) m.slot = static_cast<int>(rows_.size()), meetings_.push_back(m);
      rows_.push_back(row);
    }
    starts_.push_back(static_cast<int>(rows_.size()));
  }
  for (Geared& g : geared_) {
    const auto column = rows_.begin() + starts_[closure_start_ + g.row];
    g.slot = static_cast<int>(
        std::lower_bound(column, rows_.begin() + starts_[closure_start_ + g.row + 1], armature_unknown(g.velocity)) -
        rows_.begin());
  }
  values_.resize(rows_.size(), S(0.0));
  for (int k = closure_start_; k < size(); ++k) values_[starts_[k + 1] - 1] = S(1.0);
}

template <class S>
void SchurMatrix<S>::refill_closures(const System<S>& system) {
  using What = typename End::What;
  for (std::size_t e = 0; e < ends_.size(); ++e) {
    const End& end = ends_[e];
    switch (end.what) {
      case What::a: end_w_[e] = system.closure_rows[end.row].a; break;
      case What::b: end_w_[e] = system.closure_rows[end.row].b; break;
      case What::coordinate: end_w_[e] = p_[end.velocity] * S(end.factor); break;
      case What::coordinate_of_child:
        end_w_[e] =
            moved_inward(system.bodies[model_.body_of_velocity(end.velocity)].r, p_[end.velocity]) * S(-end.factor);
        break;
    }
    end_z_[e] = bodies_[end.body].times(end_w_[e]);
  }
  const auto diagonal = [&](int row) -> S& { return values_[starts_[closure_start_ + row + 1] - 1]; };
  std::fill(values_.begin() + starts_[closure_start_], values_.end(), S(0.0));
  for (const Meeting& m : meetings_) {
    if (!counts_[ends_[m.end].row]) continue;
    const bool closure = m.with == Meeting::With::closure;
    if (closure && !counts_[ends_[m.other].row]) continue;
    const Wrench<S>& w = closure ? end_w_[m.other] : m.with == Meeting::With::joint ? w_[m.other] : y_[m.other];
    values_[m.slot] += dot(end_z_[m.end], w);
  }
  for (const Geared& g : geared_) {
    if (!counts_[g.row]) continue;
    const S ratio = S(g.factor) / S(model_.armature()[g.velocity]);
    values_[g.slot] -= ratio, diagonal(g.row) += ratio * S(g.factor);
  }
  for (std::size_t k = 0; k < counts_.size(); ++k)
    if (!counts_[k]) diagonal(static_cast<int>(k)) = S(1.0);
}

/// G_s â + G_η η̇ + γ̿ = 0 with â of the loads alone.
template <class S>
void SchurMatrix<S>::scatter_closures(const RightHandSide<S>& rhs, std::vector<S>& b) const {
  for (std::size_t k = 0; k < counts_.size(); ++k) b[closure_start_ + k] = -rhs.closure[k];
  for (std::size_t e = 0; e < ends_.size(); ++e) {
    S& entry = b[closure_start_ + ends_[e].row];
    entry -= dot(free_[ends_[e].body], end_w_[e]);
    if (ends_[e].what == End::What::coordinate) entry += dot(rhs.bias[ends_[e].body], end_w_[e]);
  }
  for (const Geared& g : geared_)
    b[closure_start_ + g.row] -= S(g.factor) / S(model_.armature()[g.velocity]) * rhs.tau[g.velocity];
  for (std::size_t k = 0; k < counts_.size(); ++k)
    if (!counts_[k]) b[closure_start_ + k] = S(0.0);
}

template void SchurMatrix<double>::find_ends();
template int SchurMatrix<double>::armature_unknown(int) const;
template void SchurMatrix<double>::append_closures();
template void SchurMatrix<double>::refill_closures(const System<double>&);
template void SchurMatrix<double>::scatter_closures(const RightHandSide<double>&, std::vector<double>&) const;
template void SchurMatrix<long double>::find_ends();
template int SchurMatrix<long double>::armature_unknown(int) const;
template void SchurMatrix<long double>::append_closures();
template void SchurMatrix<long double>::refill_closures(const System<long double>&);
template void SchurMatrix<long double>::scatter_closures(const RightHandSide<long double>&,
                                                         std::vector<long double>&) const;
template void SchurMatrix<Count>::find_ends();
template int SchurMatrix<Count>::armature_unknown(int) const;
template void SchurMatrix<Count>::append_closures();
template void SchurMatrix<Count>::refill_closures(const System<Count>&);
template void SchurMatrix<Count>::scatter_closures(const RightHandSide<Count>&, std::vector<Count>&) const;

}  // namespace lanc
