// Closed forms of the parallelogram: crank and rocker a, coupler and ground d (lib/io/four_bars.h, planar_four_bar).
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace lanc {

/// A position where all links are in line: β1, β2, β3 in rad.
using Position = Eigen::Vector3d;

/// β3 on the antiparallel branch, tan(β3/2) = (a−d)/(a+d) cot((90° − β1)/2); −π < β3 <= π.
double antiparallel_beta3(double a, double d, double beta1);

/// The name of the branch on which all these positions lie: "parallel", "antiparallel"; of a rhombus, whose
/// antiparallel branch falls into two lines, "beta1-fixed" and "beta3-fixed".
std::string branch_name(const std::vector<std::vector<double>>& positions);

/// A crossing with the tangents of its branches, by name, of length 1 in rad.
struct Crossing {
  Position position;
  std::vector<std::pair<std::string, Eigen::Vector3d>> tangents;
};
/// Two for a parallelogram; three for a rhombus.
std::vector<Crossing> crossings(double a, double d);

}  // namespace lanc
