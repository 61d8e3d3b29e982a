// M̄⁻¹ of a tree by the recursion of eq. 18 on unit forces.
// Private to lib/derivatives.
#pragma once

#include <vector>

#include "lib/derivatives/coordinate_order.h"
#include "lib/derivatives/lanes.h"
#include "lib/system/system.h"

namespace lanc {

/// Eq. 18 for nv right-hand sides at once, τ = e_c for each coordinate c: leaf to root a column has a load only where
/// the path of c passes, and M̄⁻¹ is symmetric, so root to leaf only columns c ≥ k are taken along (Carpentier 2018,
/// "Analytical inverse of the joint space inertia matrix"). O(nv²), or nv · size of the largest of several trees on the
/// ground. Allocates in the constructor only. Tested by tests/derivatives/.
class MassInverse {
 public:
  MassInverse(const Model& model, const CoordinateOrder& order);

  /// M̄⁻¹, nv × nv. Not finite, or meaningless, where M̄ is singular.
  void evaluate(const System<double>& system, std::vector<double>& inverse);

 private:
  struct Freedom {
    Wrench<double> D;  // M* C / N
    double inverse;    // 1 / N, N = Cᵀ M* C + A
  };
  void inward(const System<double>& system);
  void outward(const System<double>& system, std::vector<double>& inverse);
  double* response(int k) { return rows_ + std::size_t(order_.place[k]) * order_.place.size(); }

  Model model_;
  const CoordinateOrder& order_;
  std::vector<int> slot_;  // per body: where its accelerations are while its children need them
  std::vector<ArticulatedInertia<double>> star_;
  std::vector<Freedom> freedoms_;
  AlignedRows load_;              // 6 × nv: f* of every column
  AlignedRows slots_;             // 6 × nv a slot: â of every column
  double* rows_ = nullptr;        // nv × nv by rows, in depth-first order: N⁻¹ (τ + Cᵀ f*), then M̄⁻¹
  std::vector<double> response_;  // where they are unless that is the model's own order
};

}  // namespace lanc
