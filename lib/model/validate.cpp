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

/// A negative stiffness is met in nature (a buckled beam, a magnet), a negative damper is not.
constexpr const char* mend_of_damping =
    "would feed energy in; give zero or a positive value, and what drives as an applied force";

void validate_coordinate(const JointSpec& joint, const CoordinateSpec& c, const std::string& who) {
  const double numbers[] = {c.stiffness,         c.rest,           c.damping, c.friction_positive,
                            c.friction_negative, c.friction_speed, c.torque,  c.armature};
  for (const double x : numbers)
    require_finite(joint.place, who + ": a spring, damper, friction, torque or armature value", scalar(x));
  if (c.armature < 0) fail(joint.place, who + ": negative armature; a rotor inertia is zero or positive");
  if (c.damping < 0) fail(joint.place, fmt::format("{}: negative damping {:.6g} {}", who, c.damping, mend_of_damping));
  if (c.friction_positive < 0 || c.friction_negative < 0)
    fail(joint.place, who + ": negative friction; give its magnitude for either direction");
  if (!(c.friction_speed > 0))
    fail(joint.place, who + ": friction_speed must be positive; it smooths the step at rest");
  if (!joint.kind.traits().rates_are_velocities() && (c.stiffness != 0 || c.rest != 0))
    fail(joint.place, who + ": a joint with Euler parameters takes no coordinate spring; use a point spring instead");
}

/// Right-handed axes with z along `axis` and x along `axis2`, where the kind takes them.
Eigen::Matrix3d axes_along(const Place& place, const std::string& who, std::string_view kind, JointAxes takes,
                           const std::optional<Eigen::Vector3d>& axis, const std::optional<Eigen::Vector3d>& axis2) {
  if (takes == JointAxes::none && (axis || axis2))
    fail(place, fmt::format("{}: a {} joint has no axis; remove it", who, kind));
  if (takes == JointAxes::one && axis2)
    fail(place, fmt::format("{}: a {} joint has one axis; remove axis2", who, kind));

  const auto unit = [&](const std::optional<Eigen::Vector3d>& given, const Eigen::Vector3d& preset, const char* key) {
    if (!given) return preset;
    require_finite(place, who + ": " + key, *given);
    const double largest = given->cwiseAbs().maxCoeff();
    if (largest == 0) fail(place, fmt::format("{}: {} is zero; give a direction, for example [0, 0, 1]", who, key));
    const Eigen::Vector3d scaled = *given / largest;  // survives axes of 1e-200 or 1e200
    return Eigen::Vector3d(scaled / scaled.norm());
  };
  const Eigen::Vector3d z = unit(axis, Eigen::Vector3d::UnitZ(), "axis");
  // Without a second axis: the coordinate axis least along z, made perpendicular; exactly x for z = (0, 0, 1). Where x
  // has no meaning of its own, of two as good the one that follows z, so that coordinate axes are only renamed.
  int most = 0;
  if (takes == JointAxes::one) z.cwiseAbs().maxCoeff(&most);
  const int first = takes == JointAxes::one ? (most + 1) % 3 : 0;
  int least = first;
  for (const int k : {(first + 1) % 3, (first + 2) % 3})
    if (std::abs(z[k]) < std::abs(z[least])) least = k;
  const Eigen::Vector3d preset = (Eigen::Vector3d::Unit(least) - z * z[least]).normalized();
  const Eigen::Vector3d x = unit(axis2, preset, "axis2");
  if (std::abs(x.dot(z)) > 1e-9)
    fail(place, fmt::format("{}: axis2 is not perpendicular to axis (cosine {:.3g})", who, x.dot(z)));
  Eigen::Matrix3d axes;
  axes << x, z.cross(x), z;
  return axes;
}

void require_rotation(const Place& place, const std::string& who, const Eigen::Matrix3d& R) {
  if ((R.transpose() * R - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() > 1e-9 || R.determinant() < 0)
    fail(place, who + ": the frame's rotation is not a rotation; its columns must be right-handed unit axes");
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
  require_rotation(joint.place, who, joint.frame.rotation);
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
  const JointTraits& traits = joint.kind.traits();
  return axes_along(joint.place, "joint '" + joint.name + "'", traits.name, traits.axes, joint.axis, joint.axis2);
}

Eigen::Matrix3d closure_axes(const ClosureSpec& closure) {
  const ClosureTraits& traits = closure.kind.traits();
  return axes_along(closure.place, "closure '" + closure.name + "'", traits.name, traits.axes, closure.axis,
                    closure.axis2);
}

void validate(const PointSpringSpec& spring) {
  const std::string who = "spring '" + spring.name + "'";
  if (spring.name.empty()) fail(spring.place, "a spring has no name; add name = \"...\"");
  require_finite(spring.place, who + ": point_a", spring.point_a);
  require_finite(spring.place, who + ": point_b", spring.point_b);
  for (const double x : {spring.stiffness, spring.damping, spring.rest_length})
    require_finite(spring.place, who + ": stiffness, damping or rest length", scalar(x));
  if (spring.damping < 0)
    fail(spring.place, fmt::format("{}: negative damping {:.6g} {}", who, spring.damping, mend_of_damping));
  if (spring.rest_length < 0) fail(spring.place, who + ": negative rest length");
  if (spring.body_a == spring.body_b) fail(spring.place, who + ": both ends are on the same body; connect two bodies");
}

void validate(const WrenchSpec& wrench) {
  require_finite(wrench.place, "wrench on '" + wrench.body + "': moment", wrench.moment);
  require_finite(wrench.place, "wrench on '" + wrench.body + "': force", wrench.force);
}

void validate(const ClosureSpec& closure) {
  if (closure.name.empty()) fail(closure.place, "a closure has no name; add name = \"...\"");
  const std::string who = "closure '" + closure.name + "'";
  const ClosureTraits& traits = closure.kind.traits();
  for (const Placement* frame : {&closure.frame_a, &closure.frame_b}) {
    require_finite(closure.place, who + ": frame", frame->rotation);
    require_finite(closure.place, who + ": position", frame->position);
    require_rotation(closure.place, who, frame->rotation);
  }
  closure_axes(closure);
  if (closure.body_a == closure.body_b)
    fail(closure.place, fmt::format("{}: it connects '{}' to itself; a loop needs two bodies, or a body and ground",
                                    who, closure.body_a.empty() ? "ground" : closure.body_a));
  require_finite(closure.place, who + ": pitch", scalar(closure.pitch));
  require_finite(closure.place, who + ": length", scalar(closure.length));
  if (closure.pitch != 0 && !traits.has_pitch)
    fail(closure.place, fmt::format("{}: a {} closure has no pitch; remove it", who, traits.name));
  if (closure.pitch == 0 && traits.has_pitch && !closure.motion)
    fail(closure.place, fmt::format("{}: the pitch is zero; give one in m/rad, or make the closure revolute", who));
  if (closure.length != 0 && (!traits.has_length || closure.motion))
    fail(closure.place, fmt::format("{}: {} takes no length; remove it", who,
                                    traits.has_length ? "a prescribed distance" : std::string(traits.name)));
  if (traits.has_length && !closure.motion && !(closure.length > 0))
    fail(closure.place,
         fmt::format("{}: the length must be positive; use point-on-point to bring two points together", who));
  if (closure.motion && !traits.can_be_driven())
    fail(closure.place, fmt::format("{}: the motion of a {} closure cannot be prescribed; only that of a joint with "
                                    "one freedom, or a distance",
                                    who, traits.name));
}

void validate(const CouplerSpec& coupler) {
  if (coupler.name.empty()) fail(coupler.place, "a coupler has no name; add name = \"...\"");
  const std::string who = "coupler '" + coupler.name + "'";
  if (coupler.terms.empty()) fail(coupler.place, who + ": it couples nothing; name coordinates and factors");
  require_finite(coupler.place, who + ": offset", scalar(coupler.offset));
  for (const CouplerSpec::Term& term : coupler.terms) {
    require_finite(coupler.place, who + ": a factor", scalar(term.factor));
    if (term.factor == 0)
      fail(coupler.place, fmt::format("{}: the factor of joint '{}' is zero; remove the term", who, term.joint));
  }
}

}  // namespace lanc
