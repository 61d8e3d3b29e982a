// What several peers need of our model: its parts in Eigen's types, and the free root in other velocity coordinates.
#pragma once

#include <Eigen/Dense>
#include <initializer_list>
#include <string_view>
#include <vector>

#include "lib/io/mechanism.h"

namespace lanc::peers {

Eigen::Vector3d eigen(const Vec3<double>& a);
Eigen::Matrix3d eigen(const Mat3<double>& a);

/// Principal axes of inertia (columns) and moments about the centre of mass, in joint axes.
struct PrincipalFrame {
  Eigen::Vector3d com = Eigen::Vector3d::Zero(), moments = Eigen::Vector3d::Zero();
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
};

/// A body's mass, centre of mass and inertia about it, in joint axes.
struct BodyMass {
  double mass;
  Eigen::Vector3d com;
  Eigen::Matrix3d inertia;

  explicit BodyMass(const RigidInertia<double>& about_reference_point);
  PrincipalFrame principal_frame() const;
};

inline bool is(const Link& link, std::string_view kind) { return link.kind.traits().name == kind; }
inline bool has_free_root(const Model& model) { return is(model.link(0), "free"); }

/// Throws InputError, in the name of `peer`, unless all joints are of these kinds, a free one only the first body's on
/// ground, the model has closures of no other kinds than `closures`, and none of prescribed motions, springs, constant
/// wrenches and couplers. Friction, damping and armature are taken off before (Contest).
void require(std::string_view peer, const Model& model, std::initializer_list<std::string_view> joints,
             std::initializer_list<std::string_view> closures = {});

/// Euler parameters (w, x, y, z) at q.
Eigen::Quaterniond quaternion(const double* q);

/// The motion of a free root in world axes at a state: pose, angular velocity, velocity of the reference point.
struct FreeRoot {
  Eigen::Matrix3d R;
  Eigen::Vector3d position, angular, linear;

  FreeRoot() = default;
  FreeRoot(const Model& model, const State<double>& state);

  /// Our six accelerations, the rates of the body-axes components of `angular` and `linear`, from d/dt of these vectors
  /// in world axes; and back.
  void from_world(const Eigen::Vector3d& alpha, const Eigen::Vector3d& a, double* vdot) const;
  void to_world(const double* vdot, Eigen::Vector3d& alpha, Eigen::Vector3d& a) const;
};

}  // namespace lanc::peers
