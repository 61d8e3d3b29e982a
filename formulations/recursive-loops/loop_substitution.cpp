#include "formulations/recursive-loops/loop_substitution.h"

#include <algorithm>

namespace lanc {

template <class S, int width>
struct LoopSubstitution<S, width>::Task {
  const LoopFactors<S, width>& factors;
  const System<S>& system;
  const RightHandSide<S>& rhs;
  Solution<S>& solution;
};

namespace {

/// Numbers of rows as strips.
template <int width, class S, class Rows>
void load_rows(const std::vector<S>& rows, std::vector<Rows>& strips) {
  for (std::size_t s = 0; s < strips.size(); ++s) {
    Rows strip(0.0);
    for (int k = 0; k < width; ++k) set_lane<width>(strip, k, rows[s * width + k]);
    strips[s] = strip;
  }
}

}  // namespace

template <class S, int width>
LoopSubstitution<S, width>::LoopSubstitution(const Model& model)
    : load_(model.bodies()),
      start_(model.nv()),
      gamma_(model.closures().rows() / width),
      lambda_(model.closures().rows() / width),
      delta_(model.has_closures() ? model.bodies() : 0) {}

template <class S, int width>
void LoopSubstitution<S, width>::solve(const LoopFactors<S, width>& factors, const System<S>& system,
                                       const RightHandSide<S>& rhs, Solution<S>& solution) {
  const Task task{factors, system, rhs, solution};
  load_ = rhs.force;
  if (!factors.model().has_closures()) return forward(task, Pass::only), backward(task, Pass::only);
  load_rows<width>(rhs.closure, gamma_);
  forward(task, Pass::first);
  backward(task, Pass::first);
  for (std::size_t s = 0; s < lambda_.size(); ++s)
    for (int k = 0; k < width; ++k) solution.lambda[s * width + k] = lane<width>(lambda_[s], k);
  residual_of_closures(task);
  forward(task, Pass::correction);
  backward(task, Pass::correction);
  for (std::size_t s = 0; s < lambda_.size(); ++s)
    for (int k = 0; k < width; ++k) solution.lambda[s * width + k] += lane<width>(lambda_[s], k);
}

template <class S, int width>
void LoopSubstitution<S, width>::forward(const Task& task, Pass pass) {
  const EliminationPlan& plan = task.factors.plan();
  for (const int at : plan.order) {
    if (at >= 0)
      forward_body(task, plan.bodies[at], pass);
    else
      forward_closure(task.factors, plan.closures[-1 - at]);
  }
}

template <class S, int width>
void LoopSubstitution<S, width>::backward(const Task& task, Pass pass) {
  const EliminationPlan& plan = task.factors.plan();
  const std::vector<Motion<S>>& a = pass == Pass::correction ? delta_ : task.solution.acceleration;
  for (auto at = plan.order.rbegin(); at != plan.order.rend(); ++at) {
    if (*at >= 0)
      backward_body(task, plan.bodies[*at], pass);
    else
      backward_closure(task.factors, plan.closures[-1 - *at], a);
  }
}

/// What is left open of the closure conditions, and of the balances of bodies what multipliers do to them: the rest of
/// these is backward_body()'s.
template <class S, int width>
void LoopSubstitution<S, width>::residual_of_closures(const Task& task) {
  const Solution<S>& x = task.solution;
  const std::vector<S>& given = task.rhs.closure;
  for (const ClosureEnds& ends : task.factors.plan().ends)
    for (int s = ends.strip; s < ends.strip + count<width>(ends.strips); ++s) {
      Rows open(0.0);
      for (int i = 0; i < width; ++i) {
        const int k = s * width + i;
        const auto& row = task.system.closure_rows[k];
        S sum = given[k];
        if (ends.body_a != ground)
          sum += dot(x.acceleration[ends.body_a], row.a), load_[ends.body_a] += row.a * x.lambda[k];
        if (ends.body_b != ground)
          sum += dot(x.acceleration[ends.body_b], row.b), load_[ends.body_b] += row.b * x.lambda[k];
        set_lane<width>(open, i, sum);
      }
      gamma_[s] = open;
    }
  if constexpr (width == 1)  // else there are no couplers
    for (const Coupler& c : task.factors.model().closures().couplers) {
      gamma_[c.row] = given[c.row];
      for (const Coupler::Term& term : c.terms) gamma_[c.row] += S(term.factor) * x.vdot[term.v];
    }
}

template <class S, int width>
void LoopSubstitution<S, width>::forward_body(const Task& task, const BodyStep& step, Pass pass) {
  const LoopFactors<S, width>& factors = task.factors;
  const EliminationPlan& plan = factors.plan();
  const Attachment* const attachments = plan.attachments.data();
  const Range around = step.attachments;
  const int i = step.body;
  Wrench<S> rest;
  rest = load_[i];
  if (pass != Pass::correction) {
    const Motion<S>& bias = task.rhs.bias[i];
    rest -= factors.star(i) * bias;  // the product does not wait for what children hand on
    load_[i] = rest;
    const Wrench<Rows>* const e = factors.columns(step.first_column);
    for (int at = around.begin; at < around.end; ++at) {
      const Attachment& a = attachments[at];
      for (int s = 0; s < count<width>(a.strips); ++s)
        gamma_[a.strip + s] += dot(in_every_lane<Rows>(bias), e[a.column + s]);
    }
  }
  if (step.parent == ground && step.nv == 0) return;
  const auto release = [&](int k) __attribute__((always_inline)) {
    const int v = step.v + k;
    S torque = task.rhs.tau[v] + project(factors.kind(v), task.system.columns[v], rest);
    if (pass == Pass::correction) {
      if (factors.model().has_armature()) torque -= S(factors.model().armature()[v]) * task.solution.vdot[v];
      for (int t = step.terms.begin; t < step.terms.end; ++t)
        if (plan.terms[t].freedom == k) torque += S(plan.terms[t].factor) * task.solution.lambda[plan.terms[t].row];
    }
    start_[v] = torque * factors.freedom(v).inverse;
    if (step.parent != ground || k + 1 < step.nv) rest -= factors.freedom(v).D * torque;
    const Rows* const response = factors.responses(step, k);
    for (int at = around.begin; at < around.end; ++at) {
      const Attachment& a = attachments[at];
      for (int s = 0; s < count<width>(a.strips); ++s) gamma_[a.strip + s] += response[a.column + s] * Rows(torque);
    }
  };
  for_each_freedom(step.nv, release);
  if (step.parent != ground) load_[step.parent] += moved_inward(task.system.bodies[i].r, rest);
}

template <class S, int width>
void LoopSubstitution<S, width>::backward_body(const Task& task, const BodyStep& step, Pass pass) {
  const LoopFactors<S, width>& factors = task.factors;
  Solution<S>& solution = task.solution;
  const Range around = step.attachments;
  const Attachment* const attachments = factors.plan().attachments.data();
  const int i = step.body;
  Motion<S> a{};  // B_ip â_p + C η̇ of the columns done
  const bool at_rest = step.parent == ground;
  if (!at_rest)
    a = moved_outward(task.system.bodies[i].r,
                      pass == Pass::correction ? delta_[step.parent] : solution.acceleration[step.parent]);
  const auto move = [&](int freedom) __attribute__((always_inline)) {
    const int k = step.nv - 1 - freedom, v = step.v + k;
    S vdot = start_[v];
    if (!at_rest || k != step.nv - 1) vdot -= dot(a, factors.freedom(v).D);
    const Rows* const response = factors.responses(step, k);
    for (int at = around.begin; at < around.end; ++at) {
      const Attachment& m = attachments[at];
      for (int s = 0; s < count<width>(m.strips); ++s)
        vdot += sum_of_lanes<width>(response[m.column + s] * lambda_[m.strip + s]);
    }
    if (pass == Pass::correction)
      solution.vdot[v] += vdot;
    else
      solution.vdot[v] = vdot;
    add_along(factors.kind(v), task.system.columns[v], vdot, a);
  };
  for_each_freedom(step.nv, move);
  if (pass == Pass::correction) {
    delta_[i] = a;
    solution.acceleration[i] += a;
  } else {
    const Motion<S> whole = a + task.rhs.bias[i];
    solution.acceleration[i] = whole;
    if (pass == Pass::first) {  // for the residual
      load_[i] = plus_product(task.rhs.force[i], task.system.bodies[i].inertia, -whole);
      return;
    }
  }
  Wrench<S> f = plus_product(-load_[i], factors.star(i), a);
  const Wrench<Rows>* const e = factors.columns(step.first_column);
  for (int at = around.begin; at < around.end; ++at) {
    const Attachment& m = attachments[at];
    for (int s = 0; s < count<width>(m.strips); ++s) f -= sum_of_lanes<width>(e[m.column + s] * lambda_[m.strip + s]);
  }
  solution.wrench[i] = f;
}

template <class S, int width>
void LoopSubstitution<S, width>::forward_closure(const LoopFactors<S, width>& factors, const ClosureStep& step) {
  const int own = count<width>(step.strips), m = own * width;
  const Rows* const W = factors.weight_columns(step);
  const Rows* const inverse = factors.inverse(step);
  Rows* const gamma = gamma_.data() + step.strip;
  Rows g[most_strips<width>];
  for (int s = 0; s < own; ++s) {
    Rows sum = W[s] * Rows(lane<width>(gamma[0], 0));
    for (int x = 1; x < m; ++x) sum += W[x * own + s] * Rows(lane<width>(gamma[x / width], x % width));
    g[s] = sum * inverse[s];
  }
  for (int at = step.attachments.begin; at < step.attachments.end; ++at) {
    const Attachment& a = factors.plan().attachments[at];
    const int strips = count<width>(a.strips);
    const Rows* const T = factors.block(a.block);
    for (int y = 0; y < strips; ++y) {
      Rows sum = gamma_[a.strip + y];
      for (int r = 0; r < m; ++r) sum -= T[r * strips + y] * Rows(lane<width>(g[r / width], r % width));
      gamma_[a.strip + y] = sum;
    }
  }
  for (int s = 0; s < own; ++s) {
    if (step.body >= 0) load_[step.body] -= sum_of_lanes<width>(factors.columns(step.first_column)[s] * g[s]);
    gamma[s] = g[s];
  }
}

/// `a`: â of the bodies that came back already, or its correction.
template <class S, int width>
void LoopSubstitution<S, width>::backward_closure(const LoopFactors<S, width>& factors, const ClosureStep& step,
                                                  const std::vector<Motion<S>>& a) {
  const int own = count<width>(step.strips), m = own * width;
  const Rows* const W = factors.weights(step);
  const Rows* const inverse = factors.inverse(step);
  Rows z[most_strips<width>];
  for (int s = 0; s < own; ++s)
    z[s] = step.body < 0 ? Rows(0.0) : dot(in_every_lane<Rows>(a[step.body]), factors.columns(step.first_column)[s]);
  for (int at = step.attachments.begin; at < step.attachments.end; ++at) {
    const Attachment& d = factors.plan().attachments[at];
    const int strips = count<width>(d.strips);
    const Rows* const T = factors.block(d.block);
    for (int s = 0; s < own; ++s) {
      Rows through(0.0);
      for (int k = 0; k < width; ++k) {
        S sum(0.0);
        for (int y = 0; y < strips; ++y)
          sum += sum_of_lanes<width>(T[(s * width + k) * strips + y] * lambda_[d.strip + y]);
        set_lane<width>(through, k, sum);
      }
      z[s] += through;
    }
  }
  for (int s = 0; s < own; ++s) z[s] = gamma_[step.strip + s] + inverse[s] * z[s];
  for (int s = 0; s < own; ++s) {
    Rows sum = W[s] * Rows(lane<width>(z[0], 0));
    for (int r = 1; r < m; ++r) sum += W[r * own + s] * Rows(lane<width>(z[r / width], r % width));
    lambda_[step.strip + s] = -sum;
  }
}

template class LoopSubstitution<double, 1>;
template class LoopSubstitution<double, 3>;
template class LoopSubstitution<double, 6>;
template class LoopSubstitution<long double, 1>;
template class LoopSubstitution<Count, 1>;

}  // namespace lanc
