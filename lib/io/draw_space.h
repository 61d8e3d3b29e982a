// Random vectors, rotations, bodies, motions and states, for the generators. Private to lib/io.
#pragma once

#include "lib/io/draw.h"
#include "lib/model/model.h"

namespace lanc {

/// Every component uniform in [−size, size].
Eigen::Vector3d draw_vector(Draw& draw, double size);
Eigen::Vector3d draw_direction(Draw& draw);
Eigen::Matrix3d draw_rotation(Draw& draw);
/// a × b of perpendicular unit vectors.
Eigen::Vector3d across(const Eigen::Vector3d& a, const Eigen::Vector3d& b);
/// Some unit vector perpendicular to the unit vector `a`.
Eigen::Vector3d draw_perpendicular(Draw& draw, const Eigen::Vector3d& a);
/// 0.5 to 2 kg, the tensor that of a homogeneous box in any orientation.
BodySpec draw_body(Draw& draw);
Eigen::Matrix3d draw_inertia(Draw& draw, double mass);
/// Any of the five kinds of prescribed motion, moderate for |t| ≤ 2.
MotionSpec draw_motion(Draw& draw);
/// q and v uniform in [−1, 1], Euler parameters uniform on the sphere, t = 0.
State<double> draw_state(const Model& model, Draw& draw);

}  // namespace lanc
