// Is an answer right? What Formulation::solve() looks at; private to lib/formulation.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "lib/system/system.h"

namespace lanc::judgement {

template <class S>
bool finite(const Vec3<S>& a) {
  return std::isfinite(to_double(a.x)) && std::isfinite(to_double(a.y)) && std::isfinite(to_double(a.z));
}

/// What one sweep over an answer tells.
enum class FirstLook : unsigned char { good, suspicious, not_finite };

/// Not finite; or suspicious, because eq. 12 is violated by more than rounding explains. Digits lost in η̇ show there:
/// a formulation finds η̇ in one way and f̂ in another. About 30 operations a velocity.
template <class S>
FirstLook first_look(const System<S>& system, const Solution<S>& solution) {
  const Model& model = system.model;
  FirstLook result = FirstLook::good;
  for (const S& multiplier : solution.lambda)
    if (!std::isfinite(to_double(multiplier))) return FirstLook::not_finite;
  for (int i = 0; i < model.bodies(); ++i) {
    const Link& link = model.link(i);
    const Wrench<S>& f = solution.wrench[i];
    const Motion<S>& a = solution.acceleration[i];
    if (!finite(a.angular) || !finite(a.linear) || !finite(f.moment) || !finite(f.force)) return FirstLook::not_finite;
    // The place of a body on the ground enters no equation: the answer may be finite where the state is not.
    if (link.parent == ground && !finite(system.bodies[i].r)) return FirstLook::not_finite;
    // Rounding errors of f̂ are relative to what it is made of: a free body's is zero, its load is not.
    const Wrench<S>& load = system.rhs.force[i];
    double noise = 0;
    for (const Vec3<S>& part : {f.moment, f.force, load.moment, load.force})
      noise = std::max({noise, std::abs(to_double(part.x)), std::abs(to_double(part.y)), std::abs(to_double(part.z))});
    for (int k = link.v; k < link.v + link.nv; ++k) {
      const Motion<S>& C = system.columns[k];
      const double parts[] = {
          to_double(C.angular.x) * to_double(f.moment.x), to_double(C.angular.y) * to_double(f.moment.y),
          to_double(C.angular.z) * to_double(f.moment.z), to_double(C.linear.x) * to_double(f.force.x),
          to_double(C.linear.y) * to_double(f.force.y),   to_double(C.linear.z) * to_double(f.force.z)};
      const double vdot = to_double(solution.vdot[k]), tau = to_double(system.rhs.tau[k]);
      if (!std::isfinite(vdot)) return FirstLook::not_finite;
      const double inertial = model.armature()[k] * vdot;
      double sum = inertial - tau, size = std::abs(inertial) + std::abs(tau);
      for (const double part : parts) sum += part, size += std::abs(part);
      if (!(std::abs(sum) <= 1e-9 * size + 1e-12 * noise)) result = FirstLook::suspicious;
    }
  }
  return result;
}

/// How large the quantities of an answer are, in two units: m/s² and N. Rotations are taken times the model's length,
/// moments divided by it.
struct Sizes {
  double acceleration = 0, wrench = 0;

  template <class S>
  Sizes(const Model& model, const Solution<S>& solution) {
    const double L = model.length();
    for (int k = 0; k < model.nv(); ++k)
      grow(acceleration, to_double(solution.vdot[k]) * (model.column_kind(k) == ColumnKind::translation ? 1 : L));
    for (const Motion<S>& a : solution.acceleration) grow(acceleration, a.angular, L), grow(acceleration, a.linear, 1);
    for (const Wrench<S>& f : solution.wrench) grow(wrench, f.moment, 1 / L), grow(wrench, f.force, 1);
  }

  /// Raised to the sizes of what the answer balances: an equilibrium has η̇ = 0 and still a size.
  template <class S>
  void include_loads(const System<S>& system) {
    const Model& model = system.model;
    const double L = model.length();
    double mass = 0, load = 0;
    for (const Link& link : model.links()) mass = std::max(mass, link.inertia.mass);
    for (const Motion<S>& a : system.rhs.bias) grow(acceleration, a.angular, L), grow(acceleration, a.linear, 1);
    for (const Wrench<S>& f : system.rhs.force) grow(load, f.moment, 1 / L), grow(load, f.force, 1);
    for (int k = 0; k < model.nv(); ++k)
      grow(load, to_double(system.rhs.tau[k]) / (model.column_kind(k) == ColumnKind::translation ? 1 : L));
    grow(wrench, load);
    if (mass > 0) grow(acceleration, load / mass);
  }

 private:
  static void grow(double& largest, double x) {
    if (!(std::abs(x) <= largest)) largest = std::abs(x);  // a NaN enters and stays
  }
  template <class S>
  static void grow(double& largest, const Vec3<S>& a, double unit) {
    for (const S& x : {a.x, a.y, a.z}) grow(largest, to_double(x) * unit);
  }
};

/// Change relative to size, the larger of the two kinds; infinite when it is not a number.
inline double relative(const Sizes& change, const Sizes& size) {
  const auto ratio = [](double c, double s) {
    const double r = c == 0 ? 0 : c / s;
    return std::isnan(r) ? std::numeric_limits<double>::infinity() : r;
  };
  return std::max(ratio(change.acceleration, size.acceleration), ratio(change.wrench, size.wrench));
}

}  // namespace lanc::judgement
