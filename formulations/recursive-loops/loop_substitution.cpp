#include "formulations/recursive-loops/loop_substitution.h"

#include <algorithm>

namespace lanc {

template <class S>
struct LoopSubstitution<S>::Task {
  const LoopFactors<S>& factors;
  const System<S>& system;
  const RightHandSide<S>& rhs;
  Solution<S>& solution;
};

template <class S>
LoopSubstitution<S>::LoopSubstitution(const Model& model)
    : load_(model.bodies()),
      start_(model.nv()),
      gamma_(model.closures().rows()),
      lambda_(model.closures().rows()),
      delta_(model.has_closures() ? model.bodies() : 0) {}

template <class S>
void LoopSubstitution<S>::solve(const LoopFactors<S>& factors, const System<S>& system, const RightHandSide<S>& rhs,
                                Solution<S>& solution) {
  const Task task{factors, system, rhs, solution};
  load_ = rhs.force;
  gamma_ = rhs.closure;
  sweep<Pass::first>(task);
  if (!factors.model().has_closures()) return;
  solution.lambda = lambda_;
  residual_of_closures(task);
  sweep<Pass::correction>(task);
  for (std::size_t k = 0; k < lambda_.size(); ++k) solution.lambda[k] += lambda_[k];
}

template <class S>
template <typename LoopSubstitution<S>::Pass pass>
void LoopSubstitution<S>::sweep(const Task& task) {
  const EliminationPlan& plan = task.factors.plan();
  for (const int at : plan.order) {
    if (at >= 0) {
      load_of<pass>(task, plan.bodies[at]);
      forward_body<pass>(task, plan.bodies[at]);
    } else {
      const ClosureStep& step = plan.closures[-1 - at];
      with_rows(step.rows_each, [&](auto rows) { forward_closure<rows>(task.factors, step); });
    }
  }
  const std::vector<Motion<S>>& a = pass == Pass::first ? task.solution.acceleration : delta_;
  for (auto at = plan.order.rbegin(); at != plan.order.rend(); ++at) {
    if (*at >= 0) {
      backward_body<pass>(task, plan.bodies[*at]);
    } else {
      const ClosureStep& step = plan.closures[-1 - *at];
      with_rows(step.rows_each, [&](auto rows) { backward_closure<rows>(task.factors, step, a); });
    }
  }
}

/// What is left open of the closure conditions, and of the balances of bodies what multipliers do; load_of() does the
/// rest of the residual on the way.
template <class S>
void LoopSubstitution<S>::residual_of_closures(const Task& task) {
  const Solution<S>& x = task.solution;
  load_ = task.rhs.force;
  gamma_ = task.rhs.closure;
  const ClosureSet& set = task.factors.model().closures();
  for (const Closure& c : set.closures)
    for (int k = c.row; k < c.row + c.conditions().count; ++k) {
      const auto& row = task.system.closure_rows[k];
      if (c.body_a != ground) gamma_[k] += dot(x.acceleration[c.body_a], row.a), load_[c.body_a] += row.a * x.lambda[k];
      if (c.body_b != ground) gamma_[k] += dot(x.acceleration[c.body_b], row.b), load_[c.body_b] += row.b * x.lambda[k];
    }
  for (const Coupler& c : set.couplers)
    for (const Coupler::Term& term : c.terms) gamma_[c.row] += S(term.factor) * x.vdot[term.v];
}

/// f* of the body: of the loads, or of the residual of its balance, from which its children have taken their wrenches
/// already, together with what they handed down.
template <class S>
template <typename LoopSubstitution<S>::Pass pass>
void LoopSubstitution<S>::load_of(const Task& task, const BodyStep& step) {
  const int i = step.body;
  if constexpr (pass == Pass::correction) {
    load_[i] += task.solution.wrench[i] - task.system.bodies[i].inertia * task.solution.acceleration[i];
    return;
  }
  const LoopFactors<S>& factors = task.factors;
  const Motion<S>& bias = task.rhs.bias[i];
  load_[i] -= factors.star(i) * bias;
  const Wrench<S>* const e = factors.columns(step.first_column);
  for (int at = step.attachments.begin; at < step.attachments.end; ++at) {
    const Attachment& a = factors.plan().attachments[at];
    for (int x = 0; x < a.rows; ++x) gamma_[a.row + x] += dot(bias, e[a.column + x]);
  }
}

template <class S>
template <typename LoopSubstitution<S>::Pass pass>
void LoopSubstitution<S>::forward_body(const Task& task, const BodyStep& step) {
  const LoopFactors<S>& factors = task.factors;
  const Model& model = factors.model();
  const EliminationPlan& plan = factors.plan();
  const Solution<S>& solution = task.solution;
  const int i = step.body;
  Wrench<S> rest = load_[i];
  for (int k = 0; k < step.nv; ++k) {
    const int v = step.v + k;
    const ColumnKind kind = model.column_kind(v);
    S torque = task.rhs.tau[v] + project(kind, task.system.columns[v], rest);
    if constexpr (pass == Pass::correction) {
      torque -= project(kind, task.system.columns[v], solution.wrench[i]);
      if (model.has_armature()) torque -= S(model.armature()[v]) * solution.vdot[v];
      for (int t = step.terms.begin; t < step.terms.end; ++t)
        if (plan.terms[t].freedom == k) torque += S(plan.terms[t].factor) * solution.lambda[plan.terms[t].row];
    }
    start_[v] = torque * factors.freedom(v).inverse;
    rest -= factors.freedom(v).D * torque;
    const S* const response = factors.responses(step, k);
    for (int at = step.attachments.begin; at < step.attachments.end; ++at) {
      const Attachment& a = plan.attachments[at];
      for (int x = 0; x < a.rows; ++x) gamma_[a.row + x] += response[a.column + x] * torque;
    }
  }
  if (step.parent == ground) return;
  if constexpr (pass == Pass::correction) rest -= solution.wrench[i];
  load_[step.parent] += moved_inward(task.system.bodies[i].r, rest);
}

template <class S>
template <typename LoopSubstitution<S>::Pass pass>
void LoopSubstitution<S>::backward_body(const Task& task, const BodyStep& step) {
  const LoopFactors<S>& factors = task.factors;
  const Model& model = factors.model();
  Solution<S>& solution = task.solution;
  const Range around = step.attachments;
  const Attachment* const attachments = factors.plan().attachments.data();
  const int i = step.body;
  Motion<S> a{};  // B_ip â_p + C η̇ of the columns done
  const bool at_rest = step.parent == ground;
  if (!at_rest)
    a = moved_outward(task.system.bodies[i].r,
                      pass == Pass::first ? solution.acceleration[step.parent] : delta_[step.parent]);
  for (int k = step.nv - 1; k >= 0; --k) {
    const int v = step.v + k;
    S vdot = start_[v];
    if (!at_rest || k != step.nv - 1) vdot -= dot(a, factors.freedom(v).D);
    const S* const response = factors.responses(step, k);
    for (int at = around.begin; at < around.end; ++at) {
      const Attachment& m = attachments[at];
      for (int x = 0; x < m.rows; ++x) vdot += response[m.column + x] * lambda_[m.row + x];
    }
    if constexpr (pass == Pass::first)
      solution.vdot[v] = vdot;
    else
      solution.vdot[v] += vdot;
    add_along(model.column_kind(v), task.system.columns[v], vdot, a);
  }
  Wrench<S> f = factors.star(i) * a - load_[i];
  const Wrench<S>* const e = factors.columns(step.first_column);
  for (int at = around.begin; at < around.end; ++at) {
    const Attachment& m = attachments[at];
    for (int x = 0; x < m.rows; ++x) f -= e[m.column + x] * lambda_[m.row + x];
  }
  if constexpr (pass == Pass::first) {
    solution.wrench[i] = f;
    solution.acceleration[i] = a + task.rhs.bias[i];
  } else {
    delta_[i] = a;
    solution.wrench[i] += f;
    solution.acceleration[i] += a;
  }
}

template <class S>
template <int fixed>
void LoopSubstitution<S>::forward_closure(const LoopFactors<S>& factors, const ClosureStep& step) {
  const int m = fixed ? fixed : step.rows;
  const S* const W = factors.weights(step);
  const S* const inverse = factors.inverse(step);
  S* const gamma = gamma_.data() + step.row;
  S g[6];
  for (int r = 0; r < m; ++r) {
    S sum = W[r * m] * gamma[0];
    for (int x = 1; x < m; ++x) sum += W[r * m + x] * gamma[x];
    g[r] = sum * inverse[r];
  }
  for (int at = step.attachments.begin; at < step.attachments.end; ++at) {
    const Attachment& a = factors.plan().attachments[at];
    const int columns = fixed ? fixed : a.rows;
    const S* const T = factors.block(a.block);
    for (int r = 0; r < m; ++r)
      for (int y = 0; y < columns; ++y) gamma_[a.row + y] -= T[r * columns + y] * g[r];
  }
  if (step.body >= 0)
    for (int r = 0; r < m; ++r) load_[step.body] -= factors.columns(step.first_column)[r] * g[r];
  for (int r = 0; r < m; ++r) gamma[r] = g[r];
}

/// `a`: â of the bodies that came back already, or its correction.
template <class S>
template <int fixed>
void LoopSubstitution<S>::backward_closure(const LoopFactors<S>& factors, const ClosureStep& step,
                                           const std::vector<Motion<S>>& a) {
  const int m = fixed ? fixed : step.rows;
  const S* const W = factors.weights(step);
  const S* const inverse = factors.inverse(step);
  S z[6];
  for (int r = 0; r < m; ++r) z[r] = step.body < 0 ? S(0.0) : dot(a[step.body], factors.columns(step.first_column)[r]);
  for (int at = step.attachments.begin; at < step.attachments.end; ++at) {
    const Attachment& d = factors.plan().attachments[at];
    const int columns = fixed ? fixed : d.rows;
    const S* const T = factors.block(d.block);
    for (int r = 0; r < m; ++r)
      for (int y = 0; y < columns; ++y) z[r] += T[r * columns + y] * lambda_[d.row + y];
  }
  for (int r = 0; r < m; ++r) z[r] = gamma_[step.row + r] + inverse[r] * z[r];
  for (int x = 0; x < m; ++x) {
    S sum = W[x] * z[0];
    for (int r = 1; r < m; ++r) sum += W[r * m + x] * z[r];
    lambda_[step.row + x] = -sum;
  }
}

template class LoopSubstitution<double>;
template class LoopSubstitution<long double>;
template class LoopSubstitution<Count>;

}  // namespace lanc
