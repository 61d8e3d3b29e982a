// How the bodies of a mechanism move, told so that it does not depend on the joints that carry them.
#pragma once

#include <map>
#include <string>

#include "lib/model/model.h"

namespace lanc::test {

/// Of a body: its centre of mass and its turning, in world axes.
struct WorldMotion {
  Eigen::Vector3d com, velocity, acceleration, omega, alpha;
};

/// All bodies by name, with the accelerations of formulation `dense`, which must have an answer.
std::map<std::string, WorldMotion> motion_of_bodies(const Model& model, const State<double>& state);

/// Equal to `relative` of the largest velocity and acceleration (at least 1 m/s, 1 m/s²), and of 1 m.
void expect_same_motion(const std::map<std::string, WorldMotion>& a, const std::map<std::string, WorldMotion>& b,
                        double relative);

/// One placement after another, and the way back.
Placement operator*(const Placement& outer, const Placement& inner);
Placement inverse(const Placement& p);

}  // namespace lanc::test
