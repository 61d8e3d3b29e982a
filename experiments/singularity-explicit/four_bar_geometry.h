// Closed forms of the planar four-bar, by its triangles.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "lib/model/model.h"

namespace lanc {

/// Crank a, coupler b, rocker c, ground d, as planar_four_bar (lib/io/four_bars.h) takes them.
struct FourBarLengths {
  double a, b, c, d;
};

/// An extreme point of β1 or β3, where two links are in line.
struct ExtremePoint {
  int coordinate;       // 0: β1, 2: β3
  std::string in_line;  // "coupler+rocker" stretched, "coupler-rocker" folded
  double beta1, beta3;  // rad
};

/// A closed position, rather with the links stretched. Throws InputError when the links cannot be joined.
State<double> some_closed_position(const FourBarLengths& lengths);

/// The extreme point nearest to a position, both mirror images considered.
std::optional<ExtremePoint> nearest_extreme(const FourBarLengths& lengths, int coordinate, double beta1, double beta3);

}  // namespace lanc
