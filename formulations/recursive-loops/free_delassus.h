// A scale for pivots of closure rows that no state and no cancellation can spoil.
#pragma once

#include <vector>

#include "lib/model/model.h"

namespace lanc {

/// Per closure row about the diagonal entry of G_s M⁻¹ G_sᵀ, were the bodies it acts on free: 1/m + d²/(½ tr J_c) where
/// the row is a length, at a distance d from the centre of mass; 1/(½ tr J_c) where it is an angle; of couplers Σ
/// factor² of the like. From mass and trace alone, so that a rod of no thickness has a finite one. Masses below a
/// hundredth of the mean and radii of gyration below a tenth of the model's length count as these: bodies without
/// inertia are no scale, and where light ones do move more, S_rr itself is the larger number.
std::vector<double> free_delassus_diagonal(const Model& model);

}  // namespace lanc
