#include "formulations/recursive-loops/loop_factors.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "formulations/recursive-loops/free_delassus.h"

namespace lanc {
namespace {

/// Pivots below this part of what the bodies alone would make of them are rounding errors: 1e-16 times what elimination
/// magnifies them by. States are assembled to 1e-12, which shows squared.
constexpr double vanishing_pivot = 1e-13;
constexpr int most_rows = 6;  // of a closure

}  // namespace

template <class S>
LoopFactors<S>::LoopFactors(const Model& model, EliminationPlan plan)
    : model_(model),
      plan_(std::move(plan)),
      free_(free_delassus_diagonal(model)),
      star_(model.bodies()),
      freedoms_(model.nv()),
      columns_(plan_.columns),
      responses_(plan_.responses),
      scratch_(plan_.most_responses),
      delassus_(plan_.delassus),
      weights_(plan_.weights),
      inverse_(model.closures().rows()),
      taken_(model.closures().rows()) {
  for (int k = 0; k < model.nv(); ++k) kinds_.push_back(model.column_kind(k));
}

template <class S>
bool LoopFactors<S>::factorise(const System<S>& system, std::span<const char> counts) {
  start(system);
  return with_rows(plan_.rows_each, [&](auto rows) { return eliminate<rows>(system, counts); });
}

/// Flattened: calls and what they load anew cost a tenth of a ladder's factors.
template <class S>
template <int fixed>
[[gnu::flatten]] bool LoopFactors<S>::eliminate(const System<S>& system, std::span<const char> counts) {
  for (const int at : plan_.order) {
    if (at >= 0) {
      const BodyStep& step = plan_.bodies[at];
      eliminate_body(system, step);
      if (step.columns > 0) eliminate_columns<fixed>(system, step);
    } else {
      const ClosureStep& step = plan_.closures[-1 - at];
      if (!find_pivots<fixed>(step, counts)) return false;
      eliminate_closure<fixed>(step);
    }
  }
  return true;
}

template <class S>
void LoopFactors<S>::start(const System<S>& system) {
  const S o(0.0);
  std::fill(columns_.begin(), columns_.end(), Wrench<S>{{o, o, o}, {o, o, o}});
  for (const ClosureEnds& ends : plan_.ends)
    for (int k = 0; k < ends.rows; ++k) {
      const auto& row = system.closure_rows[ends.row + k];
      if (ends.column_a >= 0) columns_[ends.column_a + k] = row.a;
      if (ends.column_b >= 0) columns_[ends.column_b + k] += row.b;
    }
  std::fill(delassus_.begin(), delassus_.end(), o);
  std::fill(taken_.begin(), taken_.end(), o);
  dropped_ = 0;
}

template <class S>
void LoopFactors<S>::eliminate_body(const System<S>& system, const BodyStep& step) {
  ArticulatedInertia<S>& M = star_[step.body];
  if (step.untouched)
    M = expanded(system.bodies[step.body].inertia);
  else
    add(M, system.bodies[step.body].inertia);
  const auto release = [&](int k, const ArticulatedInertia<S>& inertia) {
    const Wrench<S> U = times_column(inertia, kind(k), system.columns[k]);
    S N = project(kind(k), system.columns[k], U);
    if (model_.has_armature()) N += S(model_.armature()[k]);
    freedoms_[k].inverse = S(1.0) / N;
    freedoms_[k].D = U * freedoms_[k].inverse;
    return U;
  };
  if (step.parent == ground && step.nv == 1) {  // nothing is left of it
    release(step.v, M);
    return;
  }
  ArticulatedInertia<S> rest;
  rest = M;
  for (int k = step.v; k < step.v + step.nv; ++k) {
    const Wrench<S> U = release(k, rest);
    subtract_outer(rest, freedoms_[k].D, U);
  }
  if (step.parent != ground) {
    if (step.first_to_parent)
      star_[step.parent] = moved_inward(system.bodies[step.body].r, rest);
    else
      add(star_[step.parent], moved_inward(system.bodies[step.body].r, rest));
  }
}

template <class S>
template <int fixed>
void LoopFactors<S>::eliminate_columns(const System<S>& system, const BodyStep& step) {
  if (step.nv == 1 && kind(step.v) == ColumnKind::rotation && step.terms.begin == step.terms.end)
    release_hinge<fixed>(system, step);
  else
    release_columns<fixed>(system, step);
  const int w = step.columns;
  for (int m = step.meetings.begin; m < step.meetings.end; ++m) {
    const Meeting& both = plan_.meetings[m];
    const int rows = fixed ? fixed : both.first_rows, columns = fixed ? fixed : both.second_rows;
    S* const block = delassus_.data() + both.block;
    for (int k = 0; k < step.nv; ++k) {
      const S* const first = scratch_.data() + k * w + both.first;
      const S* const second = responses_.data() + step.responses + k * w + both.second;
      for (int x = 0; x < rows; ++x)
        for (int y = 0; y < columns; ++y) block[x * columns + y] += first[x] * second[y];
    }
  }
}

/// u, u / N, and what is left of the columns handed to the parent.
template <class S>
template <int fixed>
void LoopFactors<S>::release_columns(const System<S>& system, const BodyStep& step) {
  const int w = step.columns;
  S* const u = scratch_.data();
  std::fill_n(u, step.nv * w, S(0.0));
  for (int t = step.terms.begin; t < step.terms.end; ++t)
    u[plan_.terms[t].freedom * w + plan_.terms[t].column] += S(plan_.terms[t].factor);
  for (int at = step.attachments.begin; at < step.attachments.end; ++at) {
    const Attachment& a = plan_.attachments[at];
    for (int x = 0; x < (fixed ? fixed : a.rows); ++x) {
      Wrench<S> e;
      e = columns_[step.first_column + a.column + x];
      for (int k = 0; k < step.nv; ++k) {
        const Freedom& freedom = freedoms_[step.v + k];
        const int here = k * w + a.column + x;
        const S along = u[here] += project(kind(step.v + k), system.columns[step.v + k], e);
        responses_[step.responses + here] = along * freedom.inverse;
        if (a.to >= 0 || k + 1 < step.nv) e -= freedom.D * along;
      }
      if (a.to >= 0) columns_[a.to + x] += moved_inward(system.bodies[step.body].r, e);
    }
  }
}

/// The same for one hinge without couplers: a tenth of the time of a ladder's factors.
template <class S>
template <int fixed>
void LoopFactors<S>::release_hinge(const System<S>& system, const BodyStep& step) {
  Wrench<S> D;
  D = freedoms_[step.v].D;
  const S inverse = freedoms_[step.v].inverse;
  const Vec3<S> axis = system.columns[step.v].angular, r = system.bodies[step.body].r;
  for (int at = step.attachments.begin; at < step.attachments.end; ++at) {
    const Attachment& a = plan_.attachments[at];
    for (int x = 0; x < (fixed ? fixed : a.rows); ++x) {
      const Wrench<S>& e = columns_[step.first_column + a.column + x];
      const S along = dot(axis, e.moment);
      scratch_[a.column + x] = along;
      responses_[step.responses + a.column + x] = along * inverse;
      if (a.to >= 0) columns_[a.to + x] += moved_inward(r, e - D * along);
    }
  }
}

/// W and D⁻¹ with W S_cc Wᵀ = D.
template <class S>
template <int fixed>
bool LoopFactors<S>::find_pivots(const ClosureStep& step, std::span<const char> counts) {
  const int m = fixed ? fixed : step.rows;
  S rest[most_rows][most_rows];
  S* const W = weights_.data() + step.weights;
  bool left[most_rows];
  for (int r = 0; r < m; ++r) {
    left[r] = counts.empty() || counts[step.row + r];
    inverse_[step.row + r] = S(0.0);
    for (int x = 0; x < m; ++x) rest[r][x] = delassus_[step.block + x * m + r], W[r * m + x] = S(r == x ? 1.0 : 0.0);
  }
  int found = 0, wanted = 0;
  for (int r = 0; r < m; ++r) wanted += left[r];
  for (; found < wanted; ++found) {
    int best = -1;
    double largest = counts.empty() ? vanishing_pivot : 0, unit = 1;  // the pivot of `best`, and what it is measured in
    for (int r = 0; r < m; ++r) {
      if (!left[r]) continue;
      const double pivot = to_double(rest[r][r]);
      const double size = std::max(free_[step.row + r], pivot + to_double(taken_[step.row + r]));
      if (!(pivot >= -vanishing_pivot * size && pivot < 1e300)) return false;
      if (pivot * unit > largest * size) largest = pivot, unit = size, best = r;
    }
    if (best < 0) break;
    left[best] = false;
    const S inverse = inverse_[step.row + best] = S(1.0) / rest[best][best];
    for (int r = 0; r < m; ++r) {
      if (!left[r]) continue;
      const S factor = rest[r][best] * inverse;
      for (int x = 0; x < m; ++x) rest[r][x] -= factor * rest[best][x], W[r * m + x] -= factor * W[best * m + x];
    }
  }
  dropped_ += m - found;
  return counts.empty() || found == wanted;
}

template <class S>
template <int fixed>
void LoopFactors<S>::eliminate_closure(const ClosureStep& step) {
  const int m = fixed ? fixed : step.rows;
  const S* const W = weights(step);
  const S* const inverse = inverse_.data() + step.row;
  for (int at = step.attachments.begin; at < step.attachments.end; ++at) {
    const Attachment& a = plan_.attachments[at];
    const int columns = fixed ? fixed : a.rows;
    S* const T = delassus_.data() + a.block;
    for (int y = 0; y < columns; ++y) {
      S before[most_rows], taken(0.0);
      for (int x = 0; x < m; ++x) before[x] = T[x * columns + y];
      for (int r = 0; r < m; ++r) {
        S t = W[r * m] * before[0];
        for (int x = 1; x < m; ++x) t += W[r * m + x] * before[x];
        T[r * columns + y] = t;
        taken += t * t * inverse[r];
      }
      taken_[a.row + y] += taken;
    }
  }
  for (int at = step.meetings.begin; at < step.meetings.end; ++at) {
    const Meeting& both = plan_.meetings[at];
    const int rows = fixed ? fixed : both.first_rows, columns = fixed ? fixed : both.second_rows;
    const S* const first = delassus_.data() + both.first;
    const S* const second = delassus_.data() + both.second;
    S* const block = delassus_.data() + both.block;
    for (int x = 0; x < rows; ++x)
      for (int y = 0; y < columns; ++y) {
        S rest = block[x * columns + y];
        for (int r = 0; r < m; ++r) rest -= first[r * rows + x] * inverse[r] * second[r * columns + y];
        block[x * columns + y] = rest;
      }
  }
  if (step.body >= 0) hand_to_body<fixed>(step);
}

template <class S>
template <int fixed>
void LoopFactors<S>::hand_to_body(const ClosureStep& step) {
  const int m = fixed ? fixed : step.rows;
  const S* const W = weights(step);
  const S* const inverse = inverse_.data() + step.row;
  Wrench<S>* const E = columns_.data() + step.first_column;
  Wrench<S> before[most_rows];
  std::copy_n(E, m, before);
  if (step.first_to_body) star_[step.body] = expanded(RigidInertia<S>());
  for (int r = 0; r < m; ++r) {
    E[r] = before[0] * W[r * m];
    for (int x = 1; x < m; ++x) E[r] += before[x] * W[r * m + x];
    subtract_outer(star_[step.body], E[r] * -inverse[r], E[r]);
  }
  for (int at = step.attachments.begin; at < step.attachments.end; ++at) {
    const Attachment& a = plan_.attachments[at];
    const int columns = fixed ? fixed : a.rows;
    const S* const T = delassus_.data() + a.block;
    for (int y = 0; y < columns; ++y)
      for (int r = 0; r < m; ++r) columns_[a.to + y] -= E[r] * (T[r * columns + y] * inverse[r]);
  }
}

template class LoopFactors<double>;
template class LoopFactors<long double>;
template class LoopFactors<Count>;

}  // namespace lanc
