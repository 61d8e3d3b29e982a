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
  if (!factors.model().has_closures()) return sweep<Pass::only>(task);
  sweep<Pass::first>(task);
  solution.lambda = lambda_;
  residual_of_closures(task);
  sweep<Pass::correction>(task);
  for (std::size_t k = 0; k < lambda_.size(); ++k) solution.lambda[k] += lambda_[k];
}

template <class S>
template <typename LoopSubstitution<S>::Pass pass>
void LoopSubstitution<S>::sweep(const Task& task) {
  with_rows(task.factors.plan().rows_each, [&](auto rows) {
    constexpr int fixed = pass == Pass::only ? 0 : rows;
    forward<pass, fixed>(task);
    backward<pass, fixed>(task);
  });
}

template <class S>
template <typename LoopSubstitution<S>::Pass pass, int fixed>
void LoopSubstitution<S>::forward(const Task& task) {
  const EliminationPlan& plan = task.factors.plan();
  for (const int at : plan.order) {
    if (at >= 0)
      forward_body<pass, fixed>(task, plan.bodies[at]);
    else
      forward_closure<fixed>(task.factors, plan.closures[-1 - at]);
  }
}

template <class S>
template <typename LoopSubstitution<S>::Pass pass, int fixed>
void LoopSubstitution<S>::backward(const Task& task) {
  const EliminationPlan& plan = task.factors.plan();
  const std::vector<Motion<S>>& a = pass == Pass::correction ? delta_ : task.solution.acceleration;
  for (auto at = plan.order.rbegin(); at != plan.order.rend(); ++at) {
    if (*at >= 0)
      backward_body<pass, fixed>(task, plan.bodies[*at]);
    else
      backward_closure<fixed>(task.factors, plan.closures[-1 - *at], a);
  }
}

/// What is left open of the closure conditions, and of the balances of bodies what multipliers do to them: the rest of
/// these is backward_body()'s.
template <class S>
void LoopSubstitution<S>::residual_of_closures(const Task& task) {
  const Solution<S>& x = task.solution;
  gamma_ = task.rhs.closure;
  for (const ClosureEnds& ends : task.factors.plan().ends)
    for (int k = ends.row; k < ends.row + ends.rows; ++k) {
      const auto& row = task.system.closure_rows[k];
      if (ends.body_a != ground)
        gamma_[k] += dot(x.acceleration[ends.body_a], row.a), load_[ends.body_a] += row.a * x.lambda[k];
      if (ends.body_b != ground)
        gamma_[k] += dot(x.acceleration[ends.body_b], row.b), load_[ends.body_b] += row.b * x.lambda[k];
    }
  for (const Coupler& c : task.factors.model().closures().couplers)
    for (const Coupler::Term& term : c.terms) gamma_[c.row] += S(term.factor) * x.vdot[term.v];
}

template <class S>
template <typename LoopSubstitution<S>::Pass pass, int fixed>
void LoopSubstitution<S>::forward_body(const Task& task, const BodyStep& step) {
  const LoopFactors<S>& factors = task.factors;
  const EliminationPlan& plan = factors.plan();
  const Attachment* const attachments = plan.attachments.data();
  const Range around = step.attachments;
  const int i = step.body;
  Wrench<S> rest;
  rest = load_[i];
  if constexpr (pass != Pass::correction) {
    const Motion<S>& bias = task.rhs.bias[i];
    rest -= factors.star(i) * bias;
    load_[i] = rest;
    const Wrench<S>* const e = factors.columns(step.first_column);
    for (int at = around.begin; at < around.end; ++at) {
      const Attachment& a = attachments[at];
      for (int x = 0; x < (fixed ? fixed : a.rows); ++x) gamma_[a.row + x] += dot(bias, e[a.column + x]);
    }
  }
  if (step.parent == ground && step.nv == 0) return;
  S* const gamma = gamma_.data();
  for (int k = 0; k < step.nv; ++k) {
    const int v = step.v + k;
    S torque = task.rhs.tau[v] + project(factors.kind(v), task.system.columns[v], rest);
    if constexpr (pass == Pass::correction) {
      if (factors.model().has_armature()) torque -= S(factors.model().armature()[v]) * task.solution.vdot[v];
      for (int t = step.terms.begin; t < step.terms.end; ++t)
        if (plan.terms[t].freedom == k) torque += S(plan.terms[t].factor) * task.solution.lambda[plan.terms[t].row];
    }
    start_[v] = torque * factors.freedom(v).inverse;
    if (step.parent != ground || k + 1 < step.nv) rest -= factors.freedom(v).D * torque;
    const S* const response = factors.responses(step, k);
    for (int at = around.begin; at < around.end; ++at) {
      const Attachment& a = attachments[at];
      for (int x = 0; x < (fixed ? fixed : a.rows); ++x) gamma[a.row + x] += response[a.column + x] * torque;
    }
  }
  if (step.parent != ground) load_[step.parent] += moved_inward(task.system.bodies[i].r, rest);
}

template <class S>
template <typename LoopSubstitution<S>::Pass pass, int fixed>
void LoopSubstitution<S>::backward_body(const Task& task, const BodyStep& step) {
  const LoopFactors<S>& factors = task.factors;
  Solution<S>& solution = task.solution;
  const Range around = step.attachments;
  const Attachment* const attachments = factors.plan().attachments.data();
  const int i = step.body;
  Motion<S> a{};  // B_ip â_p + C η̇ of the columns done
  const bool at_rest = step.parent == ground;
  if (!at_rest)
    a = moved_outward(task.system.bodies[i].r,
                      pass == Pass::correction ? delta_[step.parent] : solution.acceleration[step.parent]);
  for (int k = step.nv - 1; k >= 0; --k) {
    const int v = step.v + k;
    S vdot = start_[v];
    if (!at_rest || k != step.nv - 1) vdot -= dot(a, factors.freedom(v).D);
    const S* const response = factors.responses(step, k);
    for (int at = around.begin; at < around.end; ++at) {
      const Attachment& m = attachments[at];
      for (int x = 0; x < (fixed ? fixed : m.rows); ++x) vdot += response[m.column + x] * lambda_[m.row + x];
    }
    if constexpr (pass == Pass::correction)
      solution.vdot[v] += vdot;
    else
      solution.vdot[v] = vdot;
    add_along(factors.kind(v), task.system.columns[v], vdot, a);
  }
  if constexpr (pass == Pass::correction) {
    delta_[i] = a;
    solution.acceleration[i] += a;
  } else {
    const Motion<S> whole = a + task.rhs.bias[i];
    solution.acceleration[i] = whole;
    if constexpr (pass == Pass::first) {  // for the residual
      load_[i] = task.rhs.force[i] - task.system.bodies[i].inertia * whole;
      return;
    }
  }
  Wrench<S> f = factors.star(i) * a - load_[i];
  const Wrench<S>* const e = factors.columns(step.first_column);
  for (int at = around.begin; at < around.end; ++at) {
    const Attachment& m = attachments[at];
    for (int x = 0; x < (fixed ? fixed : m.rows); ++x) f -= e[m.column + x] * lambda_[m.row + x];
  }
  solution.wrench[i] = f;
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
    for (int y = 0; y < columns; ++y) {
      S sum = gamma_[a.row + y];
      for (int r = 0; r < m; ++r) sum -= T[r * columns + y] * g[r];
      gamma_[a.row + y] = sum;
    }
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
