// Is an answer right? What Formulation::solve() and batches look at.
// Private to lib/formulation.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "lib/system/system.h"

namespace lanc::judgement {

/// What answers are looked at in: a number that can be compared, or a pack of them.
template <class S>
auto plain(const S& x) {
  if constexpr (requires { S::lanes; })
    return x;
  else
    return to_double(x);
}
template <class S>
using Real = decltype(plain(S(0.0)));

/// The larger one; b where it is NaN.
inline double larger(double a, double b) { return a > b ? a : b; }
inline double magnitude(double a) { return std::abs(a); }

inline bool vanishes(double a) { return a == 0; }

template <class S>
[[gnu::always_inline]] inline Real<S> sum_of_magnitudes(const Vec3<S>& a) {
  return magnitude(plain(a.x)) + magnitude(plain(a.y)) + magnitude(plain(a.z));
}
template <class S>
[[gnu::always_inline]] inline Real<S> sum_of_magnitudes(const Wrench<S>& f) {
  return sum_of_magnitudes(f.moment) + sum_of_magnitudes(f.force);
}

/// The sum of the magnitudes of what a wrench f on body i is made of: its numbers; where the body is free f̂^tc and M_i
/// â_i all but cancel, and those of its load count, too.
template <class S>
[[gnu::always_inline]] inline Real<S> made_of(const System<S>& system, int i, const Wrench<S>& f) {
  Real<S> sum = sum_of_magnitudes(f);
  if (system.model.link(i).nv == 6) sum += sum_of_magnitudes(system.rhs.force[i]);
  return sum;
}

/// By how much eq. 12 is violated, summed over the velocities, beyond what rounding explains: 1e-9 of its terms, and
/// 1e-12 of noise(f̂, load, made_of), the numbers that f̂ is made of; `made_of`: the sum of their magnitudes.
template <class S, class Noise>
class ViolationOfEq12 {
 public:
  using Real = judgement::Real<S>;
  ViolationOfEq12(const System<S>& system, const Solution<S>& solution, Noise noise)
      : system_(system), solution_(solution), noise_(noise) {}

  const Real& excess() const { return excess_; }

  /// The rows of body i, f̂ of which is not finite where its acceleration is not.
  [[gnu::always_inline]] void add_body(int i, const Wrench<S>& f, const Real& made_of) {
    const Model& model = system_.model;
    const Link& link = model.link(i);
    // The place of a body on the ground enters no equation: the answer may be finite where the state is not.
    if (link.parent == ground) excess_ += sum_of_magnitudes(system_.bodies[i].r) * Real(0.0);
    excess_ += made_of * Real(0.0);
    for (int k = link.v; k < link.v + link.nv; ++k) {
      const ColumnKind kind = model.column_kind(k);
      const Motion<S>& C = system_.columns[k];
      const Real tau = plain(system_.rhs.tau[k]);
      Real sum = -tau, size = magnitude(tau);
      const auto add = [&](const Real& part) __attribute__((always_inline)) { sum += part, size += magnitude(part); };
      const auto add_power = [&](const Vec3<S>& c, const Vec3<S>& w) __attribute__((always_inline)) {
        add(plain(c.x) * plain(w.x)), add(plain(c.y) * plain(w.y)), add(plain(c.z) * plain(w.z));
      };
      const Real vdot = plain(solution_.vdot[k]);
      excess_ += vdot * Real(0.0);
      if (model.has_armature()) add(Real(model.armature()[k]) * vdot);
      if (kind != ColumnKind::translation) add_power(C.angular, f.moment);
      if (kind != ColumnKind::rotation) add_power(C.linear, f.force);
      const Real violation =
          magnitude(sum) - Real(1e-9) * size - Real(1e-12) * noise_(f, system_.rhs.force[i], made_of);
      excess_ += larger(Real(0.0), violation);  // in this order NaN stays
    }
  }

 private:
  const System<S>& system_;
  const Solution<S>& solution_;
  Noise noise_;
  Real excess_{0.0};
};

/// Rounding errors of f̂ are relative to the largest number it is made of: a free body's is zero, its load is not.
/// Mostly the mean of these is enough.
struct MeanNumber {
  template <class S, class Real>
  [[gnu::always_inline]] Real operator()(const Wrench<S>&, const Wrench<S>&, const Real& sum) const {
    return sum * Real(1.0 / 12);
  }
};
struct LargestNumber {
  template <class S, class Real>
  Real operator()(const Wrench<S>& f, const Wrench<S>& load, const Real&) const {
    Real largest(0.0);
    for (const Vec3<S>* part : {&f.moment, &f.force, &load.moment, &load.force})
      for (const S* x : {&part->x, &part->y, &part->z}) largest = larger(largest, magnitude(plain(*x)));
    return largest;
  }
};

/// Digits lost in η̇ show in eq. 12: a formulation finds η̇ in one way and f̂ in another. By how much it is violated: 0
/// for a good answer; NaN where something in it is not finite, which no number survives: 0 · NaN and 0 · ∞ are NaN.
/// Lane by lane on packs. About 20 operations a velocity. Tested by tests/contract/judgement_test.cpp.
template <class S>
Real<S> first_look(const System<S>& system, const Solution<S>& solution) {
  const auto look = [&](auto noise) {
    ViolationOfEq12<S, decltype(noise)> violation(system, solution, noise);
    for (int i = 0; i < system.model.bodies(); ++i)
      violation.add_body(i, solution.wrench[i], made_of(system, i, solution.wrench[i]));
    return violation.excess();
  };
  Real<S> excess = look(MeanNumber{});
  if (!vanishes(excess)) excess = look(LargestNumber{});
  for (const S& multiplier : solution.lambda) excess += plain(multiplier) * Real<S>(0.0);
  return excess;
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
