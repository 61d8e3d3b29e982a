// What is certain about singular inertias from the model alone, for formulations that divide by M_i or M*_i.
#pragma once

#include "lib/model/model.h"

namespace lanc {

/// Rank of the spatial inertia M_i: 6, 5 for an infinitely slender rod, 3 for a point mass, 0 for a massless body.
int inertia_rank(const Model& model, int body);

/// Upper bound of the rank of every articulated inertia M*_i, in every state: the rank of M_i and, of each child, the
/// rank of its M* less its freedoms without armature (eq. 18 releases them), at most 6. O(n).
std::vector<int> articulated_rank_bound(const Model& model);

}  // namespace lanc
