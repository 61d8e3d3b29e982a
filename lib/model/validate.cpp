#include "lib/model/validate.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

namespace lanc {
namespace {

[[noreturn]] void fail(const Place& place, const std::string& what) { throw InputError(place, what); }

void require_finite(const Place& place, const std::string& thing, const Eigen::Ref<const Eigen::MatrixXd>& values) {
  if (!values.allFinite()) fail(place, thing + " is not a finite number; write a plain decimal value in SI units");
}

Eigen::Matrix<double, 1, 1> scalar(double x) { return Eigen::Matrix<double, 1, 1>(x); }

void validate_inertia(const BodySpec& body, const std::string& who) {
  const Eigen::Matrix3d& I = body.inertia;
  const double scale = I.cwiseAbs().maxCoeff();
  if ((I - I.transpose()).cwiseAbs().maxCoeff() > 1e-12 * scale)
    fail(body.place, who + ": the inertia matrix is not symmetric; give the tensor about the centre of mass");
  if (body.allow_nonphysical_inertia) return;
  const char* mend = "; mend the value (kg m², about the centre of mass) or set allow_nonphysical_inertia = true";
  if (body.mass == 0 && scale > 0) fail(body.place, who + ": inertia without mass" + mend);
  const Eigen::Vector3d e = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(I, Eigen::EigenvaluesOnly).eigenvalues();
  if (e[0] < -1e-12 * scale)
    fail(body.place, fmt::format("{}: the inertia has the negative principal value {:.6g} kg m²{}", who, e[0], mend));
  if (e[0] + e[1] < e[2] * (1 - 1e-9))
    fail(body.place, fmt::format("{}: the principal inertias {:.6g}, {:.6g}, {:.6g} violate the triangle inequality{}",
                                 who, e[0], e[1], e[2], mend));
}

void validate_coordinate(const JointSpec& joint, const CoordinateSpec& c, const std::string& who) {
  const double numbers[] = {c.stiffness,         c.rest,           c.damping, c.friction_positive,
                            c.friction_negative, c.friction_speed, c.torque,  c.armature};
  for (const double x : numbers)
    require_finite(joint.place, who + ": a spring, damper, friction, torque or armature value", scalar(x));
  if (c.armature < 0) fail(joint.place, who + ": negative armature; a rotor inertia is zero or positive");
  if (c.friction_positive < 0 || c.friction_negative < 0)
    fail(joint.place, who + ": negative friction; give its magnitude for either direction");
  if (!(c.friction_speed > 0))
    fail(joint.place, who + ": friction_speed must be positive; it smooths the step at rest");
  if (!joint.kind.traits().rates_are_velocities() && (c.stiffness != 0 || c.rest != 0))
    fail(joint.place, who + ": a joint with Euler parameters takes no coordinate spring; use a point spring instead");
}

}  // namespace

void validate(const BodySpec& body) {
  if (body.name.empty()) fail(body.place, "a body has no name; add name = \"...\"");
  const std::string who = "body '" + body.name + "'";
  require_finite(body.place, who + ": mass", scalar(body.mass));
  require_finite(body.place, who + ": centre of mass", body.com);
  require_finite(body.place, who + ": inertia", body.inertia);
  if (body.mass < 0)
    fail(body.place, fmt::format("{}: negative mass {:.6g} kg; a mass is zero or positive", who, body.mass));
  validate_inertia(body, who);
}

void validate(const JointSpec& joint) {
  if (joint.name.empty()) fail(joint.place, "a joint has no name; add name = \"...\"");
  const std::string who = "joint '" + joint.name + "'";
  const JointTraits& traits = joint.kind.traits();
  require_finite(joint.place, who + ": frame", joint.frame.rotation);
  require_finite(joint.place, who + ": position", joint.frame.position);
  const Eigen::Matrix3d& R = joint.frame.rotation;
  if ((R.transpose() * R - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() > 1e-9 || R.determinant() < 0)
    fail(joint.place, who + ": the frame's rotation is not a rotation; its columns must be right-handed unit axes");
  joint_axes(joint);
  require_finite(joint.place, who + ": pitch", scalar(joint.pitch));
  if (joint.pitch != 0 && !traits.has_pitch)
    fail(joint.place,
         fmt::format("{}: a {} joint has no pitch; remove it or make the joint helical", who, traits.name));
  if (joint.motion && traits.nv != 1)
    fail(joint.place,
         fmt::format("{}: the motion of a {} joint ({} freedoms) cannot be prescribed; only that of a joint "
                     "with one freedom can",
                     who, traits.name, traits.nv));
  if (!joint.coordinates.empty() && static_cast<int>(joint.coordinates.size()) != traits.nv)
    fail(joint.place,
         fmt::format("{}: {} coordinate entries for {} velocities", who, joint.coordinates.size(), traits.nv));
  for (const CoordinateSpec& c : joint.coordinates) validate_coordinate(joint, c, who);
  if (!joint.limits.empty() && static_cast<int>(joint.limits.size()) != traits.nq)
    fail(joint.place, fmt::format("{}: {} limits for {} position coordinates", who, joint.limits.size(), traits.nq));
  for (const auto& limit : joint.limits)
    if (limit && !(limit->lower <= limit->upper))
      fail(joint.place, fmt::format("{}: limit [{:.6g}, {:.6g}] is empty; lower must not exceed upper", who,
                                    limit->lower, limit->upper));
}

Eigen::Matrix3d joint_axes(const JointSpec& joint) {
  const std::string who = "joint '" + joint.name + "'";
  const JointTraits& traits = joint.kind.traits();
  if (traits.axes == JointAxes::none && (joint.axis || joint.axis2))
    fail(joint.place, fmt::format("{}: a {} joint has no axis; remove it", who, traits.name));
  if (traits.axes == JointAxes::one && joint.axis2)
    fail(joint.place, fmt::format("{}: a {} joint has one axis; remove axis2", who, traits.name));

  const auto unit = [&](const std::optional<Eigen::Vector3d>& axis, const Eigen::Vector3d& preset, const char* key) {
    if (!axis) return preset;
    require_finite(joint.place, who + ": " + key, *axis);
    const double largest = axis->cwiseAbs().maxCoeff();
    if (largest == 0)
      fail(joint.place, fmt::format("{}: {} is zero; give a direction, for example [0, 0, 1]", who, key));
    const Eigen::Vector3d scaled = *axis / largest;  // survives axes of 1e-200 or 1e200
    return Eigen::Vector3d(scaled / scaled.norm());
  };
  const Eigen::Vector3d z = unit(joint.axis, Eigen::Vector3d::UnitZ(), "axis");
  // Without a second axis: the coordinate axis least along z, made perpendicular; exactly x for z = (0, 0, 1).
  int least = 0;
  if (std::abs(z.y()) < std::abs(z[least])) least = 1;
  if (std::abs(z.z()) < std::abs(z[least])) least = 2;
  const Eigen::Vector3d preset = (Eigen::Vector3d::Unit(least) - z * z[least]).normalized();
  const Eigen::Vector3d x = unit(joint.axis2, preset, "axis2");
  if (std::abs(x.dot(z)) > 1e-9)
    fail(joint.place, fmt::format("{}: axis2 is not perpendicular to axis (cosine {:.3g})", who, x.dot(z)));
  Eigen::Matrix3d axes;
  axes << x, z.cross(x), z;
  return axes;
}

void validate(const PointSpringSpec& spring) {
  const std::string who = "spring '" + spring.name + "'";
  if (spring.name.empty()) fail(spring.place, "a spring has no name; add name = \"...\"");
  require_finite(spring.place, who + ": point_a", spring.point_a);
  require_finite(spring.place, who + ": point_b", spring.point_b);
  for (const double x : {spring.stiffness, spring.damping, spring.rest_length})
    require_finite(spring.place, who + ": stiffness, damping or rest length", scalar(x));
  if (spring.rest_length < 0) fail(spring.place, who + ": negative rest length");
  if (spring.body_a == spring.body_b) fail(spring.place, who + ": both ends are on the same body; connect two bodies");
}

void validate(const WrenchSpec& wrench) {
  require_finite(wrench.place, "wrench on '" + wrench.body + "': moment", wrench.moment);
  require_finite(wrench.place, "wrench on '" + wrench.body + "': force", wrench.force);
}

}  // namespace lanc
