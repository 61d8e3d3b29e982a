#pragma once

#include "lib/formulation/eq14_formulation.h"
#include "lib/solve/cholmod.h"

namespace lanc {

/// Eq. 14 by LDLᵀ without pivoting, bodies leaf to root and (â, f̂, η̇) inside a body: every pivot differs from zero if
/// every M*_i is regular, and the block pivots are M*_i, −(M*_i)⁻¹ and N_i (tests/formulations/pivots_test.cpp). It
/// divides by M*_i; factorise() objects where that loses more than half of the digits.
class Eq14Cholmod final : public Eq14Formulation {
 public:
  explicit Eq14Cholmod(const Model& model, BodyOrder bodies = BodyOrder::leaf_to_root);

  Outcome factorise(const System<double>& system) override;

  /// L and D of the last factorisation, in the order of matrix().
  LdlFactors factors() const { return static_cast<const CholmodSolver&>(solver()).factors(); }

 private:
  double digits_left(int body) const;
  Outcome judged_closures() const;
};

}  // namespace lanc
