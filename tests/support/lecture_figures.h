// The two mechanisms of the lecture's figures: planar four-bars, ground link vertical.
#pragma once

#include "lib/model/model.h"

namespace lanc::test {

/// Crank a, coupler b, rocker c, ground d: joints J1 (β1, crank), J2 (β2, coupler on crank), J3 (β3, rocker, on ground
/// at (0, d)), cut between coupler and rocker by a point in the plane (rows x, y) or by a hinge (5 rows). β1 counts
/// from +x, β3 from −y. Rods of 1 kg a metre.
Model planar_four_bar(double a, double b, double c, double d, bool hinge_cut = false);

}  // namespace lanc::test
