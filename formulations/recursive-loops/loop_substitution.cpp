#include "formulations/recursive-loops/loop_substitution.h"

#include <algorithm>

namespace lanc {

/// Where numbers are. By way of System, RightHandSide and Solution each address took two loads a body, and the
/// registers for them: a fiftieth of a solution.
template <class S, int width>
struct LoopSubstitution<S, width>::Task {
  const LoopFactors<S, width>& factors;
  const typename System<S>::Body* bodies;
  const Motion<S>* columns;
  const Wrench<S>* force;
  const Motion<S>* bias;
  const S* tau;
  const S* gamma;
  S* vdot;
  Motion<S>* acceleration;
  Wrench<S>* wrench;
  S* lambda;

  Task(const LoopFactors<S, width>& f, const System<S>& system, const RightHandSide<S>& rhs, Solution<S>& x)
      : factors(f),
        bodies(system.bodies.data()),
        columns(system.columns.data()),
        force(rhs.force.data()),
        bias(rhs.bias.data()),
        tau(rhs.tau.data()),
        gamma(rhs.closure.data()),
        vdot(x.vdot.data()),
        acceleration(x.acceleration.data()),
        wrench(x.wrench.data()),
        lambda(x.lambda.data()) {}
};

namespace {

/// Numbers of rows as a strip.
template <int width, class Rows, class S>
Rows strip_of(const S* rows, int strip) {
  Rows result(0.0);
  for (int k = 0; k < width; ++k) set_lane<width>(result, k, rows[strip * width + k]);
  return result;
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
  const Task task(factors, system, rhs, solution);
  std::copy(rhs.force.begin(), rhs.force.end(), load_.begin());
  if (!factors.model().has_closures()) return forward(task, Pass::only), backward(task, Pass::only);
  for (std::size_t s = 0; s < gamma_.size(); ++s) gamma_[s] = strip_of<width, Rows>(task.gamma, s);
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
    if (at < 0)
      forward_closure(task.factors, plan.closures[-1 - at]);
    else if (const BodyStep& step = plan.bodies[at]; step.nv == 1)
      forward_body<1>(task, step, pass);
    else
      forward_joint(task, step, pass);
  }
}

template <class S, int width>
void LoopSubstitution<S, width>::backward(const Task& task, Pass pass) {
  const EliminationPlan& plan = task.factors.plan();
  const Motion<S>* const a = pass == Pass::correction ? delta_.data() : task.acceleration;
  for (auto at = plan.order.rbegin(); at != plan.order.rend(); ++at) {
    if (*at < 0)
      backward_closure(task.factors, plan.closures[-1 - *at], a);
    else if (const BodyStep& step = plan.bodies[*at]; step.nv == 1)
      backward_body<1>(task, step, pass, a);
    else
      backward_joint(task, step, pass, a);
  }
}

template <class S, int width>
void LoopSubstitution<S, width>::forward_joint(const Task& task, const BodyStep& step, Pass pass) {
  forward_body<any>(task, step, pass);
}
template <class S, int width>
void LoopSubstitution<S, width>::backward_joint(const Task& task, const BodyStep& step, Pass pass, const Motion<S>* a) {
  backward_body<any>(task, step, pass, a);
}

/// What is left open of the closure conditions, and of the balances of bodies what multipliers do to them: the rest of
/// these is backward_body()'s.
template <class S, int width>
void LoopSubstitution<S, width>::residual_of_closures(const Task& task) {
  for (const ClosureEnds& ends : task.factors.plan().ends)
    for (int s = ends.strip; s < ends.strip + count<width>(ends.strips); ++s) {
      Rows open = strip_of<width, Rows>(task.gamma, s);
      const auto end = [&](int body, const Wrench<Rows>& row) __attribute__((always_inline)) {
        if (body == ground) return;
        open += dot(in_every_lane<Rows>(task.acceleration[body]), row);
        Wrench<S> load;
        load = load_[body];
        for (int k = 0; k < width; ++k) load += lane<width>(row, k) * lane<width>(lambda_[s], k);
        load_[body] = load;
      };
      end(ends.body_a, task.factors.row_a(s));
      end(ends.body_b, task.factors.row_b(s));
      gamma_[s] = open;
    }
  if constexpr (width == 1)
    for (const Coupler& c : task.factors.model().closures().couplers) {
      gamma_[c.row] = task.gamma[c.row];
      for (const Coupler::Term& term : c.terms) gamma_[c.row] += S(term.factor) * task.vdot[term.v];
    }
}

template <class S, int width>
template <int freedoms>
void LoopSubstitution<S, width>::forward_body(const Task& task, const BodyStep& step, Pass pass) {
  const LoopFactors<S, width>& factors = task.factors;
  const EliminationPlan& plan = factors.plan();
  const std::span<const Attachment> around = step.attachments.of(plan.attachments);
  const int i = step.body;
  Wrench<S> rest;
  rest = load_[i];
  if (pass != Pass::correction) {
    const Motion<S>& bias = task.bias[i];
    rest -= factors.star(i) * bias;  // the product does not wait for what children hand on
    load_[i] = rest;
    const Wrench<Rows>* const e = factors.columns(step.first_column);
    for (const Attachment& a : around) {
      for (int s = 0; s < count<width>(a.strips); ++s)
        gamma_[a.strip + s] += dot(in_every_lane<Rows>(bias), e[a.column + s]);
    }
  }
  const int nv = freedoms == any ? step.nv : freedoms;
  if (step.parent == ground && nv == 0) return;
  for (int k = 0; k < nv; ++k) {
    const int v = step.v + k;
    S torque = task.tau[v] + project(factors.kind(v), task.columns[v], rest);
    if (pass == Pass::correction) {
      if (factors.model().has_armature()) torque -= S(factors.model().armature()[v]) * task.vdot[v];
      if constexpr (width == 1)  // else there are no couplers
        for (const DirectTerm& term : step.terms.of(plan.terms))
          if (term.freedom == k) torque += S(term.factor) * task.lambda[term.row];
    }
    start_[v] = torque * factors.freedom(v).inverse;
    if (step.parent != ground || k + 1 < nv) rest -= factors.freedom(v).D * torque;
    const Rows* const response = factors.responses(step, k);
    for (const Attachment& a : around) {
      for (int s = 0; s < count<width>(a.strips); ++s) gamma_[a.strip + s] += response[a.column + s] * Rows(torque);
    }
  }
  if (step.parent != ground) load_[step.parent] += moved_inward(task.bodies[i].r, rest);
}

template <class S, int width>
template <int freedoms>
void LoopSubstitution<S, width>::backward_body(const Task& task, const BodyStep& step, Pass pass,
                                               const Motion<S>* before) {
  const LoopFactors<S, width>& factors = task.factors;
  const std::span<const Attachment> around = step.attachments.of(factors.plan().attachments);
  const int i = step.body;
  Motion<S> a{};  // B_ip â_p + C η̇ of the columns done
  const bool at_rest = step.parent == ground;
  const int nv = freedoms == any ? step.nv : freedoms;
  if (!at_rest) a = moved_outward(task.bodies[i].r, before[step.parent]);
  for (int k = nv - 1; k >= 0; --k) {
    const int v = step.v + k;
    S vdot = start_[v];
    if (!at_rest || k != nv - 1) vdot -= dot(a, factors.freedom(v).D);
    const Rows* const response = factors.responses(step, k);
    for (const Attachment& m : around) {
      for (int s = 0; s < count<width>(m.strips); ++s)
        vdot += sum_of_lanes<width>(response[m.column + s] * lambda_[m.strip + s]);
    }
    if (pass == Pass::correction)
      task.vdot[v] += vdot;
    else
      task.vdot[v] = vdot;
    add_along(factors.kind(v), task.columns[v], vdot, a);
  }
  if (pass == Pass::correction) {
    delta_[i] = a;
    task.acceleration[i] += a;
  } else {
    const Motion<S> whole = a + task.bias[i];
    task.acceleration[i] = whole;
    if (pass == Pass::first) {  // for the residual
      load_[i] = plus_product(task.force[i], task.bodies[i].inertia, -whole);
      return;
    }
  }
  Wrench<S> f = plus_product(-load_[i], factors.star(i), a);
  const Wrench<Rows>* const e = factors.columns(step.first_column);
  for (const Attachment& m : around) {
    for (int s = 0; s < count<width>(m.strips); ++s) f -= sum_of_lanes<width>(e[m.column + s] * lambda_[m.strip + s]);
  }
  task.wrench[i] = f;
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
  for (const Attachment& a : step.attachments.of(factors.plan().attachments)) {
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
                                                  const Motion<S>* a) {
  const int own = count<width>(step.strips), m = own * width;
  const Rows* const W = factors.weights(step);
  const Rows* const inverse = factors.inverse(step);
  Rows z[most_strips<width>];
  for (int s = 0; s < own; ++s)
    z[s] = step.body < 0 ? Rows(0.0) : dot(in_every_lane<Rows>(a[step.body]), factors.columns(step.first_column)[s]);
  for (const Attachment& d : step.attachments.of(factors.plan().attachments)) {
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
