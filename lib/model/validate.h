// Checks of single items of a specification; each throws InputError with place, thing and mend.
#pragma once

#include "lib/model/spec.h"

namespace lanc {

void validate(const BodySpec& body);
void validate(const JointSpec& joint);
void validate(const PointSpringSpec& spring);
void validate(const WrenchSpec& wrench);
void validate(const ClosureSpec& closure);
void validate(const CouplerSpec& coupler);

/// Axes of the joint, z along `axis` and x along `axis2`, in the joint frame of the specification.
Eigen::Matrix3d joint_axes(const JointSpec& joint);
/// The same for the frames A and B of a closure.
Eigen::Matrix3d closure_axes(const ClosureSpec& closure);

}  // namespace lanc
