#include "tests/support/naive.h"

#include <Eigen/Dense>
#include <algorithm>
#include <stdexcept>

#include "lib/formulation/formulation.h"
#include "lib/system/equations.h"
#include "lib/system/evaluator.h"

namespace lanc::test {
namespace {

using Real = long double;
using Matrix = Eigen::Matrix<Real, Eigen::Dynamic, Eigen::Dynamic>;
using Vector = Eigen::Matrix<Real, Eigen::Dynamic, 1>;
using Matrix3 = Eigen::Matrix<Real, 3, 3>;
using Matrix6 = Eigen::Matrix<Real, 6, 6>;
using Vector6 = Eigen::Matrix<Real, 6, 1>;

Matrix3 tilde(const Vec3<Real>& a) {
  Matrix3 m;
  m << 0, -a.z, a.y, a.z, 0, -a.x, -a.y, a.x, 0;
  return m;
}

Vector6 six(const Vec3<Real>& a, const Vec3<Real>& b) {
  Vector6 v;
  v << a.x, a.y, a.z, b.x, b.y, b.z;
  return v;
}
Vector6 six(const Motion<Real>& a) { return six(a.angular, a.linear); }
Vector6 six(const Wrench<Real>& f) { return six(f.moment, f.force); }

Matrix6 inertia(const RigidInertia<Real>& M) {
  Matrix6 m = Matrix6::Zero();
  m.topLeftCorner<3, 3>() << M.J.xx, M.J.xy, M.J.xz, M.J.xy, M.J.yy, M.J.yz, M.J.xz, M.J.yz, M.J.zz;
  m.topRightCorner<3, 3>() = tilde(M.h);
  m.bottomLeftCorner<3, 3>() = tilde(M.h).transpose();
  m.bottomRightCorner<3, 3>().diagonal().setConstant(M.mass);
  return m;
}

/// B_ip = [[1, 0], [−[r]×, 1]].
Matrix6 transport(const Vec3<Real>& r) {
  Matrix6 B = Matrix6::Identity();
  B.bottomLeftCorner<3, 3>() = -tilde(r);
  return B;
}

Vec3<Real> vec3(const Vector& x, Eigen::Index at) { return {x[at], x[at + 1], x[at + 2]}; }

void add_drive_forces(const System<Real>& system, Solution<Real>& solution) {
  for (int d = 0; d < system.model.drives(); ++d)
    solution.drive_force[d] =
        system.drive_load[d] + six(system.drive_columns[d]).dot(six(solution.wrench[system.model.body_of_drive(d)]));
}

}  // namespace

Solution<Real> solve_eq14_naively(const System<Real>& system) {
  const Model& model = system.model;
  const int n = model.bodies(), size = 12 * n + model.nv();
  const auto a = [](int i) { return 6 * i; };
  const auto f = [n](int i) { return 6 * (n + i); };
  const auto v = [n](int k) { return 12 * n + k; };
  Matrix A = Matrix::Zero(size, size);
  Vector b = Vector::Zero(size);
  for (int i = 0; i < n; ++i) {
    const Link& link = model.link(i);
    A.block<6, 6>(a(i), a(i)) = inertia(system.bodies[i].inertia);
    A.block<6, 6>(a(i), f(i)) = -Matrix6::Identity();
    A.block<6, 6>(f(i), a(i)) = -Matrix6::Identity();
    if (link.parent != ground) {
      const Matrix6 B = transport(system.bodies[i].r);
      A.block<6, 6>(f(i), a(link.parent)) = B;
      A.block<6, 6>(a(link.parent), f(i)) = B.transpose();
    }
    for (int k = link.v; k < link.v + link.nv; ++k) {
      A.block<6, 1>(f(i), v(k)) = six(system.columns[k]);
      A.block<1, 6>(v(k), f(i)) = six(system.columns[k]).transpose();
      A(v(k), v(k)) = model.armature()[k];
      b[v(k)] = system.rhs.tau[k];
    }
    b.segment<6>(a(i)) = six(system.rhs.force[i]);
    b.segment<6>(f(i)) = -six(system.rhs.bias[i]);
  }
  Solution<Real> solution(model);
  if (size == 0) return solution;
  Eigen::FullPivLU<Matrix> lu(A);
  lu.setThreshold(0);  // a body of 1e-16 kg is no reason to drop a pivot
  Vector x = lu.solve(b);
  x += lu.solve(b - A * x);
  for (int i = 0; i < n; ++i) {
    solution.acceleration[i] = {vec3(x, a(i)), vec3(x, a(i) + 3)};
    solution.wrench[i] = {vec3(x, f(i)), vec3(x, f(i) + 3)};
  }
  for (int k = 0; k < model.nv(); ++k) solution.vdot[k] = x[v(k)];
  add_drive_forces(system, solution);
  return solution;
}

ReducedSystem reduce_naively(const System<Real>& system) {
  const Model& model = system.model;
  const int n = model.bodies(), nv = model.nv();
  ReducedSystem r{Matrix::Zero(6 * n, nv), {}, Vector(6 * n), {}};
  Matrix MJ(6 * n, nv);
  Vector force(6 * n);
  for (int i = 0; i < n; ++i) {
    const Link& link = model.link(i);
    r.bias.segment<6>(6 * i) = six(system.rhs.bias[i]);
    if (link.parent != ground) {
      const Matrix6 B = transport(system.bodies[i].r);
      r.J.middleRows<6>(6 * i) = B * r.J.middleRows<6>(6 * link.parent);
      r.bias.segment<6>(6 * i) += B * r.bias.segment<6>(6 * link.parent);
    }
    for (int k = link.v; k < link.v + link.nv; ++k) r.J.block<6, 1>(6 * i, k) = six(system.columns[k]);
    const Matrix6 M = inertia(system.bodies[i].inertia);
    MJ.middleRows<6>(6 * i) = M * r.J.middleRows<6>(6 * i);
    force.segment<6>(6 * i) = six(system.rhs.force[i]) - M * r.bias.segment<6>(6 * i);
  }
  r.b = r.J.transpose() * force;
  r.H = r.J.transpose() * MJ;
  for (int k = 0; k < nv; ++k) r.b[k] += system.rhs.tau[k], r.H(k, k) += model.armature()[k];
  return r;
}

Solution<Real> complete_naively(const System<Real>& system, const ReducedSystem& reduced, const Vector& vdot,
                                const Vector& lambda) {
  const Model& model = system.model;
  const int n = model.bodies();
  const Vector a = reduced.J * vdot + reduced.bias;
  Solution<Real> solution(model);
  for (int k = 0; k < model.nv(); ++k) solution.vdot[k] = vdot[k];
  for (int k = 0; k < lambda.size(); ++k) solution.lambda[k] = lambda[k];
  Matrix wrench = Matrix::Zero(6, n);
  for (const Closure& c : model.closures().closures)
    for (int k = c.row; k < c.row + c.conditions().count; ++k) {
      if (c.body_a != ground) wrench.col(c.body_a) -= six(system.closure_rows[k].a) * lambda[k];
      if (c.body_b != ground) wrench.col(c.body_b) -= six(system.closure_rows[k].b) * lambda[k];
    }
  for (int i = n - 1; i >= 0; --i) {
    wrench.col(i) += inertia(system.bodies[i].inertia) * a.segment<6>(6 * i) - six(system.rhs.force[i]);
    const Vector f = wrench.col(i);
    solution.acceleration[i] = {vec3(a, 6 * i), vec3(a, 6 * i + 3)};
    solution.wrench[i] = {vec3(f, 0), vec3(f, 3)};
    if (const int p = model.link(i).parent; p != ground) wrench.col(p) += transport(system.bodies[i].r).transpose() * f;
  }
  add_drive_forces(system, solution);
  return solution;
}

Solution<Real> solve_reduced_naively(const System<Real>& system) {
  const ReducedSystem reduced = reduce_naively(system);
  Vector vdot(system.model.nv());
  if (vdot.size() > 0) vdot = Eigen::LDLT<Matrix>(reduced.H).solve(reduced.b);
  return complete_naively(system, reduced, vdot, Vector::Zero(system.model.closures().rows()));
}

System<Real> system_in_long_double(const Case& c) {
  Evaluator<Real> evaluator(c.model);
  return evaluator.system(cast<Real>(c.state), cast<Real>(c.loads));
}

Solution<Real> reference_solution(const Case& c) {
  const System<Real> system = system_in_long_double(c);
  constexpr int small = 12, middle = 400;
  if (c.model.bodies() <= small) return solve_eq14_naively(system);
  if (c.model.nv() <= middle && c.model.bodies() <= middle) return solve_reduced_naively(system);
  for (const FormulationInfo& info : formulations()) {
    if (!info.recursive || !info.create_long_double || info.objection(c.model)) continue;
    const auto formulation = info.create_long_double(c.model);
    Solution<Real> solution(c.model);
    const Outcome outcome = formulation->solve(system, solution);
    if (!outcome.usable()) continue;
    for (int k = 0; k < 3; ++k) formulation->refine(system, solution);
    return solution;
  }
  throw std::runtime_error("no formulation in long double for a large model");
}

namespace {

double unit_of_acceleration(const Model& model, ColumnKind kind) {
  return kind == ColumnKind::translation ? 1 : model.length();
}

double largest(const Vec3<Real>& a) {
  const auto d = [](Real x) { return std::abs(static_cast<double>(x)); };
  // written so that a NaN survives
  return std::max({d(a.x), d(a.y), d(a.z)}) + 0 * (d(a.x) + d(a.y) + d(a.z));
}

void raise(double& norm, double value) {
  if (!(value <= norm)) norm = value;
}

template <class S>
Vec3<Real> wide(const Vec3<S>& a) {
  return {Real(to_double(a.x)), Real(to_double(a.y)), Real(to_double(a.z))};
}
template <>
Vec3<Real> wide(const Vec3<Real>& a) {
  return a;
}
Real wide(Real x) { return x; }
Real wide(double x) { return x; }
Real wide(Count x) { return x.value(); }

}  // namespace

double Norms::worst() const {
  double result = 0;
  for (const double x : {vdot, acceleration, wrench, drive}) raise(result, x);
  return result;
}

template <class A, class B>
Norms difference(const Model& model, const Solution<A>& a, const Solution<B>& b) {
  Norms result;
  const double L = model.length();
  for (int k = 0; k < model.nv(); ++k)
    raise(result.vdot, std::abs(static_cast<double>(wide(a.vdot[k]) - wide(b.vdot[k]))) *
                           unit_of_acceleration(model, model.column_kind(k)));
  for (int i = 0; i < model.bodies(); ++i) {
    const auto& x = a.acceleration[i];
    const auto& y = b.acceleration[i];
    raise(result.acceleration, largest(wide(x.angular) - wide(y.angular)) * L);
    raise(result.acceleration, largest(wide(x.linear) - wide(y.linear)));
    const auto& f = a.wrench[i];
    const auto& g = b.wrench[i];
    raise(result.wrench, largest(wide(f.moment) - wide(g.moment)) / L);
    raise(result.wrench, largest(wide(f.force) - wide(g.force)));
  }
  for (int d = 0; d < model.drives(); ++d)
    raise(result.drive, std::abs(static_cast<double>(wide(a.drive_force[d]) - wide(b.drive_force[d]))) /
                            unit_of_acceleration(model, model.drive_kind(d)));
  return result;
}

template <class S>
Norms norms(const Model& model, const Solution<S>& solution) {
  Solution<S> zero(model);
  for (auto& x : zero.vdot) x = 0;
  for (auto& x : zero.drive_force) x = 0;
  return difference(model, solution, zero);
}

template Norms norms(const Model&, const Solution<double>&);
template Norms norms(const Model&, const Solution<long double>&);
template Norms difference(const Model&, const Solution<double>&, const Solution<double>&);
template Norms difference(const Model&, const Solution<double>&, const Solution<long double>&);
template Norms difference(const Model&, const Solution<long double>&, const Solution<long double>&);
template Norms difference(const Model&, const Solution<Count>&, const Solution<double>&);

Norms sizes(const System<Real>& system, const Solution<Real>& reference) {
  const Model& model = system.model;
  Norms result = norms(model, reference);
  const double L = model.length();
  for (int i = 0; i < model.bodies(); ++i) {
    raise(result.acceleration, largest(system.rhs.bias[i].angular) * L);
    raise(result.acceleration, largest(system.rhs.bias[i].linear));
    raise(result.wrench, largest(system.rhs.force[i].moment) / L);
    raise(result.wrench, largest(system.rhs.force[i].force));
  }
  raise(result.acceleration, largest(cast<Real>(model.gravity())));
  raise(result.acceleration, result.vdot);
  raise(result.vdot, result.acceleration);
  raise(result.wrench, result.drive);
  raise(result.drive, result.wrench);
  return result;
}

Norms relative(const Norms& d, const Norms& s) {
  const auto ratio = [](double x, double y) { return x == 0 ? 0 : x / y; };
  return {ratio(d.vdot, s.vdot), ratio(d.acceleration, s.acceleration), ratio(d.wrench, s.wrench),
          ratio(d.drive, s.drive)};
}

}  // namespace lanc::test
