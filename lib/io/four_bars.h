// Four-bar linkages in rows: closed loops of any number, with states that are assembled exactly.
#pragma once

#include "lib/io/mechanism.h"

namespace lanc {

/// What the generators of four-bars are asked for.
struct FourBarOptions {
  int loops = 1;
  double angle = 0.7, rate = 1;  // of every upright from the vertical, rad and rad/s
  double gravity = 9.81;         // m/s², downward (−z)
  int branching = 2;             // of a tree of four-bars
  /// Where loops are cut: by a point at the tip of an upright (3 rows, 1 redundant), by a hinge there (5 rows, 3
  /// redundant), or by a weld in its middle (6 rows, 3 redundant).
  enum class Cut : unsigned char { point, hinge, weld } cut = Cut::point;
};

/// N four-bars side by side: 2N + 1 rods of 1 m and 1 kg in the x–z plane, N + 1 uprights on the ground, a coupler from
/// the tip of each upright to the next, N closures.
/// Closed form of the uprights' acceleration: g ((N+1)/2 + N) sin θ / ((N+1)/3 + N), at any speed.
Mechanism four_bar_ladder(const FourBarOptions& options, const std::string& name);

/// N four-bars in series: each stands on the coupler of the one before.
Mechanism four_bar_chain(const FourBarOptions& options, const std::string& name);

/// N four-bars as a complete tree: the first on the ground, four-bar i on the coupler of four-bar (i − 2)/B + 1, B
/// being `branching`; siblings in the same place.
Mechanism four_bar_tree(const FourBarOptions& options, const std::string& name);

/// N four-bars inside one another: N + 1 uprights on the ground, 1 m apart, under one coupler of N m and 1 kg; every
/// loop holds the first upright and the coupler. Closed form of the uprights' acceleration: g ((N+1)/2 + 1) sin θ /
/// ((N+1)/3 + 1), at any speed.
Mechanism four_bar_nest(const FourBarOptions& options, const std::string& name);

/// One loop of N rods of 1 m and 1 kg (N ≥ 2), all sides but one of a regular polygon of N + 1 whose side on the ground
/// points along x; at rest. Cut at its last corner by a point or a hinge, or by a weld in the middle of the last side.
/// The angle of the options is not used. N − 2 freedoms.
Mechanism polygon(const FourBarOptions& options, const std::string& name);

/// One four-bar in the x-y plane, the ground link vertical: crank a, coupler b, rocker c, ground d. Joints beta1
/// (crank, at the origin), beta2 (coupler on crank), beta3 (rocker, at (0, d)); cut between coupler and rocker by a
/// point in the plane (rows x, y) or by a hinge (5 rows, 3 redundant). beta1 counts from +x, beta3 from −y. Rods of 1
/// kg a metre.
Model planar_four_bar(double a, double b, double c, double d, bool hinge_cut = false);

}  // namespace lanc
