#include "formulations/recursive-loops/recursive_loops.h"

#include <algorithm>
#include <cmath>

#include "formulations/recursive-loops/free_delassus.h"

namespace lanc {
namespace {

/// Pivots below this part of what the bodies alone would make of them are rounding errors: 1e-16 times what elimination
/// magnifies them by. States are assembled to 1e-12, which shows squared.
constexpr double vanishing_pivot = 1e-13;

/// block += u vᵀ.
template <class S, int rows, int columns>
inline void add_outer(S* block, int stride, const S* u, const S* v) {
  for (int r = 0; r < rows; ++r)
    for (int c = 0; c < columns; ++c) block[r * stride + c] += u[r] * v[c];
}

template <class S>
inline void add_outer(const Meeting& m, S* panel, const S* u, const S* v) {
  S* const block = panel + m.slot;
  u += m.first, v += m.second;
  if (m.rows == 3 && m.columns == 3) return add_outer<S, 3, 3>(block, m.stride, u, v);
  for (int r = 0; r < m.rows; ++r)
    for (int c = 0; c < m.columns; ++c) block[r * m.stride + c] += u[r] * v[c];
}

template <class S>
inline void subtract_outer(const Meeting& m, S* panel, const S* u, const S* v) {
  S* const block = panel + m.slot;
  u += m.first, v += m.second;
  for (int r = 0; r < m.rows; ++r)
    for (int c = 0; c < m.columns; ++c) block[r * m.stride + c] -= u[r] * v[c];
}

}  // namespace

template <class S>
RecursiveLoops<S>::RecursiveLoops(const Model& model)
    : Formulation<S>(model),
      plan_(model),
      free_(free_delassus_diagonal(model)),
      star_(model.bodies()),
      columns_(plan_.columns),
      freedoms_(model.nv()),
      responses_(plan_.responses),
      panel_(plan_.panel),
      inverse_(model.closures().rows()),
      taken_(model.closures().rows()),
      pivots_(model.closures().rows()),
      kept_(plan_.closures.size()),
      scratch_(plan_.scratch),
      load_(model.bodies()),
      gamma_(model.closures().rows()),
      lambda_(model.closures().rows()),
      delta_(model.has_closures() ? model.bodies() : 0) {}

template <class S>
Outcome RecursiveLoops<S>::factorise(const System<S>& system) {
  if (!this->model().has_closures()) {
    eliminate(system, {});
    return {};
  }
  const ClosureDecision& decision = this->closures();
  bool regular = eliminate(system, {});
  if (regular && dropped_ != decision.redundant) regular = eliminate(system, decision.independent);
  if (regular) return {};
  return {Status::objection,
          "the mass matrix of the tree that is left without its loops is singular or not positive definite, and this "
          "formulation divides by it; take one that does not, such as dense, nullspace or eq14-umfpack"};
}

template <class S>
bool RecursiveLoops<S>::eliminate(const System<S>& system, std::span<const char> counts) {
  for (std::size_t i = 0; i < star_.size(); ++i) star_[i] = expanded(system.bodies[i].inertia);
  const S o(0.0);
  std::fill(columns_.begin(), columns_.end(), Wrench<S>{{o, o, o}, {o, o, o}});
  for (std::size_t k = 0; k < plan_.column_of_end_a.size(); ++k) {
    if (const int at = plan_.column_of_end_a[k]; at >= 0) columns_[at] = system.closure_rows[k].a;
    if (const int at = plan_.column_of_end_b[k]; at >= 0) columns_[at] += system.closure_rows[k].b;
  }
  std::fill(panel_.begin(), panel_.end(), o);
  std::fill(taken_.begin(), taken_.end(), o);
  dropped_ = 0;
  for (const int step : plan_.order) {
    if (step >= 0)
      eliminate_body(system, plan_.bodies[step]);
    else if (!eliminate_closure(plan_.closures[-1 - step], counts))
      return false;
  }
  return true;
}

template <class S>
void RecursiveLoops<S>::eliminate_body(const System<S>& system, const BodyStep& step) {
  const Model& model = this->model();
  ArticulatedInertia<S> rest = star_[step.body];
  for (int k = step.v; k < step.v + step.nv; ++k) {
    const ColumnKind kind = model.column_kind(k);
    const Wrench<S> U = times_column(rest, kind, system.columns[k]);
    S N = project(kind, system.columns[k], U);
    if (model.has_armature()) N += S(model.armature()[k]);
    freedoms_[k].inverse = S(1.0) / N;
    freedoms_[k].D = U * freedoms_[k].inverse;
    lanc::subtract_outer(rest, freedoms_[k].D, U);
  }
  const Vec3<S>& r = system.bodies[step.body].r;
  if (step.parent != ground) add(star_[step.parent], moved_inward(r, rest));

  const int w = step.columns;
  const bool direct = step.terms.begin < step.terms.end;
  if (direct) std::fill_n(scratch_.begin(), step.nv * w, S(0.0));
  for (int t = step.terms.begin; t < step.terms.end; ++t)
    scratch_[plan_.terms[t].freedom * w + plan_.terms[t].column] += S(plan_.terms[t].factor);
  for (int at = step.attachments.begin; at < step.attachments.end; ++at) {
    const Attachment& a = plan_.attachments[at];
    for (int x = a.column; x < a.column + a.rows; ++x) {
      Wrench<S> e = columns_[step.first_column + x];
      for (int k = 0; k < step.nv; ++k) {
        const Freedom& freedom = freedoms_[step.v + k];
        S u = project(model.column_kind(step.v + k), system.columns[step.v + k], e);
        if (direct) u += scratch_[k * w + x];
        e -= freedom.D * u;
        scratch_[k * w + x] = u;
        responses_[step.responses + k * w + x] = u * freedom.inverse;
      }
      if (a.to >= 0) columns_[a.to + x - a.column] += moved_inward(r, e);
    }
  }
  for (int m = step.meetings.begin; m < step.meetings.end; ++m)
    for (int k = 0; k < step.nv; ++k)
      add_outer(plan_.meetings[m], panel_.data(), scratch_.data() + k * w, responses_.data() + step.responses + k * w);
}

template <class S>
bool RecursiveLoops<S>::eliminate_closure(const ClosureStep& step, std::span<const char> counts) {
  const auto diagonal = [&](int r) { return to_double(panel_[step.panel + r * step.stride + r]); };
  int* const pivots = pivots_.data() + step.row;
  int left = 0;
  for (int r = 0; r < step.rows; ++r)
    if (counts.empty() || counts[step.row + r]) pivots[left++] = r;
  dropped_ += step.rows - left;
  int done = 0;
  for (; done < left; ++done) {
    int best = done;
    double largest = 0;
    for (int at = done; at < left; ++at) {
      const int r = pivots[at];
      const double size = std::max(free_[step.row + r], diagonal(r) + to_double(taken_[step.row + r]));
      const double part = diagonal(r) / size;
      if (!(part >= -vanishing_pivot && part < 1e300)) return false;
      if (part > largest) largest = part, best = at;
    }
    if (counts.empty() && largest <= vanishing_pivot) break;
    if (largest <= 0) return false;
    std::swap(pivots[done], pivots[best]);
    // rows of dropped or uncounted ones among the columns are not used
    release_row(step, done, left);
  }
  kept_[&step - plan_.closures.data()] = done;
  dropped_ += left - done;
  return true;
}

/// Takes the pivot of `done` out of the closure's `left` rows, of what it meets, and of the body that is left.
template <class S>
void RecursiveLoops<S>::release_row(const ClosureStep& step, int done, int left) {
  const int* const pivots = pivots_.data() + step.row;
  const int r = pivots[done];
  S* const panel = panel_.data() + step.panel;
  S* const row = panel + r * step.stride;
  const S inverse = S(1.0) / row[r];
  inverse_[step.row + r] = inverse;
  S* const before = scratch_.data();
  for (int x = 0; x < step.stride; ++x) before[x] = row[x], row[x] = row[x] * inverse;
  const bool alone = step.body < 0;
  const Wrench<S> e = alone ? Wrench<S>{} : columns_[step.first_column + r];
  for (int at = done + 1; at < left; ++at) {
    const int x = pivots[at];
    for (int y = 0; y < step.stride; ++y) panel[x * step.stride + y] -= before[x] * row[y];
    if (!alone) columns_[step.first_column + x] -= e * row[x];
  }
  for (int at = step.attachments.begin; at < step.attachments.end; ++at) {
    const Attachment& a = plan_.attachments[at];
    for (int x = 0; x < a.rows; ++x) {
      taken_[a.row + x] += before[a.column + x] * row[a.column + x];
      if (!alone) columns_[a.to + x] -= e * row[a.column + x];
    }
  }
  for (int m = step.meetings.begin; m < step.meetings.end; ++m)
    subtract_outer(plan_.meetings[m], panel_.data(), before, row);
  if (!alone) lanc::subtract_outer(star_[step.body], e * -inverse, e);
}

template <class S>
void RecursiveLoops<S>::substitute(const System<S>& system, const RightHandSide<S>& rhs, Solution<S>& solution) {
  const S o(0.0);
  std::fill(load_.begin(), load_.end(), Wrench<S>{{o, o, o}, {o, o, o}});
  gamma_ = rhs.closure;
  sweep<Pass::first>(system, rhs, solution);
  if (!this->model().has_closures()) return;
  solution.lambda = lambda_;
  residual(system, rhs, solution);
  sweep<Pass::correction>(system, rhs, solution);
  for (std::size_t k = 0; k < lambda_.size(); ++k) solution.lambda[k] += lambda_[k];
}

template <class S>
template <typename RecursiveLoops<S>::Pass pass>
void RecursiveLoops<S>::sweep(const System<S>& system, const RightHandSide<S>& rhs, Solution<S>& solution) {
  for (const int step : plan_.order) {
    if (step >= 0)
      forward_body<pass>(system, rhs, solution, plan_.bodies[step]);
    else
      forward_closure(plan_.closures[-1 - step]);
  }
  for (auto step = plan_.order.rbegin(); step != plan_.order.rend(); ++step) {
    if (*step >= 0)
      backward_body<pass>(system, rhs, solution, plan_.bodies[*step]);
    else
      backward_closure<pass>(solution, plan_.closures[-1 - *step]);
  }
}

/// The residual of the closure rows, and of the balances of bodies what multipliers do; forward_body does the rest.
template <class S>
void RecursiveLoops<S>::residual(const System<S>& system, const RightHandSide<S>& rhs, const Solution<S>& solution) {
  const S o(0.0);
  std::fill(load_.begin(), load_.end(), Wrench<S>{{o, o, o}, {o, o, o}});
  const ClosureSet& set = this->model().closures();
  for (const Closure& c : set.closures)
    for (int k = c.row; k < c.row + c.conditions().count; ++k) {
      S open = rhs.closure[k];
      for (const auto& [body, row] :
           {std::pair{c.body_a, &system.closure_rows[k].a}, std::pair{c.body_b, &system.closure_rows[k].b}})
        if (body != ground) {
          open += dot(solution.acceleration[body], *row);
          load_[body] += *row * solution.lambda[k];
        }
      gamma_[k] = open;
    }
  for (const Coupler& c : set.couplers) {
    S open = rhs.closure[c.row];
    for (const Coupler::Term& term : c.terms) open += S(term.factor) * solution.vdot[term.v];
    gamma_[c.row] = open;
  }
}

/// Load half of a body's step. In the correction the load is the residual of its balance; children have taken their
/// wrenches off it already, together with what they hand down.
template <class S>
template <typename RecursiveLoops<S>::Pass pass>
void RecursiveLoops<S>::forward_body(const System<S>& system, const RightHandSide<S>& rhs, const Solution<S>& solution,
                                     const BodyStep& step) {
  const Model& model = this->model();
  const int i = step.body, w = step.columns;
  const bool direct = step.terms.begin < step.terms.end;
  Wrench<S>& f = load_[i];
  f += rhs.force[i];
  if constexpr (pass == Pass::first) {
    f -= star_[i] * rhs.bias[i];
    for (int at = step.attachments.begin; at < step.attachments.end; ++at) {
      const Attachment& a = plan_.attachments[at];
      for (int x = 0; x < a.rows; ++x)
        gamma_[a.row + x] += dot(rhs.bias[i], columns_[step.first_column + a.column + x]);
    }
  } else {
    f += solution.wrench[i] - system.bodies[i].inertia * solution.acceleration[i];
  }
  if (step.parent == ground && step.nv == 0) return;
  Wrench<S> rest = f;
  for (int k = step.v; k < step.v + step.nv; ++k) {
    S torque = rhs.tau[k];
    if constexpr (pass == Pass::correction) {
      torque -= project(model.column_kind(k), system.columns[k], solution.wrench[i]);
      if (model.has_armature()) torque -= S(model.armature()[k]) * solution.vdot[k];
    }
    if constexpr (pass == Pass::correction)
      if (direct)
        for (int t = step.terms.begin; t < step.terms.end; ++t)
          if (plan_.terms[t].freedom == k - step.v)
            torque += S(plan_.terms[t].factor) * solution.lambda[plan_.terms[t].row];
    torque += project(model.column_kind(k), system.columns[k], rest);
    freedoms_[k].start = torque * freedoms_[k].inverse;
    rest -= freedoms_[k].D * torque;
    const S* const response = responses_.data() + step.responses + (k - step.v) * w;
    for (int at = step.attachments.begin; at < step.attachments.end; ++at) {
      const Attachment& a = plan_.attachments[at];
      for (int x = 0; x < a.rows; ++x) gamma_[a.row + x] += response[a.column + x] * torque;
    }
  }
  if (step.parent == ground) return;
  if constexpr (pass == Pass::correction) rest -= solution.wrench[i];
  load_[step.parent] += moved_inward(system.bodies[i].r, rest);
}

template <class S>
void RecursiveLoops<S>::forward_closure(const ClosureStep& step) {
  const int* const pivots = pivots_.data() + step.row;
  const int kept = kept_[&step - plan_.closures.data()];
  for (int done = 0; done < kept; ++done) {
    const int r = pivots[done];
    const S* const row = panel_.data() + step.panel + r * step.stride;
    const S gamma = gamma_[step.row + r];
    for (int at = done + 1; at < kept; ++at) gamma_[step.row + pivots[at]] -= row[pivots[at]] * gamma;
    for (int at = step.attachments.begin; at < step.attachments.end; ++at) {
      const Attachment& a = plan_.attachments[at];
      for (int x = 0; x < a.rows; ++x) gamma_[a.row + x] -= row[a.column + x] * gamma;
    }
    const S start = gamma_[step.row + r] = gamma * inverse_[step.row + r];
    if (step.body >= 0) load_[step.body] -= columns_[step.first_column + r] * start;
  }
}

template <class S>
template <typename RecursiveLoops<S>::Pass pass>
void RecursiveLoops<S>::backward_body(const System<S>& system, const RightHandSide<S>& rhs, Solution<S>& solution,
                                      const BodyStep& step) {
  const Model& model = this->model();
  const int i = step.body, w = step.columns;
  Motion<S> a{};  // B_ip â_p + C η̇ of the columns done
  const bool at_rest = step.parent == ground;
  if (!at_rest)
    a = moved_outward(system.bodies[i].r,
                      pass == Pass::first ? solution.acceleration[step.parent] : delta_[step.parent]);
  for (int k = step.v + step.nv - 1; k >= step.v; --k) {
    S vdot = freedoms_[k].start;
    if (!at_rest || k != step.v + step.nv - 1) vdot -= dot(a, freedoms_[k].D);
    const S* const response = responses_.data() + step.responses + (k - step.v) * w;
    for (int at = step.attachments.begin; at < step.attachments.end; ++at) {
      const Attachment& m = plan_.attachments[at];
      for (int x = 0; x < m.rows; ++x) vdot += response[m.column + x] * lambda_[m.row + x];
    }
    if constexpr (pass == Pass::first)
      solution.vdot[k] = vdot;
    else
      solution.vdot[k] += vdot;
    add_along(model.column_kind(k), system.columns[k], vdot, a);
  }
  Wrench<S> f = star_[i] * a - load_[i];
  for (int at = step.attachments.begin; at < step.attachments.end; ++at) {
    const Attachment& m = plan_.attachments[at];
    for (int x = 0; x < m.rows; ++x) f -= columns_[step.first_column + m.column + x] * lambda_[m.row + x];
  }
  if constexpr (pass == Pass::first) {
    solution.wrench[i] = f;
    solution.acceleration[i] = a + rhs.bias[i];
  } else {
    delta_[i] = a;
    solution.wrench[i] += f;
    solution.acceleration[i] += a;
  }
}

template <class S>
template <typename RecursiveLoops<S>::Pass pass>
void RecursiveLoops<S>::backward_closure(const Solution<S>& solution, const ClosureStep& step) {
  const int* const pivots = pivots_.data() + step.row;
  const int kept = kept_[&step - plan_.closures.data()];
  for (int r = 0; r < step.rows; ++r) lambda_[step.row + r] = S(0.0);
  for (int done = kept - 1; done >= 0; --done) {
    const int r = pivots[done];
    const S* const row = panel_.data() + step.panel + r * step.stride;
    S lambda = -gamma_[step.row + r];
    if (step.body >= 0) {
      const Motion<S>& a = pass == Pass::first ? solution.acceleration[step.body] : delta_[step.body];
      lambda -= dot(a, columns_[step.first_column + r]) * inverse_[step.row + r];
    }
    for (int at = done + 1; at < kept; ++at) lambda -= row[pivots[at]] * lambda_[step.row + pivots[at]];
    for (int at = step.attachments.begin; at < step.attachments.end; ++at) {
      const Attachment& a = plan_.attachments[at];
      for (int x = 0; x < a.rows; ++x) lambda -= row[a.column + x] * lambda_[a.row + x];
    }
    lambda_[step.row + r] = lambda;
  }
}

template class RecursiveLoops<double>;
template class RecursiveLoops<long double>;
template class RecursiveLoops<Count>;

namespace {
const Registration registration(
    {.name = "recursive-loops",
     .idea = "eq. 18 with closures: block elimination on the graph of bodies and closures, closed loops in linear time",
     .source = "lecture, eq. 18; Featherstone 1983; the path rule and the dropping of rows are this project's",
     .recursive = true,
     .create_double = create<RecursiveLoops<double>, double>,
     .create_long_double = create<RecursiveLoops<long double>, long double>,
     .create_count = create<RecursiveLoops<Count>, Count>});
}  // namespace

}  // namespace lanc
