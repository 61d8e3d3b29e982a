#include "lib/system/equations.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace lanc {

template <class S>
void accelerations(const System<S>& system, const RightHandSide<S>& rhs, Solution<S>& solution) {
  for (int i = 0; i < system.model.bodies(); ++i) {
    const Link& link = system.model.link(i);
    Motion<S> a = rhs.bias[i];
    if (link.parent != ground) a += moved_outward(system.bodies[i].r, solution.acceleration[link.parent]);
    for (int k = link.v; k < link.v + link.nv; ++k)
      add_along(system.model.column_kind(k), system.columns[k], solution.vdot[k], a);
    solution.acceleration[i] = a;
  }
}

template <class S>
void wrenches(const System<S>& system, const RightHandSide<S>& rhs, Solution<S>& solution) {
  const int n = system.model.bodies();
  for (int i = 0; i < n; ++i) solution.wrench[i] = system.bodies[i].inertia * solution.acceleration[i] - rhs.force[i];
  for (int i = n - 1; i >= 0; --i)
    if (const int p = system.model.link(i).parent; p != ground)
      solution.wrench[p] += moved_inward(system.bodies[i].r, solution.wrench[i]);
}

template <class S>
void drive_forces(const System<S>& system, Solution<S>& solution) {
  for (int d = 0; d < system.model.drives(); ++d)
    solution.drive_force[d] = system.drive_load[d] + project(system.model.drive_kind(d), system.drive_columns[d],
                                                             solution.wrench[system.model.body_of_drive(d)]);
}

template <class S>
void inverse_dynamics(const System<S>& system, Solution<S>& solution, std::vector<S>& tau) {
  accelerations(system, system.rhs, solution);
  wrenches(system, system.rhs, solution);
  drive_forces(system, solution);
  const Model& model = system.model;
  tau.resize(model.nv());
  for (int k = 0; k < model.nv(); ++k) {
    tau[k] = project(model.column_kind(k), system.columns[k], solution.wrench[model.body_of_velocity(k)]) -
             system.rhs.tau[k];
    if (model.armature()[k] != 0) tau[k] += S(model.armature()[k]) * solution.vdot[k];
  }
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
}

namespace {

Vec3<double> magnitude(const Vec3<double>& a) { return {std::abs(a.x), std::abs(a.y), std::abs(a.z)}; }

/// |a| × |b| with every product positive.
Vec3<double> cross_magnitude(const Vec3<double>& a, const Vec3<double>& b) {
  return {a.y * b.z + a.z * b.y, a.z * b.x + a.x * b.z, a.x * b.y + a.y * b.x};
}

template <class S>
Motion<double> magnitude(const Motion<S>& a) {
  const auto d = [](const Vec3<S>& v) {
    return magnitude(Vec3<double>{to_double(v.x), to_double(v.y), to_double(v.z)});
  };
  return {d(a.angular), d(a.linear)};
}
template <class S>
Wrench<double> magnitude(const Wrench<S>& f) {
  const auto d = [](const Vec3<S>& v) {
    return magnitude(Vec3<double>{to_double(v.x), to_double(v.y), to_double(v.z)});
  };
  return {d(f.moment), d(f.force)};
}

/// Gathers max |r| / (|A||x| + |b|) over rows, and the norms of the normwise error.
struct RowMaxima {
  double componentwise = 0, residual = 0, matrix = 0, load = 0;
  bool finite = true;

  void add(double r, double row, double b, double matrix_row) {
    r = std::abs(r);
    finite = finite && std::isfinite(r) && std::isfinite(row) && std::isfinite(b);
    if (r > 0) componentwise = std::max(componentwise, r / (row + b));
    residual = std::max(residual, r);
    load = std::max(load, b);
    matrix = std::max(matrix, matrix_row);
  }
  void add(const Vec3<double>& r, const Vec3<double>& row, const Vec3<double>& b, double matrix_row) {
    add(r.x, row.x, b.x, matrix_row), add(r.y, row.y, b.y, matrix_row), add(r.z, row.z, b.z, matrix_row);
  }
};

double sum(const Vec3<double>& a) { return a.x + a.y + a.z; }

}  // namespace

template <class S>
BackwardError backward_error(const System<S>& system, const Solution<S>& solution) {
  const Model& model = system.model;
  const int n = model.bodies();
  RightHandSide<S> r(model);
  residual(system, system.rhs, solution, r);

  // |A||x| row by row, with the same structure as residual()
  std::vector<Wrench<double>> force(n);
  std::vector<Motion<double>> motion(n);
  std::vector<double> tau(model.nv());
  RowMaxima rows;
  double x = 0;
  const auto grow = [&](const Vec3<double>& a) { x = std::max({x, a.x, a.y, a.z}); };
  for (int i = 0; i < n; ++i) {
    const Link& link = model.link(i);
    const auto& body = system.bodies[i];
    const Motion<double> a = magnitude(solution.acceleration[i]);
    const Wrench<double> f = magnitude(solution.wrench[i]);
    const Motion<S> as_motion{body.inertia.h, body.r};
    const Vec3<double> h = magnitude(as_motion).angular, arm = magnitude(as_motion).linear;
    const auto d = [](const S& s) { return std::abs(to_double(s)); };
    const Sym3<double> J{d(body.inertia.J.xx), d(body.inertia.J.yy), d(body.inertia.J.zz),
                         d(body.inertia.J.xy), d(body.inertia.J.xz), d(body.inertia.J.yz)};
    const double m = d(body.inertia.mass);
    force[i] += {J * a.angular + cross_magnitude(h, a.linear) + f.moment,
                 a.linear * m + cross_magnitude(a.angular, h) + f.force};
    motion[i] = a;
    if (link.parent != ground) {
      const Motion<double> ap = magnitude(solution.acceleration[link.parent]);
      force[link.parent] += {f.moment + cross_magnitude(arm, f.force), f.force};
      motion[i] += {ap.angular, ap.linear + cross_magnitude(ap.angular, arm)};
    }
    for (int k = link.v; k < link.v + link.nv; ++k) {
      const Motion<double> column = magnitude(system.columns[k]);
      const double vdot = d(solution.vdot[k]);
      add_along(ColumnKind::screw, column, vdot, motion[i]);
      tau[k] = project(ColumnKind::screw, column, f) + model.armature()[k] * vdot;
      x = std::max(x, vdot);
      rows.matrix = std::max(rows.matrix, sum(column.angular) + sum(column.linear) + model.armature()[k]);
    }
    rows.matrix = std::max({rows.matrix, J.xx + J.xy + J.xz + h.y + h.z + 1, J.yy + J.xy + J.yz + h.x + h.z + 1,
                            J.zz + J.xz + J.yz + h.x + h.y + 1, m + h.x + h.y + 1, sum(arm) + 3});
    grow(a.angular), grow(a.linear), grow(f.moment), grow(f.force);
  }
  const auto plain = [](const Vec3<S>& v) { return Vec3<double>{to_double(v.x), to_double(v.y), to_double(v.z)}; };
  for (int i = 0; i < n; ++i) {
    const Wrench<double> load = magnitude(system.rhs.force[i]);
    const Motion<double> bias = magnitude(system.rhs.bias[i]);
    rows.add(plain(r.force[i].moment), force[i].moment, load.moment, 0);
    rows.add(plain(r.force[i].force), force[i].force, load.force, 0);
    rows.add(plain(r.bias[i].angular), motion[i].angular, bias.angular, 0);
    rows.add(plain(r.bias[i].linear), motion[i].linear, bias.linear, 0);
  }
  for (int k = 0; k < model.nv(); ++k) rows.add(to_double(r.tau[k]), tau[k], std::abs(to_double(system.rhs.tau[k])), 0);
  if (!rows.finite) return {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::quiet_NaN()};
  const double scale = rows.matrix * x + rows.load;
  return {rows.componentwise, scale > 0 ? rows.residual / scale : 0.0};
}

template void accelerations(const System<double>&, const RightHandSide<double>&, Solution<double>&);
template void wrenches(const System<double>&, const RightHandSide<double>&, Solution<double>&);
template void drive_forces(const System<double>&, Solution<double>&);
template void inverse_dynamics(const System<double>&, Solution<double>&, std::vector<double>&);
template void residual(const System<double>&, const RightHandSide<double>&, const Solution<double>&,
                       RightHandSide<double>&);
template BackwardError backward_error(const System<double>&, const Solution<double>&);

template void accelerations(const System<long double>&, const RightHandSide<long double>&, Solution<long double>&);
template void wrenches(const System<long double>&, const RightHandSide<long double>&, Solution<long double>&);
template void drive_forces(const System<long double>&, Solution<long double>&);
template void inverse_dynamics(const System<long double>&, Solution<long double>&, std::vector<long double>&);
template void residual(const System<long double>&, const RightHandSide<long double>&, const Solution<long double>&,
                       RightHandSide<long double>&);
template BackwardError backward_error(const System<long double>&, const Solution<long double>&);

template void accelerations(const System<Count>&, const RightHandSide<Count>&, Solution<Count>&);
template void wrenches(const System<Count>&, const RightHandSide<Count>&, Solution<Count>&);
template void drive_forces(const System<Count>&, Solution<Count>&);
template void inverse_dynamics(const System<Count>&, Solution<Count>&, std::vector<Count>&);
template void residual(const System<Count>&, const RightHandSide<Count>&, const Solution<Count>&,
                       RightHandSide<Count>&);
template BackwardError backward_error(const System<Count>&, const Solution<Count>&);

}  // namespace lanc
