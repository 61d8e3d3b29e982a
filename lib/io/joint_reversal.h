// The same joint seen from its other body.
#pragma once

#include "lib/model/spec.h"

namespace lanc {

/// The coordinates of a joint change when it is reversed: universal, planar, spherical, free. Others keep them, because
/// their axis is turned round.
bool reversal_changes_coordinates(JointKind kind);

/// The joint from `joint.body` to `joint.parent`; `frame_b` is its frame on `joint.body`. Exactly the same joint, with
/// the same forces and limits, in other coordinates:
///   fixed, revolute, prismatic, helical, cylindrical   the same, about the axis turned round
///   universal   first and second angle exchanged, about axes exchanged and turned round
///   planar      angle the same, normal and x turned round; x and y of a's origin, seen from b
///   spherical, free   the inverse displacement; velocities of a against b, in axes of a
/// Throws InputError for forces and limits without a counterpart: of x and y of a planar joint, of a free joint, and
/// those of a spherical joint that are not the same about all axes.
JointSpec reversed(const JointSpec& joint, const Placement& frame_b);

/// Coordinates and velocities of a joint into those of the reversed one; the inverse of itself. Euler parameters must
/// be normalised. Tested by tests/io/joint_reversal_test.cpp.
void reverse_coordinates(JointKind kind, double* q, double* v);

/// The coordinate of the reversed joint that equals coordinate k of the joint, or −1.
int reversed_coordinate(JointKind kind, int k);

}  // namespace lanc
