#include "formulations/recursive-loops/loop_factors.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "formulations/recursive-loops/free_delassus.h"

namespace lanc {
namespace {

/// Pivots below this part of what the bodies alone would make of them are rounding errors: 1e-16 times what elimination
/// magnifies them by. States are assembled to 1e-12, which shows squared.
constexpr double vanishing_pivot = 1e-13;

}  // namespace

template <class S, int width>
LoopFactors<S, width>::LoopFactors(const Model& model, EliminationPlan plan)
    : model_(model),
      plan_(std::move(plan)),
      free_(free_delassus_diagonal(model)),
      star_(model.bodies()),
      freedoms_(model.nv()),
      rows_(2 * model.closures().rows() / width),
      columns_(plan_.columns),
      responses_(plan_.responses),
      scratch_(plan_.most_responses),
      delassus_(plan_.delassus),
      weights_(plan_.weights),
      weight_columns_(plan_.weights),
      inverse_(model.closures().rows() / width),
      taken_(model.closures().rows() / width) {
  if (plan_.width != width) throw std::logic_error("a plan in strips of another width");
  for (int k = 0; k < model.nv(); ++k) kinds_.push_back(model.column_kind(k));
}

template <class S, int width>
bool LoopFactors<S, width>::factorise(const System<S>& system, std::span<const char> counts) {
  start(system);
  return eliminate(system, counts);
}

/// Flattened (g++ 12 sees the attribute in the class only): calls and what they load anew cost a tenth of a ladder's
/// factors.
template <class S, int width>
bool LoopFactors<S, width>::eliminate(const System<S>& system, std::span<const char> counts) {
  for (const int at : plan_.order) {
    if (at < 0) {
      const ClosureStep& step = plan_.closures[-1 - at];
      if (!find_pivots(step, counts)) return false;
      eliminate_closure(step);
    } else if (const BodyStep& step = plan_.bodies[at]; step.nv == 1) {
      eliminate_body<1>(system, step);
    } else {
      eliminate_joint(system, step);
    }
  }
  return true;
}

/// The rows of G_s where they act.
template <class S, int width>
void LoopFactors<S, width>::start(const System<S>& system) {
  const Rows o(0.0);
  for (const ClosureEnds& ends : plan_.ends)
    for (int s = 0; s < count<width>(ends.strips); ++s) {
      const auto* const rows = system.closure_rows.data() + (ends.strip + s) * width;
      Wrench<Rows> a{{o, o, o}, {o, o, o}}, b = a;
      for (int k = 0; k < width; ++k) set_lane<width>(a, k, rows[k].a), set_lane<width>(b, k, rows[k].b);
      rows_[2 * (ends.strip + s)] = a, rows_[2 * (ends.strip + s) + 1] = b;
      if (ends.column_a >= 0) columns_[ends.column_a + s] = a;
      if (ends.column_b >= 0) columns_[ends.column_b + s] = b;
    }
  std::fill(taken_.begin(), taken_.end(), o);
  dropped_ = 0;
}

template <class S, int width>
void LoopFactors<S, width>::eliminate_joint(const System<S>& system, const BodyStep& step) {
  eliminate_body<any>(system, step);
}

template <class S, int width>
template <int freedoms>
void LoopFactors<S, width>::eliminate_body(const System<S>& system, const BodyStep& step) {
  const int nv = freedoms == any ? step.nv : freedoms;
  ArticulatedInertia<S>& M = star_[step.body];
  if (step.untouched)
    M = expanded(system.bodies[step.body].inertia);
  else
    add(M, system.bodies[step.body].inertia);
  ArticulatedInertia<S> rest;
  rest = M;
  for (int k = step.v; k < step.v + nv; ++k) {
    const Wrench<S> U = times_column(rest, kind(k), system.columns[k]);
    S N = project(kind(k), system.columns[k], U);
    if (model_.has_armature()) N += S(model_.armature()[k]);
    freedoms_[k].inverse = S(1.0) / N;
    freedoms_[k].D = U * freedoms_[k].inverse;
    if (step.parent == ground && k + 1 == step.v + nv) break;  // what is left of it acts on nothing
    subtract_outer(rest, freedoms_[k].D, U);
  }
  if (step.parent != ground) {
    if (step.first_to_parent)
      star_[step.parent] = moved_inward(system.bodies[step.body].r, rest);
    else
      add(star_[step.parent], moved_inward(system.bodies[step.body].r, rest));
  }
  if (step.columns == 0) return;
  if (freedoms == 1 && kind(step.v) == ColumnKind::rotation && (width > 1 || step.terms.begin == step.terms.end))
    release_hinge(system, step);
  else
    release_columns(system, step);
  meet<freedoms>(step);
}

/// S += uᵀ N⁻¹ u.
template <class S, int width>
template <int freedoms>
void LoopFactors<S, width>::meet(const BodyStep& step) {
  const int nv = freedoms == any ? step.nv : freedoms, w = step.columns;
  for (const Meeting& both : step.meetings.of(plan_.meetings)) {
    const int rows = count<width>(both.first_strips) * width, strips = count<width>(both.second_strips);
    Rows* const block = delassus_.data() + both.block;
    if (both.first_there && nv == 0) std::fill_n(block, rows * strips, Rows(0.0));
    for (int k = 0; k < nv; ++k) {
      const Rows* const first = scratch_.data() + k * w + both.first;
      const Rows* const second = responses_.data() + step.responses + k * w + both.second;
      const bool fresh = both.first_there && k == 0;
      for (int x = 0; x < rows; ++x)
        for (int y = 0; y < strips; ++y) {
          const Rows product = second[y] * Rows(lane<width>(first[x / width], x % width));
          block[x * strips + y] = fresh ? product : block[x * strips + y] + product;
        }
    }
  }
}

template <class S, int width>
void LoopFactors<S, width>::hand_on(const Attachment& to, int strip, const Wrench<Rows>& e) {
  if (to.first)
    columns_[to.to + strip] = e;
  else
    columns_[to.to + strip] += e;
}

/// u, u / N, and what is left of the columns handed to the parent.
template <class S, int width>
void LoopFactors<S, width>::release_columns(const System<S>& system, const BodyStep& step) {
  const int w = step.columns;
  Rows* const u = scratch_.data();
  std::fill_n(u, step.nv * w, Rows(0.0));
  if constexpr (width == 1)  // else there are no couplers
    for (const DirectTerm& term : step.terms.of(plan_.terms)) u[term.freedom * w + term.column] += S(term.factor);
  for (const Attachment& a : step.attachments.of(plan_.attachments)) {
    for (int s = 0; s < count<width>(a.strips); ++s) {
      Wrench<Rows> e;
      e = columns_[step.first_column + a.column + s];
      for (int k = 0; k < step.nv; ++k) {
        const Freedom& freedom = freedoms_[step.v + k];
        const int here = k * w + a.column + s;
        const Rows along = u[here] += project(kind(step.v + k), in_every_lane<Rows>(system.columns[step.v + k]), e);
        responses_[step.responses + here] = along * Rows(freedom.inverse);
        if (a.to >= 0 || k + 1 < step.nv) e -= in_every_lane<Rows>(freedom.D) * along;
      }
      if (a.to >= 0) hand_on(a, s, moved_inward(in_every_lane<Rows>(system.bodies[step.body].r), e));
    }
  }
}

/// The same for one hinge without couplers: a tenth of the time of a ladder's factors.
template <class S, int width>
void LoopFactors<S, width>::release_hinge(const System<S>& system, const BodyStep& step) {
  const Freedom& freedom = freedoms_[step.v];
  const Wrench<Rows> D = in_every_lane<Rows>(freedom.D);
  const Rows inverse(freedom.inverse);
  const auto axis = in_every_lane<Rows>(system.columns[step.v].angular);
  const auto r = in_every_lane<Rows>(system.bodies[step.body].r);
  for (const Attachment& a : step.attachments.of(plan_.attachments)) {
    for (int s = 0; s < count<width>(a.strips); ++s) {
      const Wrench<Rows>& e = columns_[step.first_column + a.column + s];
      const Rows along = dot(axis, e.moment);
      scratch_[a.column + s] = along;
      responses_[step.responses + a.column + s] = along * inverse;
      if (a.to >= 0) hand_on(a, s, moved_inward(r, e - D * along));
    }
  }
}

/// W and D⁻¹ with W S_cc Wᵀ = D.
template <class S, int width>
bool LoopFactors<S, width>::find_pivots(const ClosureStep& step, std::span<const char> counts) {
  const int strips = count<width>(step.strips), m = strips * width, row = step.strip * width;
  Rows rest[most_rows][most_strips<width>], W[most_rows][most_strips<width>];
  Rows* const inverses = inverse_.data() + step.strip;
  bool left[most_rows];
  for (int r = 0; r < m; ++r) {
    left[r] = counts.empty() || counts[row + r];
    for (int s = 0; s < strips; ++s) rest[r][s] = delassus_[step.block + r * strips + s], W[r][s] = Rows(0.0);
    if constexpr (width == 1)
      W[r][r] = S(1.0);
    else  // set_lane() would write one lane to memory, and wait for it
      W[r][0] = W[r][0].with_lane(r, 1.0);
  }
  std::fill_n(inverses, strips, Rows(0.0));
  int found = 0, wanted = 0;
  for (int r = 0; r < m; ++r) wanted += left[r];
  for (; found < wanted; ++found) {
    int best = -1;
    double largest = counts.empty() ? vanishing_pivot : 0, unit = 1;  // the pivot of `best`, and what it is measured in
    for (int r = 0; r < m; ++r) {
      if (!left[r]) continue;
      const double pivot = to_double(lane<width>(rest[r][r / width], r % width));
      const double taken = to_double(lane<width>(taken_[step.strip + r / width], r % width));
      const double size = std::max(free_[row + r], pivot + taken);
      if (!(pivot >= -vanishing_pivot * size && pivot < 1e300)) return false;
      if (pivot * unit > largest * size) largest = pivot, unit = size, best = r;
    }
    if (best < 0) break;
    left[best] = false;
    const S inverse = S(1.0) / lane<width>(rest[best][best / width], best % width);
    set_lane<width>(inverses[best / width], best % width, inverse);
    for (int r = 0; r < m; ++r) {
      if (!left[r]) continue;
      const Rows factor(lane<width>(rest[r][best / width], best % width) * inverse);
      for (int s = 0; s < strips; ++s) rest[r][s] -= factor * rest[best][s], W[r][s] -= factor * W[best][s];
    }
  }
  Rows* const weights = weights_.data() + step.weights;
  Rows* const columns = weight_columns_.data() + step.weights;
  for (int r = 0; r < m; ++r)
    for (int s = 0; s < strips; ++s) weights[r * strips + s] = W[r][s];
  transpose_rows<width>(weights, columns, m);
  dropped_ += m - found;
  return counts.empty() || found == wanted;
}

template <class S, int width>
void LoopFactors<S, width>::eliminate_closure(const ClosureStep& step) {
  const int own = count<width>(step.strips), m = own * width;
  const Rows* const W = weights(step);
  const Rows* const inverses = inverse(step);
  const auto weight = [&](int r, int x) { return Rows(lane<width>(W[r * own + x / width], x % width)); };
  const auto one_over_pivot = [&](int r) { return Rows(lane<width>(inverses[r / width], r % width)); };
  for (const Attachment& a : step.attachments.of(plan_.attachments)) {
    const int strips = count<width>(a.strips);
    Rows* const T = delassus_.data() + a.block;
    for (int y = 0; y < strips; ++y) {
      Rows before[most_rows], taken(0.0);
      for (int x = 0; x < m; ++x) before[x] = T[x * strips + y];
      for (int r = 0; r < m; ++r) {
        Rows t = before[0] * weight(r, 0);
        for (int x = 1; x < m; ++x) t += before[x] * weight(r, x);
        T[r * strips + y] = t;
        taken += t * t * one_over_pivot(r);
      }
      taken_[a.strip + y] += taken;
    }
  }
  for (const Meeting& both : step.meetings.of(plan_.meetings)) {
    const int first_strips = count<width>(both.first_strips), strips = count<width>(both.second_strips);
    const Rows* const first = delassus_.data() + both.first;
    const Rows* const second = delassus_.data() + both.second;
    Rows* const block = delassus_.data() + both.block;
    for (int x = 0; x < first_strips * width; ++x)
      for (int y = 0; y < strips; ++y) {
        Rows rest = both.first_there ? Rows(0.0) : block[x * strips + y];
        for (int r = 0; r < m; ++r)
          rest -= Rows(lane<width>(first[r * first_strips + x / width], x % width)) * one_over_pivot(r) *
                  second[r * strips + y];
        block[x * strips + y] = rest;
      }
  }
  if (step.body >= 0) hand_to_body(step);
}

template <class S, int width>
void LoopFactors<S, width>::hand_to_body(const ClosureStep& step) {
  const int own = count<width>(step.strips), m = own * width;
  const Rows* const W = weight_columns(step);
  const Rows* const inverses = inverse(step);
  Wrench<Rows>* const E = columns_.data() + step.first_column;
  Wrench<S> before[most_rows];
  for (int x = 0; x < m; ++x) before[x] = lane<width>(E[x / width], x % width);
  for (int s = 0; s < own; ++s) {
    E[s] = in_every_lane<Rows>(before[0]) * W[s];
    for (int x = 1; x < m; ++x) E[s] += in_every_lane<Rows>(before[x]) * W[x * own + s];
  }
  if (step.first_to_body) star_[step.body] = expanded(RigidInertia<S>());
  Wrench<S> rows[most_rows];
  for (int r = 0; r < m; ++r) {
    rows[r] = lane<width>(E[r / width], r % width);
    subtract_outer(star_[step.body], rows[r] * -lane<width>(inverses[r / width], r % width), rows[r]);
  }
  for (const Attachment& a : step.attachments.of(plan_.attachments)) {
    const int strips = count<width>(a.strips);
    const Rows* const T = delassus_.data() + a.block;
    for (int y = 0; y < strips; ++y) {
      Wrench<Rows> e;
      if (a.first)
        e = in_every_lane<Rows>(Wrench<S>{});
      else
        e = columns_[a.to + y];
      for (int r = 0; r < m; ++r)
        e -= in_every_lane<Rows>(rows[r]) * (T[r * strips + y] * Rows(lane<width>(inverses[r / width], r % width)));
      columns_[a.to + y] = e;
    }
  }
}

template class LoopFactors<double, 1>;
template class LoopFactors<double, 3>;
template class LoopFactors<double, 6>;
template class LoopFactors<long double, 1>;
template class LoopFactors<Count, 1>;

}  // namespace lanc
