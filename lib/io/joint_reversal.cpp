#include "lib/io/joint_reversal.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "lib/io/text.h"
#include "lib/model/validate.h"

namespace lanc {
namespace {

using joints::Free, joints::Planar, joints::Spherical, joints::Universal;

template <class Joint>
bool is(JointKind kind) {
  return &kind.traits() == &Joint::traits;
}

bool acts(const CoordinateSpec& c) {
  return c.stiffness != 0 || c.damping != 0 || c.friction_positive != 0 || c.friction_negative != 0 || c.torque != 0 ||
         c.armature != 0;
}

[[noreturn]] void no_counterpart(const JointSpec& joint, const std::string& what) {
  const auto name = [](const std::string& body) { return body.empty() ? std::string("ground") : in_quotes(body); };
  throw InputError(
      joint.place,
      fmt::format("joint {}: in the tree {} hangs on {}, and {} cannot be told from there; exchange body_a "
                  "and body_b, their positions and orientations",
                  in_quotes(joint.name), name(joint.parent), name(joint.body), what));
}

/// Planar: what acts on the angle stays, x and y are mixed.
void reverse_planar(JointSpec& joint) {
  for (std::size_t k = 0; k < joint.coordinates.size() && k < 2; ++k)
    if (acts(joint.coordinates[k])) no_counterpart(joint, "what acts along x or y");
  for (std::size_t k = 0; k < joint.limits.size() && k < 2; ++k)
    if (joint.limits[k]) no_counterpart(joint, "a limit of x or y");
}

/// Spherical: ω of the reversed joint is −ω in other axes, so that only what is the same about all axes stays.
void reverse_spherical(JointSpec& joint) {
  for (const CoordinateSpec& c : joint.coordinates) {
    const CoordinateSpec& first = joint.coordinates[0];
    if (c.friction_positive != 0 || c.friction_negative != 0 || c.torque != 0 || c.damping != first.damping ||
        c.armature != first.armature)
      no_counterpart(joint, "friction, torque, or damping and armature that differ between axes");
  }
  for (std::size_t k = 1; k < joint.limits.size(); ++k)
    if (joint.limits[k]) joint.limits[k] = LimitSpec{-joint.limits[k]->upper, -joint.limits[k]->lower};
}

void reverse_free(const JointSpec& joint) {
  if (std::any_of(joint.coordinates.begin(), joint.coordinates.end(), acts))
    no_counterpart(joint, "what acts along or about its axes");
  for (const auto& limit : joint.limits)
    if (limit) no_counterpart(joint, "a limit");
}

void reverse_planar(double* q, double* v) {
  const double c = std::cos(q[2]), s = std::sin(q[2]);
  const double x = c * q[0] + s * q[1], y = s * q[0] - c * q[1];
  const double vx = c * v[0] + s * v[1] - y * v[2], vy = s * v[0] - c * v[1] + x * v[2];
  q[0] = x, q[1] = y;
  v[0] = vx, v[1] = vy;
}

void reverse_free(double* q, double* v) {
  using Eigen::Vector3d;
  const Eigen::Matrix3d R = Eigen::Quaterniond(q[3], q[4], q[5], q[6]).toRotationMatrix();
  const Vector3d p(q[0], q[1], q[2]);
  const Vector3d omega = R * Vector3d(v[0], v[1], v[2]), velocity = R * Vector3d(v[3], v[4], v[5]);
  Eigen::Map<Vector3d>{q} = -(R.transpose() * p);
  for (int k = 4; k < 7; ++k) q[k] = -q[k];
  Eigen::Map<Vector3d>{v} = -omega;
  Eigen::Map<Vector3d>{v + 3} = omega.cross(p) - velocity;
}

void reverse_spherical(double* q, double* v) {
  const Eigen::Matrix3d R = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix();
  Eigen::Map<Eigen::Vector3d> omega(v);
  omega = Eigen::Vector3d(-(R * omega));
  for (int k = 1; k < 4; ++k) q[k] = -q[k];
}

}  // namespace

bool reversal_changes_coordinates(JointKind kind) {
  return is<Universal>(kind) || is<Planar>(kind) || is<Spherical>(kind) || is<Free>(kind);
}

JointSpec reversed(const JointSpec& joint, const Placement& frame_b) {
  JointSpec result = joint;
  const JointTraits& traits = joint.kind.traits();
  if (traits.axes == JointAxes::one) result.axis = -joint.axis.value_or(Eigen::Vector3d::UnitZ());
  if (traits.axes == JointAxes::two) {
    const Eigen::Matrix3d axes = joint_axes(joint);
    const bool exchanged = is<Universal>(joint.kind);
    result.axis = -axes.col(exchanged ? 0 : 2), result.axis2 = -axes.col(exchanged ? 2 : 0);
  }
  if (is<Universal>(joint.kind)) {
    std::reverse(result.coordinates.begin(), result.coordinates.end());
    std::reverse(result.limits.begin(), result.limits.end());
  }
  if (is<Planar>(joint.kind)) reverse_planar(result);
  if (is<Spherical>(joint.kind)) reverse_spherical(result);
  if (is<Free>(joint.kind)) reverse_free(result);
  std::swap(result.parent, result.body);
  result.frame = frame_b;
  return result;
}

void reverse_coordinates(JointKind kind, double* q, double* v) {
  if (is<Universal>(kind)) std::swap(q[0], q[1]), std::swap(v[0], v[1]);
  if (is<Planar>(kind)) reverse_planar(q, v);
  if (is<Spherical>(kind)) reverse_spherical(q, v);
  if (is<Free>(kind)) reverse_free(q, v);
}

int reversed_coordinate(JointKind kind, int k) {
  if (is<Universal>(kind)) return 1 - k;
  if (is<Planar>(kind)) return k == 2 ? 2 : -1;
  return reversal_changes_coordinates(kind) ? -1 : k;
}

}  // namespace lanc
