// Random trees: every joint kind and everything a body or a joint may carry, yet always with a solution.
#pragma once

#include <vector>

#include "lib/io/draw.h"
#include "lib/model/spec.h"

namespace lanc {

struct RandomTreeOptions {
  int bodies = 1;
  std::vector<JointKind> kinds;  // drawn from these, each as often as it is listed
  bool massless = true;          // massless bodies and point masses
  bool driven = true;            // rheonomic joints
  bool forces = true;            // joint springs, dampers, friction, torques, armature; point springs; wrenches
};

/// Draws the specification of a tree; name and gravity are left to the caller. M̄ is positive definite at every state
/// with |q| ≤ 1: a body without full inertia moves on one freedom only and either carries a body with full inertia on
/// a joint whose axis is perpendicular (screws of two or three mutually perpendicular axes are independent), or is a
/// leaf without a freedom, with armature, or with its mass off the axis. Tested by tests/io/generators_test.cpp.
ModelSpec random_tree(const RandomTreeOptions& options, Draw& draw);

}  // namespace lanc
