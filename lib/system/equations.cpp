#include "lib/system/equations.h"

namespace lanc {

namespace {

template <bool with_rates, bool with_wrenches, class S>
void sweep_outward(const System<S>& system, const RightHandSide<S>& rhs, Solution<S>& solution) {
  const std::span<const Link> links = system.model.links();
  Motion<S> before;  // of the body before, often the parent: kept at hand, since memory would answer late
  for (int i = 0; i < system.model.bodies(); ++i) {
    const Link& link = links[i];
    Motion<S> a = rhs.bias[i];
    if (link.parent != ground) {
      if (link.parent != i - 1) before = solution.acceleration[link.parent];
      a += moved_outward(system.bodies[i].r, before);
    }
    if constexpr (with_rates)
      for (int k = link.v; k < link.v + link.nv; ++k)
        add_along(system.model.column_kind(k), system.columns[k], solution.vdot[k], a);
    solution.acceleration[i] = before = a;
    if constexpr (with_wrenches) solution.wrench[i] = plus_product(-rhs.force[i], system.bodies[i].inertia, a);
  }
}

template <class S>
void sweep_inward(const System<S>& system, Solution<S>& solution) {
  const std::span<const Link> links = system.model.links();
  Wrench<S> handed;  // by body i + 1 to its parent, if that is i
  bool by_next = false;
  for (int i = system.model.bodies() - 1; i >= 0; --i) {
    const int p = links[i].parent;
    Wrench<S> f = solution.wrench[i];
    if (by_next) f += handed, solution.wrench[i] = f;
    by_next = p == i - 1;
    if (p == ground) continue;
    handed = moved_inward(system.bodies[i].r, f);
    if (!by_next) solution.wrench[p] += handed;
  }
}

/// Adds sign × G_sᵀ λ to wrenches on bodies.
template <class S>
void add_closure_wrenches(const System<S>& system, const std::vector<S>& lambda, const S& sign,
                          std::vector<Wrench<S>>& wrenches) {
  for (const Closure& c : system.model.closures().closures)
    for (int k = c.row; k < c.row + c.conditions().count; ++k) {
      if (c.body_a != ground) wrenches[c.body_a] += system.closure_rows[k].a * (sign * lambda[k]);
      if (c.body_b != ground) wrenches[c.body_b] += system.closure_rows[k].b * (sign * lambda[k]);
    }
}

}  // namespace

template <class S>
void add_closure_reactions(const System<S>& system, const std::vector<S>& lambda, RightHandSide<S>& rhs) {
  add_closure_wrenches(system, lambda, S(1.0), rhs.force);
  for (const Coupler& c : system.model.closures().couplers)
    for (const Coupler::Term& term : c.terms) rhs.tau[term.v] += S(term.factor) * lambda[c.row];
}

template <class S>
void closure_accelerations(const System<S>& system, const RightHandSide<S>& rhs, const Solution<S>& solution,
                           std::vector<S>& result) {
  result = rhs.closure;
  for (const Closure& c : system.model.closures().closures)
    for (int k = c.row; k < c.row + c.conditions().count; ++k) {
      if (c.body_a != ground) result[k] += dot(solution.acceleration[c.body_a], system.closure_rows[k].a);
      if (c.body_b != ground) result[k] += dot(solution.acceleration[c.body_b], system.closure_rows[k].b);
    }
  for (const Coupler& c : system.model.closures().couplers)
    for (const Coupler::Term& term : c.terms) result[c.row] += S(term.factor) * solution.vdot[term.v];
}

template <class S>
void accelerations(const System<S>& system, const RightHandSide<S>& rhs, Solution<S>& solution) {
  sweep_outward<true, false>(system, rhs, solution);
}

template <class S>
void bias_accelerations(const System<S>& system, const RightHandSide<S>& rhs, Solution<S>& solution) {
  sweep_outward<false, false>(system, rhs, solution);
}

template <class S>
void wrenches(const System<S>& system, const RightHandSide<S>& rhs, Solution<S>& solution) {
  const int n = system.model.bodies();
  for (int i = 0; i < n; ++i)
    solution.wrench[i] = plus_product(-rhs.force[i], system.bodies[i].inertia, solution.acceleration[i]);
  if (system.model.has_closures()) add_closure_wrenches(system, solution.lambda, S(-1.0), solution.wrench);
  sweep_inward(system, solution);
}

template <class S>
void newton_euler(const System<S>& system, const RightHandSide<S>& rhs, Solution<S>& solution) {
  sweep_outward<true, true>(system, rhs, solution);
  if (system.model.has_closures()) add_closure_wrenches(system, solution.lambda, S(-1.0), solution.wrench);
  sweep_inward(system, solution);
}

template <class S>
void newton_euler_at_rest(const System<S>& system, const RightHandSide<S>& rhs, Solution<S>& solution) {
  sweep_outward<false, true>(system, rhs, solution);
  sweep_inward(system, solution);
}

template <class S>
void drive_forces(const System<S>& system, Solution<S>& solution) {
  for (int d = 0; d < system.model.drives(); ++d)
    solution.drive_force[d] = system.drive_load[d] + project(system.model.drive_kind(d), system.drive_columns[d],
                                                             solution.wrench[system.model.body_of_drive(d)]);
}

template <class S>
void inverse_dynamics(const System<S>& system, Solution<S>& solution, std::vector<S>& tau) {
  newton_euler(system, system.rhs, solution);
  drive_forces(system, solution);
  const Model& model = system.model;
  tau.resize(model.nv());
  for (int k = 0; k < model.nv(); ++k) {
    tau[k] = project(model.column_kind(k), system.columns[k], solution.wrench[model.body_of_velocity(k)]) -
             system.rhs.tau[k];
    if (model.armature()[k] != 0) tau[k] += S(model.armature()[k]) * solution.vdot[k];
  }
  for (const Coupler& c : model.closures().couplers)
    for (const Coupler::Term& term : c.terms) tau[term.v] -= S(term.factor) * solution.lambda[c.row];
}

template <class S>
void residual(const System<S>& system, const RightHandSide<S>& rhs, const Solution<S>& solution,
              RightHandSide<S>& result) {
  const Model& model = system.model;
  for (int i = 0; i < model.bodies(); ++i) {
    const Link& link = model.link(i);
    const auto& body = system.bodies[i];
    result.force[i] = rhs.force[i] - body.inertia * solution.acceleration[i] + solution.wrench[i];
    result.bias[i] = rhs.bias[i] - solution.acceleration[i];
    if (link.parent != ground) {
      result.force[link.parent] -= moved_inward(body.r, solution.wrench[i]);
      result.bias[i] += moved_outward(body.r, solution.acceleration[link.parent]);
    }
    for (int k = link.v; k < link.v + link.nv; ++k) {
      add_along(model.column_kind(k), system.columns[k], solution.vdot[k], result.bias[i]);
      result.tau[k] = rhs.tau[k] - project(model.column_kind(k), system.columns[k], solution.wrench[i]);
      if (model.armature()[k] != 0) result.tau[k] -= S(model.armature()[k]) * solution.vdot[k];
    }
  }
  if (!model.has_closures()) return;
  add_closure_reactions(system, solution.lambda, result);
  closure_accelerations(system, rhs, solution, result.closure);
}

template void add_closure_reactions(const System<double>&, const std::vector<double>&, RightHandSide<double>&);
template void closure_accelerations(const System<double>&, const RightHandSide<double>&, const Solution<double>&,
                                    std::vector<double>&);
template void accelerations(const System<double>&, const RightHandSide<double>&, Solution<double>&);
template void bias_accelerations(const System<double>&, const RightHandSide<double>&, Solution<double>&);
template void wrenches(const System<double>&, const RightHandSide<double>&, Solution<double>&);
template void newton_euler(const System<double>&, const RightHandSide<double>&, Solution<double>&);
template void newton_euler_at_rest(const System<double>&, const RightHandSide<double>&, Solution<double>&);
template void drive_forces(const System<double>&, Solution<double>&);
template void inverse_dynamics(const System<double>&, Solution<double>&, std::vector<double>&);
template void residual(const System<double>&, const RightHandSide<double>&, const Solution<double>&,
                       RightHandSide<double>&);

template void add_closure_reactions(const System<long double>&, const std::vector<long double>&,
                                    RightHandSide<long double>&);
template void closure_accelerations(const System<long double>&, const RightHandSide<long double>&,
                                    const Solution<long double>&, std::vector<long double>&);
template void accelerations(const System<long double>&, const RightHandSide<long double>&, Solution<long double>&);
template void bias_accelerations(const System<long double>&, const RightHandSide<long double>&, Solution<long double>&);
template void wrenches(const System<long double>&, const RightHandSide<long double>&, Solution<long double>&);
template void newton_euler(const System<long double>&, const RightHandSide<long double>&, Solution<long double>&);
template void newton_euler_at_rest(const System<long double>&, const RightHandSide<long double>&,
                                   Solution<long double>&);
template void drive_forces(const System<long double>&, Solution<long double>&);
template void inverse_dynamics(const System<long double>&, Solution<long double>&, std::vector<long double>&);
template void residual(const System<long double>&, const RightHandSide<long double>&, const Solution<long double>&,
                       RightHandSide<long double>&);

template void add_closure_reactions(const System<Count>&, const std::vector<Count>&, RightHandSide<Count>&);
template void closure_accelerations(const System<Count>&, const RightHandSide<Count>&, const Solution<Count>&,
                                    std::vector<Count>&);
template void accelerations(const System<Count>&, const RightHandSide<Count>&, Solution<Count>&);
template void bias_accelerations(const System<Count>&, const RightHandSide<Count>&, Solution<Count>&);
template void wrenches(const System<Count>&, const RightHandSide<Count>&, Solution<Count>&);
template void newton_euler(const System<Count>&, const RightHandSide<Count>&, Solution<Count>&);
template void newton_euler_at_rest(const System<Count>&, const RightHandSide<Count>&, Solution<Count>&);
template void drive_forces(const System<Count>&, Solution<Count>&);
template void inverse_dynamics(const System<Count>&, Solution<Count>&, std::vector<Count>&);
template void residual(const System<Count>&, const RightHandSide<Count>&, const Solution<Count>&,
                       RightHandSide<Count>&);

template void add_closure_reactions(const System<Dual<8>>&, const std::vector<Dual<8>>&, RightHandSide<Dual<8>>&);
template void closure_accelerations(const System<Dual<8>>&, const RightHandSide<Dual<8>>&, const Solution<Dual<8>>&,
                                    std::vector<Dual<8>>&);
template void accelerations(const System<Dual<8>>&, const RightHandSide<Dual<8>>&, Solution<Dual<8>>&);
template void bias_accelerations(const System<Dual<8>>&, const RightHandSide<Dual<8>>&, Solution<Dual<8>>&);
template void wrenches(const System<Dual<8>>&, const RightHandSide<Dual<8>>&, Solution<Dual<8>>&);
template void newton_euler(const System<Dual<8>>&, const RightHandSide<Dual<8>>&, Solution<Dual<8>>&);
template void newton_euler_at_rest(const System<Dual<8>>&, const RightHandSide<Dual<8>>&, Solution<Dual<8>>&);
template void drive_forces(const System<Dual<8>>&, Solution<Dual<8>>&);
template void inverse_dynamics(const System<Dual<8>>&, Solution<Dual<8>>&, std::vector<Dual<8>>&);
template void residual(const System<Dual<8>>&, const RightHandSide<Dual<8>>&, const Solution<Dual<8>>&,
                       RightHandSide<Dual<8>>&);

}  // namespace lanc
