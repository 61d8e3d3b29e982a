// Oracles of eq. 14 in long double: slow, short, and written without lib/system's ways of using its rows.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "lib/system/system.h"
#include "tests/support/random_model.h"

namespace lanc::test {

/// Eq. 14 written out as one dense matrix of 6×6 blocks M, B, C, solved by LU with full pivoting. 12n + n_η unknowns,
/// cubic: up to about 20 bodies.
Solution<long double> solve_eq14_naively(const System<long double>& system);

/// The non-recursive way of the lecture, with J = B⁻¹ C formed column by column: JᵀMJ η̇ = Jᵀ(f̂^tc − M ā) + τ. Cubic in
/// n_η: up to a few hundred velocities.
Solution<long double> solve_reduced_naively(const System<long double>& system);

/// The reduced system H η̇ = b of a tree, J and the accelerations at η̇ = 0 it was made from.
struct ReducedSystem {
  using Matrix = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;
  using Vector = Eigen::Matrix<long double, Eigen::Dynamic, 1>;
  Matrix J, H;
  Vector bias, b;
};
ReducedSystem reduce_naively(const System<long double>& system);
/// â and f̂ of η̇ and λ, body by body.
Solution<long double> complete_naively(const System<long double>& system, const ReducedSystem& reduced,
                                       const ReducedSystem::Vector& vdot, const ReducedSystem::Vector& lambda);

/// What answers are compared with: eq. 14 for small mechanisms, the reduced system for middle ones, and for large ones
/// a long double formulation from the register, refined until its backward error is at rounding (checked by a test).
Solution<long double> reference_solution(const Case& c);

/// Coefficients in long double at the state and under the loads of the case.
System<long double> system_in_long_double(const Case& c);

/// Largest numbers of a solution in comparable units: rotations times the model's length L, moments divided by it.
///   vdot          max |η̇_k| (× L for rotations and screws)          m/s²
///   acceleration  max of |ω̇| L and |v̇|, component by component      m/s²
///   wrench        max of |τ| / L and |f|, component by component    N
///   drive         max |drive force| (/ L for rotations and screws)  N
struct Norms {
  double vdot = 0, acceleration = 0, wrench = 0, drive = 0;
  double worst() const;
};
template <class S>
Norms norms(const Model& model, const Solution<S>& solution);

/// Norms of a − b.
template <class A, class B>
Norms difference(const Model& model, const Solution<A>& a, const Solution<B>& b);

/// Norms of the reference, raised to those of what it balances (gravity, ā^rel, f̂^tc): a mechanism in equilibrium has
/// η̇ = 0 and still a size to which rounding is relative.
Norms sizes(const System<long double>& system, const Solution<long double>& reference);

/// Component by component difference / size.
Norms relative(const Norms& difference, const Norms& size);

}  // namespace lanc::test
