// Our model as text that MuJoCo reads. Private to the peer in mujoco.cpp.
#pragma once

#include <string>

#include "lib/model/model.h"

namespace lanc::peers {

/// MJCF for models whose tree is not deep (the XML parser takes 100 levels), URDF, which is flat, for deeper ones.
/// Bodies are called b0, b1, ... in our order, joints j0, j1, ...; closures are equality constraints in our order, as
/// hard as MuJoCo makes them (impedance 0.9999). Throws InputError naming what URDF cannot say.
std::string mujoco_xml(const Model& model);

}  // namespace lanc::peers
