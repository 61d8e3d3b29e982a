#include <algorithm>
#include <cmath>
#include <limits>

#include "lib/system/equations.h"

namespace lanc {
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

/// Gathers the backward errors over rows, given ‖x‖∞ and the number of unknowns.
struct RowMaxima {
  double x_norm;
  double unknowns;
  double componentwise = 0, residual = 0, matrix = 0, load = 0;
  bool finite = true;

  /// One row: residual, Σ|A||x|, |b|, and the sum of |A| over the row.
  void add(double r, double row, double b, double matrix_row) {
    r = std::abs(r);
    finite = finite && std::isfinite(r) && std::isfinite(row) && std::isfinite(b);
    // A row that consists of rounding errors alone (Cᵀf̂ = 0 with one entry of C) is judged by the size of x instead:
    // Arioli, Demmel & Duff 1989, section 2.
    const double whole = matrix_row * x_norm;
    const bool noise = row + b < 1000 * unknowns * std::numeric_limits<double>::epsilon() * (whole + b);
    if (r > 0) componentwise = std::max(componentwise, r / (noise ? row + whole : row + b));
    residual = std::max(residual, r);
    load = std::max(load, b);
    matrix = std::max(matrix, matrix_row);
  }
  void add(const Vec3<double>& r, const Vec3<double>& row, const Vec3<double>& b, const Vec3<double>& matrix_row) {
    add(r.x, row.x, b.x, matrix_row.x), add(r.y, row.y, b.y, matrix_row.y), add(r.z, row.z, b.z, matrix_row.z);
  }
};

/// Σ|A||y| over the rows of eq. 14 for given |y|: the row sums of |A||x| with y = |x|, and of |A| with y = 1.
struct RowSums {
  std::vector<Wrench<double>> force;
  std::vector<Motion<double>> motion;
  std::vector<double> tau, closure;

  template <class S, class A, class F, class V, class L>
  RowSums(const System<S>& system, const A& acceleration, const F& wrench, const V& vdot, const L& lambda)
      : force(system.model.bodies()),
        motion(system.model.bodies()),
        tau(system.model.nv()),
        closure(system.model.closures().rows()) {
    const Model& model = system.model;
    const auto d = [](const S& s) { return std::abs(to_double(s)); };
    for (int i = 0; i < model.bodies(); ++i) {
      const Link& link = model.link(i);
      const auto& body = system.bodies[i];
      const Motion<double> a = acceleration(i);
      const Wrench<double> f = wrench(i);
      const Motion<double> arms = magnitude(Motion<S>{body.inertia.h, body.r});
      const Vec3<double>&h = arms.angular, r = arms.linear;
      const Sym3<double> J{d(body.inertia.J.xx), d(body.inertia.J.yy), d(body.inertia.J.zz),
                           d(body.inertia.J.xy), d(body.inertia.J.xz), d(body.inertia.J.yz)};
      force[i] += {J * a.angular + cross_magnitude(h, a.linear) + f.moment,
                   a.linear * d(body.inertia.mass) + cross_magnitude(a.angular, h) + f.force};
      motion[i] = a;
      if (link.parent != ground) {
        const Motion<double> p = acceleration(link.parent);
        force[link.parent] += {f.moment + cross_magnitude(r, f.force), f.force};
        motion[i] += {p.angular, p.linear + cross_magnitude(p.angular, r)};
      }
      for (int k = link.v; k < link.v + link.nv; ++k) {
        const Motion<double> column = magnitude(system.columns[k]);
        add_along(ColumnKind::screw, column, vdot(k), motion[i]);
        tau[k] = project(ColumnKind::screw, column, f) + model.armature()[k] * vdot(k);
      }
    }
    for (const Closure& c : model.closures().closures)
      for (int k = c.row; k < c.row + c.conditions().count; ++k) {
        const auto side = [&](int body, const Wrench<S>& entries) {
          if (body == ground) return;
          const Wrench<double> row = magnitude(entries);
          closure[k] += dot(acceleration(body), row);
          force[body] += row * lambda(k);
        };
        side(c.body_a, system.closure_rows[k].a), side(c.body_b, system.closure_rows[k].b);
      }
    for (const Coupler& c : model.closures().couplers)
      for (const Coupler::Term& term : c.terms) {
        closure[c.row] += std::abs(term.factor) * vdot(term.v);
        tau[term.v] += std::abs(term.factor) * lambda(c.row);
      }
  }
};

template <class S>
double largest_entry(const Solution<S>& solution) {
  double x = 0;
  const auto grow = [&](const Vec3<double>& a) { x = std::max({x, a.x, a.y, a.z}); };
  for (const Motion<S>& acceleration : solution.acceleration) {
    const Motion<double> a = magnitude(acceleration);
    grow(a.angular), grow(a.linear);
  }
  for (const Wrench<S>& wrench : solution.wrench) {
    const Wrench<double> f = magnitude(wrench);
    grow(f.moment), grow(f.force);
  }
  for (const S& v : solution.vdot) x = std::max(x, std::abs(to_double(v)));
  for (const S& l : solution.lambda) x = std::max(x, std::abs(to_double(l)));
  return x;
}

}  // namespace

template <class S>
BackwardError backward_error(const System<S>& system, const Solution<S>& solution) {
  const Model& model = system.model;
  RightHandSide<S> r(model);
  residual(system, system.rhs, solution, r);
  const RowSums Ax(
      system, [&](int i) { return magnitude(solution.acceleration[i]); },
      [&](int i) { return magnitude(solution.wrench[i]); },
      [&](int k) { return std::abs(to_double(solution.vdot[k])); },
      [&](int k) { return std::abs(to_double(solution.lambda[k])); });
  constexpr Vec3<double> one{1, 1, 1};
  const RowSums A(
      system,
      [&](int) {
        return Motion<double>{one, one};
      },
      [&](int) {
        return Wrench<double>{one, one};
      },
      [](int) { return 1.0; }, [](int) { return 1.0; });

  const int closures = model.closures().rows();
  RowMaxima rows{.x_norm = largest_entry(solution), .unknowns = 12.0 * model.bodies() + model.nv() + closures};
  for (int i = 0; i < model.bodies(); ++i) {
    const Wrench<double> b = magnitude(system.rhs.force[i]), rf = magnitude(r.force[i]);
    const Motion<double> bias = magnitude(system.rhs.bias[i]), rb = magnitude(r.bias[i]);
    rows.add(rf.moment, Ax.force[i].moment, b.moment, A.force[i].moment);
    rows.add(rf.force, Ax.force[i].force, b.force, A.force[i].force);
    rows.add(rb.angular, Ax.motion[i].angular, bias.angular, A.motion[i].angular);
    rows.add(rb.linear, Ax.motion[i].linear, bias.linear, A.motion[i].linear);
  }
  for (int k = 0; k < model.nv(); ++k)
    rows.add(to_double(r.tau[k]), Ax.tau[k], std::abs(to_double(system.rhs.tau[k])), A.tau[k]);
  for (int k = 0; k < closures; ++k)
    rows.add(to_double(r.closure[k]), Ax.closure[k], std::abs(to_double(system.rhs.closure[k])), A.closure[k]);
  if (!rows.finite) return {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::quiet_NaN()};
  const double scale = rows.matrix * rows.x_norm + rows.load;
  return {rows.componentwise, scale > 0 ? rows.residual / scale : 0.0};
}

template BackwardError backward_error(const System<double>&, const Solution<double>&);
template BackwardError backward_error(const System<long double>&, const Solution<long double>&);
template BackwardError backward_error(const System<Count>&, const Solution<Count>&);

}  // namespace lanc
