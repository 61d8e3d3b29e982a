// What a user says about a mechanism: plain data, filled in code, by a loader (lib/io) or by a generator.
// Model::build turns it into a validated, immutable Model.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "lib/model/closures/list.h"
#include "lib/model/error.h"
#include "lib/model/motion.h"

namespace lanc {

constexpr int ground = -1;  // the index that stands for K_0

/// Position and orientation of a frame in another: columns of `rotation` are its axes.
struct Placement {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
};

/// A body and its mass. Body axes and reference point are those of its joint's frame on the body.
struct BodySpec {
  std::string name;
  double mass = 0;                                    // kg; 0 is legal
  Eigen::Vector3d com = Eigen::Vector3d::Zero();      // m, body axes
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();  // kg m², about the centre of mass, body axes
  bool allow_nonphysical_inertia = false;             // accept indefinite or non-triangle inertia
  Place place;
};

/// Per velocity coordinate of a joint: spring, damper, friction, constant torque, armature. SI units of that
/// coordinate.
struct CoordinateSpec {
  double stiffness = 0, rest = 0;  // −stiffness (q − rest)
  double damping = 0;              // −damping v
  double friction_positive = 0;    // Coulomb friction at v > 0, as a magnitude
  double friction_negative = 0;    // and at v < 0
  double friction_speed = 1e-3;    // speed over which the step at v = 0 is smoothed
  double torque = 0;               // constant
  double armature = 0;             // rotor inertia A: Cᵀ f̂ + A η̇ = τ
};

/// Lower and upper limit of one position coordinate. Not enforced by the dynamics; used by assembly, shown by
/// `inspect`.
struct LimitSpec {
  double lower, upper;
};

/// The joint that carries body `body` (the successor) on body `parent` (the predecessor; empty means ground).
struct JointSpec {
  std::string name;
  JointKind kind;
  std::string parent, body;
  Placement frame;                       // of the joint (at zero position, of the body) in the predecessor's body axes
  std::optional<Eigen::Vector3d> axis;   // in joint axes; default z; normalised. Planar: the normal
  std::optional<Eigen::Vector3d> axis2;  // universal: second axis; planar: direction of x; perpendicular to `axis`
  double pitch = 0;                      // helical: m/rad
  std::vector<CoordinateSpec> coordinates;       // empty, or one per velocity (one for a prescribed joint)
  std::vector<std::optional<LimitSpec>> limits;  // empty, or one per position coordinate
  std::optional<MotionSpec> motion;              // prescribed: the joint then has no q and no v
  Place place;
};

/// A loop closed by a secondary joint, or by another closure kind, between body `a` (the predecessor) and body `b`.
struct ClosureSpec {
  std::string name;
  ClosureKind kind;
  std::string body_a, body_b;                  // empty means ground
  Placement frame_a, frame_b;                  // of the closure, in body axes; both coincide at zero position
  std::optional<Eigen::Vector3d> axis, axis2;  // in the axes of either frame, as for a joint of that kind
  double pitch = 0;                            // helical: m/rad
  double length = 0;                           // distance: m
  std::optional<MotionSpec> motion;            // prescribed: coordinate of a joint with one freedom, or the length
  Place place;
};

/// Gear, belt, mimic: Σ factor × coordinate = offset + motion(t).
struct CouplerSpec {
  struct Term {
    std::string joint;
    int coordinate = 0;  // of the joint, whose rates must be its velocities (no Euler parameters)
    double factor = 1;
  };
  std::string name;
  std::vector<Term> terms;
  double offset = 0;
  std::optional<MotionSpec> motion;
  Place place;
};

/// Spring and damper in parallel between two points: force (length − rest) k + d(length)/dt c, pulling when positive.
struct PointSpringSpec {
  std::string name;
  std::string body_a, body_b;                                                            // empty means ground
  Eigen::Vector3d point_a = Eigen::Vector3d::Zero(), point_b = Eigen::Vector3d::Zero();  // body axes
  double stiffness = 0, damping = 0, rest_length = 0;
  Place place;
};

/// Constant wrench on a body, world axes, about the body's reference point.
struct WrenchSpec {
  std::string body;
  Eigen::Vector3d moment = Eigen::Vector3d::Zero(), force = Eigen::Vector3d::Zero();
  Place place;
};

struct ModelSpec {
  std::string name;
  Eigen::Vector3d gravity = Eigen::Vector3d::Zero();  // m/s²
  std::optional<double> length;                       // characteristic length; default: mean distance of joints
  std::vector<BodySpec> bodies;
  std::vector<JointSpec> joints;  // exactly one per body, in any order
  std::vector<ClosureSpec> closures;
  std::vector<CouplerSpec> couplers;
  std::vector<PointSpringSpec> springs;
  std::vector<WrenchSpec> wrenches;
  Place place;
};

}  // namespace lanc
