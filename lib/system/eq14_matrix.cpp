#include "lib/system/eq14_matrix.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "lib/system/closure_jacobian.h"

namespace lanc {

namespace {

/// An unknown: which block, which component.
struct Unknown {
  Block block;
  int k;
};
constexpr Unknown angular(int k) { return {Block::acceleration, k}; }
constexpr Unknown linear(int k) { return {Block::acceleration, 3 + k}; }
constexpr Unknown moment(int k) { return {Block::wrench, k}; }
constexpr Unknown force(int k) { return {Block::wrench, 3 + k}; }

/// Entries of body i that never change: −1 between f̂_i and â_i, and the unit part 1 of B_ip between f̂_i and â_p.
/// put(u, u's body, w, w's body, value) is told one of each pair of entries that symmetry makes equal.
template <class Put>
void constant_entries(int body, const Link& link, Put&& put) {
  for (int k = 0; k < 6; ++k) put(Unknown{Block::wrench, k}, body, Unknown{Block::acceleration, k}, body, -1.0);
  if (link.parent == ground) return;
  for (int k = 0; k < 6; ++k) put(Unknown{Block::wrench, k}, body, Unknown{Block::acceleration, k}, link.parent, 1.0);
}

/// Entries of body i that a state changes: M_i, the rest of B_ip, C_i, and the armature (which only the model changes).
template <class S, class Put>
void varying_entries(const Model& model, int i, const typename System<S>::Body& body, const Motion<S>* columns,
                     Put&& put) {
  const Link& link = model.link(i);
  // Left to itself g++ 12 calls these once an entry, and a refill takes three times as long.
  const auto own = [&](Unknown u, Unknown w, const S& value) __attribute__((always_inline)) { put(u, i, w, i, value); };
  const RigidInertia<S>& M = body.inertia;
  own(angular(0), angular(0), M.J.xx), own(angular(1), angular(1), M.J.yy), own(angular(2), angular(2), M.J.zz);
  own(angular(0), angular(1), M.J.xy), own(angular(0), angular(2), M.J.xz), own(angular(1), angular(2), M.J.yz);
  own(angular(0), linear(1), -M.h.z), own(angular(0), linear(2), M.h.y), own(angular(1), linear(0), M.h.z);
  own(angular(1), linear(2), -M.h.x), own(angular(2), linear(0), -M.h.y), own(angular(2), linear(1), M.h.x);
  for (int k = 0; k < 3; ++k) own(linear(k), linear(k), M.mass);
  if (link.parent != ground) {  // −[r]×, in the rows that give the linear part of â_i
    const auto up = [&](Unknown u, Unknown w, const S& value) __attribute__((always_inline)) {
      put(u, i, w, link.parent, value);
    };
    up(force(0), angular(1), body.r.z), up(force(0), angular(2), -body.r.y), up(force(1), angular(0), -body.r.z);
    up(force(1), angular(2), body.r.x), up(force(2), angular(0), body.r.y), up(force(2), angular(1), -body.r.x);
  }
  for (int k = 0; k < link.nv; ++k) {
    const Unknown vdot{Block::velocity, k};
    const ColumnKind kind = model.column_kind(link.v + k);
    const Motion<S>& C = columns[k];
    if (kind != ColumnKind::translation)
      own(vdot, moment(0), C.angular.x), own(vdot, moment(1), C.angular.y), own(vdot, moment(2), C.angular.z);
    if (kind != ColumnKind::rotation)
      own(vdot, force(0), C.linear.x), own(vdot, force(1), C.linear.y), own(vdot, force(2), C.linear.z);
    if (!model.has_armature()) continue;
    if (const double armature = model.armature()[link.v + k]; armature != 0) own(vdot, vdot, S(armature));
  }
}

/// Conditions on orientations alone: their rows of G_a and G_b have no part for the velocity of the origin.
constexpr bool only_turns(ConditionKind kind) {
  return kind == ConditionKind::perpendicular || kind == ConditionKind::turn;
}

/// Entries of the closure rows: −G_s against â, −G_η against η̇, and the diagonal that stands in for a row that does not
/// count.
template <class S, class Put>
void closure_entries(const Model& model, const std::vector<typename System<S>::ClosureRow>& rows,
                     std::span<const char> counts, Put&& put) {
  constexpr Unknown lambda{Block::closure, 0};
  const S o(0.0), one(1.0);
  for (const Closure& c : model.closures().closures)
    for (int i = 0; i < c.conditions().count; ++i) {
      const int k = c.row + i;
      const bool on = counts[k];
      put(lambda, k, lambda, k, on ? o : one);
      const auto side = [&](int body, const Wrench<S>& G) {
        if (body == ground) return;
        const auto entry = [&](Unknown u, const S& value) { put(lambda, k, u, body, on ? -value : o); };
        entry(angular(0), G.moment.x), entry(angular(1), G.moment.y), entry(angular(2), G.moment.z);
        if (only_turns(c.conditions().rows[i].kind)) return;
        entry(linear(0), G.force.x), entry(linear(1), G.force.y), entry(linear(2), G.force.z);
      };
      side(c.body_a, rows[k].a), side(c.body_b, rows[k].b);
    }
  for (const Coupler& c : model.closures().couplers) {
    const bool on = counts[c.row];
    put(lambda, c.row, lambda, c.row, on ? o : one);
    for (const Coupler::Term& term : c.terms) {
      const int body = model.body_of_velocity(term.v);
      put(lambda, c.row, Unknown{Block::velocity, term.v - model.link(body).v}, body, on ? S(-term.factor) : o);
    }
  }
}

/// Values for which every pivot of eq. 18 is positive: unit inertia, no offset, columns along different axes.
template <class S>
struct Sample {
  typename System<S>::Body body;
  std::array<Motion<S>, 6> columns;

  Sample(const Model& model, const Link& link) {
    const S o(0.0), one(1.0);
    body = {{o, o, o}, {one, {o, o, o}, {one, one, one, o, o, o}}};
    const Vec3<S> axes[] = {{one, o, o}, {o, one, o}, {o, o, one}};
    int rotations = 0, translations = 0;
    for (int k = 0; k < link.nv; ++k) {
      const ColumnKind kind = model.column_kind(link.v + k);
      const Vec3<S> zero{o, o, o};
      columns[k] = kind == ColumnKind::translation ? Motion<S>{zero, axes[translations++ % 3]}
                                                   : Motion<S>{axes[rotations++ % 3], zero};
    }
  }
};

/// First row and column of a body. Bodies are numbered root to leaf; the matrix has them in that order or its reverse.
int start(const Model& model, const Eq14Layout& layout, int body) {
  const Link& link = model.link(body);
  if (layout.bodies == BodyOrder::root_to_leaf) return 12 * body + link.v;
  return 12 * (model.bodies() - 1 - body) + model.nv() - (link.v + link.nv);
}

}  // namespace

int position(const Model& model, const Eq14Layout& layout, const BlockOrder& order, int body, Block block) {
  int result = start(model, layout, body);
  for (const Block b : order) {
    if (b == block) break;
    result += b == Block::velocity ? model.link(body).nv : 6;
  }
  return result;
}

template <class S>
std::optional<std::string> Eq14Matrix<S>::objection(const Model& model) {
  // the most a body can have: M 24, ∓1 12, B_ip 24, and C with its transpose 12 and A 1 per freedom
  std::int64_t most = 60 * std::int64_t(model.bodies()) + 13 * std::int64_t(model.nv());
  most += 25 * std::int64_t(model.closures().body_rows);  // the diagonal, two bodies
  for (const Coupler& c : model.closures().couplers) most += 1 + 2 * std::int64_t(c.terms.size());
  if (most <= std::numeric_limits<int>::max()) return std::nullopt;
  return fmt::format("the matrix of eq. 14 has up to {:.2g} entries, more than 32-bit indices can address",
                     static_cast<double>(most));
}

template <class S>
Eq14Matrix<S>::Eq14Matrix(const Model& model, const Eq14Layout& layout) : model_(model), layout_(layout) {
  if (const auto why = objection(model)) throw InputError(*why);
  if (layout.upper_triangle && layout.rows != layout.columns)
    throw InputError("half of eq. 14 needs the same order of blocks in rows and columns");
  if (model.has_closures()) place_closures();
  places_.resize(model.bodies());
  for (int i = 0; i < model.bodies(); ++i)
    for (const Block block : {Block::acceleration, Block::wrench, Block::velocity}) {
      const int before = closures_before_.empty() ? 0 : closures_before_[i];
      places_[i].row[static_cast<int>(block)] = before + position(model, layout, layout.rows, i, block);
      places_[i].column[static_cast<int>(block)] = before + position(model, layout, layout.columns, i, block);
    }
  build();
}

namespace {

/// The body of the closure's loop that is the last to be met in that order. The bodies on the two branches are numbered
/// upwards from root to leaf.
int last_of_loop(const Model& model, const Closure& c, BodyOrder order) {
  if (order == BodyOrder::root_to_leaf) return std::max(c.body_a, c.body_b);
  const int until = common_ancestor(model, c.body_a, c.body_b);
  int last = std::max(c.body_a, c.body_b);
  for (const int end : {c.body_a, c.body_b})
    for (int i = end; i != until; i = model.link(i).parent) last = std::min(last, i);
  return last;
}

int last_of_terms(const Model& model, const Coupler& c, BodyOrder order) {
  int last = model.body_of_velocity(c.terms[0].v);
  for (const Coupler::Term& term : c.terms) {
    const int body = model.body_of_velocity(term.v);
    last = order == BodyOrder::root_to_leaf ? std::max(last, body) : std::min(last, body);
  }
  return last;
}

}  // namespace

template <class S>
void Eq14Matrix<S>::place_closures() {
  const ClosureSet& set = model_.closures();
  std::vector<int> behind(set.rows());  // the body a row stands behind
  for (const Closure& c : set.closures)
    std::fill_n(behind.begin() + c.row, c.conditions().count, last_of_loop(model_, c, layout_.bodies));
  for (const Coupler& c : set.couplers) behind[c.row] = last_of_terms(model_, c, layout_.bodies);

  const int n = model_.bodies();
  std::vector<int> count(n, 0);
  for (const int body : behind) ++count[body];
  closures_before_.resize(n);
  const bool ascending = layout_.bodies == BodyOrder::root_to_leaf;
  for (int i = 0, before = 0; i < n; ++i) {
    const int body = ascending ? i : n - 1 - i;
    closures_before_[body] = before, before += count[body];
  }
  std::vector<int> next(n);
  for (int i = 0; i < n; ++i) next[i] = start(i) + 12 + model_.link(i).nv;
  closure_place_.resize(set.rows());
  for (int k = 0; k < set.rows(); ++k) closure_place_[k] = next[behind[k]]++;
  counts_.assign(set.rows(), true);
}

/// Bodies are numbered root to leaf; the matrix has them in that order or in its reverse.
template <class S>
int Eq14Matrix<S>::start(int body) const {
  return (closures_before_.empty() ? 0 : closures_before_[body]) + lanc::start(model_, layout_, body);
}

template <class S>
int Eq14Matrix<S>::closure_of_column(int column) const {
  const auto found = std::find(closure_place_.begin(), closure_place_.end(), column);
  return found == closure_place_.end() ? -1 : static_cast<int>(found - closure_place_.begin());
}

template <class S>
int Eq14Matrix<S>::body_of_column(int column) const {
  int low = 0, high = model_.bodies();  // start() is monotonic in the body
  const bool ascending = layout_.bodies == BodyOrder::root_to_leaf;
  while (high - low > 1) {
    const int middle = (low + high) / 2;
    // ascending: start(middle) <= column keeps the right half; descending: column < start(middle − 1) does
    const bool right = ascending ? start(middle) <= column : column < start(middle - 1);
    (right ? low : high) = middle;
  }
  return low;
}

template <class S>
void Eq14Matrix<S>::build() {
  // Every pass calls put(row, column, value, varies) for all entries, in the same order. No closure row of the sample
  // counts.
  const int closures = model_.closures().rows();
  const std::vector<typename System<S>::ClosureRow> open(closures);
  const std::vector<char> none(closures, false);
  const auto for_all = [&](auto&& put) {
    const auto pair = [&](bool varies) {
      return [&, varies](Unknown u, int ub, Unknown w, int wb, const S& value) {
        const int ur = row(ub, u.block) + u.k, uc = column(ub, u.block) + u.k;
        const int wr = row(wb, w.block) + w.k, wc = column(wb, w.block) + w.k;
        const bool diagonal = ub == wb && u.block == w.block && u.k == w.k;
        if (layout_.upper_triangle) return put(std::min(ur, wr), std::max(uc, wc), value, varies);
        put(ur, wc, value, varies);
        if (!diagonal) put(wr, uc, value, varies);
      };
    };
    for (int i = 0; i < model_.bodies(); ++i) {
      const Link& link = model_.link(i);
      const Sample<S> sample(model_, link);
      constant_entries(i, link, pair(false));
      varying_entries<S>(model_, i, sample.body, sample.columns.data(), pair(true));
    }
    closure_entries<S>(model_, open, none, pair(true));
  };

  const int n = 12 * model_.bodies() + model_.nv() + closures;
  starts_.assign(n + 1, 0);
  int varying = 0;
  for_all([&](int, int column, const S&, bool varies) { ++starts_[column + 1], varying += varies; });
  for (int c = 0; c < n; ++c) starts_[c + 1] += starts_[c];

  rows_.resize(starts_[n]);
  values_.resize(starts_[n]);
  std::vector<int> entry(starts_[n]);  // which varying entry stands here, or −1
  std::vector<int> cursor(starts_.begin(), starts_.end() - 1);
  int next = 0;
  for_all([&](int row, int column, const S& value, bool varies) {
    const int to = cursor[column]++;
    rows_[to] = row, values_[to] = value, entry[to] = varies ? next++ : -1;
  });

  slots_.resize(varying);
  struct Item {
    int row, entry;
    S value;
  };
  std::vector<Item> items;
  for (int c = 0; c < n; ++c) {
    items.clear();
    for (int p = starts_[c]; p < starts_[c + 1]; ++p) items.push_back({rows_[p], entry[p], values_[p]});
    std::sort(items.begin(), items.end(), [](const Item& a, const Item& b) { return a.row < b.row; });
    for (int p = starts_[c]; const Item& item : items) {
      rows_[p] = item.row, values_[p] = item.value;
      if (item.entry >= 0) slots_[item.entry] = p;
      ++p;
    }
  }
}

template <class S>
void Eq14Matrix<S>::refill(const System<S>& system, std::span<const char> independent) {
  if (independent.empty())
    std::fill(counts_.begin(), counts_.end(), true);
  else
    std::copy_n(independent.begin(), counts_.size(), counts_.begin());
  const int* slot = slots_.data();
  S* const values = values_.data();
  const auto run = [&](auto&& put) {
    for (int i = 0; i < model_.bodies(); ++i)
      varying_entries<S>(model_, i, system.bodies[i], system.columns.data() + model_.link(i).v, put);
    closure_entries<S>(model_, system.closure_rows, counts_, put);
  };
  if (layout_.upper_triangle) {
    run([&](Unknown, int, Unknown, int, const S& value) { values[*slot++] = value; });
  } else {
    // Inlined, the comparison is one of constants; g++ 12 would make 24 calls a body.
    run([&](Unknown u, int ub, Unknown w, int wb, const S& value) __attribute__((always_inline)) {
      values[*slot++] = value;
      if (!(ub == wb && u.block == w.block && u.k == w.k)) values[*slot++] = value;
    });
  }
}

namespace {
template <class S>
void write(const Vec3<S>& a, S* to) {
  to[0] = a.x, to[1] = a.y, to[2] = a.z;
}
template <class S>
Vec3<S> read(const S* from) {
  return {from[0], from[1], from[2]};
}
}  // namespace

template <class S>
void Eq14Matrix<S>::scatter(const RightHandSide<S>& rhs, std::vector<S>& b) const {
  for (int i = 0; i < model_.bodies(); ++i) {
    const Link& link = model_.link(i);
    S* const momentum = b.data() + row(i, Block::acceleration);
    S* const kinematic = b.data() + row(i, Block::wrench);
    S* const joint = b.data() + row(i, Block::velocity);
    write(rhs.force[i].moment, momentum), write(rhs.force[i].force, momentum + 3);
    write(-rhs.bias[i].angular, kinematic), write(-rhs.bias[i].linear, kinematic + 3);
    for (int k = 0; k < link.nv; ++k) joint[k] = rhs.tau[link.v + k];
  }
  for (std::size_t k = 0; k < closure_place_.size(); ++k) b[closure_place_[k]] = counts_[k] ? rhs.closure[k] : S(0.0);
}

template <class S>
void Eq14Matrix<S>::gather(const std::vector<S>& x, Solution<S>& solution) const {
  for (int i = 0; i < model_.bodies(); ++i) {
    const Link& link = model_.link(i);
    const S* const a = x.data() + column(i, Block::acceleration);
    const S* const f = x.data() + column(i, Block::wrench);
    const S* const vdot = x.data() + column(i, Block::velocity);
    solution.acceleration[i] = {read(a), read(a + 3)};
    solution.wrench[i] = {read(f), read(f + 3)};
    for (int k = 0; k < link.nv; ++k) solution.vdot[link.v + k] = vdot[k];
  }
  for (std::size_t k = 0; k < closure_place_.size(); ++k) solution.lambda[k] = x[closure_place_[k]];
}

template class Eq14Matrix<double>;
template class Eq14Matrix<long double>;
template class Eq14Matrix<Count>;

}  // namespace lanc
