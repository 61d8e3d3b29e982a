// The mechanism, validated and immutable, as formulations and kinematics see it.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "lib/model/closure_set.h"

namespace lanc {

/// How the axes of a joint's frame stand in those of the predecessor: as these do, renamed in a circle (y z x or
/// z x y), or in some other way. Kinematics need no product for the first three: 0.97 of the time of `recursive`.
enum class FrameTurn : unsigned char { none, yzx, zxy, other };

/// One body with the joint that carries it, in *joint axes*: z along the joint's axis (lib/model/joints/joint.h).
struct Link {
  int parent = ground;  // p(i) < i, or ground
  JointKind kind;
  int q = 0, v = 0;                   // first position and velocity coordinate of the joint
  int nq = 0, nv = 0;                 // none if the motion is prescribed
  int drive = -1;                     // index among the prescribed freedoms, or −1
  int angle = 0;                      // first of its angles in Model::angles()
  bool last_sibling = false;          // the first of its siblings to be met from leaf to root
  bool leaf = true;                   // carries no other body
  FrameTurn turn = FrameTurn::other;  // X; on the ground none
  double pitch = 0;                   // m/rad
  Mat3<double> X;                     // axes of the joint's frame on the predecessor, in the predecessor's axes
  Vec3<double> o;                     // its origin there
  RigidInertia<double> inertia;       // about the reference point
  Vec3<double> weight;                // m g, world axes
};

/// The passive forces of one velocity coordinate that has any.
struct PassiveCoordinate {
  int body, coordinate;  // coordinate: of the joint
  CoordinateSpec spec;
};

/// A point spring with its points in joint axes of the bodies.
struct PointSpring {
  int body_a, body_b;
  Vec3<double> point_a, point_b;
  double stiffness, damping, rest_length;
};

struct ConstantWrench {
  int body;
  Wrench<double> wrench;
};

/// Immutable; cheap to copy (shared). Bodies are numbered so that p(i) < i; otherwise in the order of the
/// specification.
class Model {
 public:
  /// Validates. Throws InputError naming the thing, its place and the mend. Tested by tests/lib/model_test.cpp.
  static Model build(ModelSpec spec);

  const std::string& name() const { return data_->spec.name; }
  const ModelSpec& spec() const { return data_->spec; }  // bodies[i] and joints[i] belong to link i
  int bodies() const { return static_cast<int>(data_->links.size()); }
  int nq() const { return data_->nq; }
  int nv() const { return data_->nv; }
  int drives() const { return static_cast<int>(data_->motions.size()); }
  std::span<const Link> links() const { return data_->links; }
  const Link& link(int body) const { return data_->links[body]; }
  /// Body whose joint has velocity coordinate k, and the structure of column k.
  int body_of_velocity(int k) const { return data_->body_of_velocity[k]; }
  ColumnKind column_kind(int k) const { return data_->column_kind[k]; }
  std::span<const double> armature() const { return data_->armature; }
  bool has_armature() const { return data_->has_armature; }
  /// Every angle of the mechanism in the order of the bodies: its position coordinate, or −1 − d for that of drive d.
  std::span<const int> angles() const { return data_->angles; }
  int body_of_drive(int d) const { return data_->body_of_drive[d]; }
  ColumnKind drive_kind(int d) const { return link(body_of_drive(d)).kind.traits().columns[0]; }
  const PrescribedMotion& motion(int drive) const { return *data_->motions[drive]; }
  std::span<const PassiveCoordinate> passive() const { return data_->passive; }
  std::span<const PointSpring> springs() const { return data_->springs; }
  std::span<const ConstantWrench> wrenches() const { return data_->wrenches; }
  const ClosureSet& closures() const { return data_->closures; }
  bool has_closures() const { return data_->closures.rows() > 0; }
  const Vec3<double>& gravity() const { return data_->gravity; }
  /// Characteristic length, m: from the specification, or the mean distance between joints, or 1.
  double length() const { return data_->length; }
  /// Rotation from joint axes to the user's body axes: R_body = R_joint · this.
  const Mat3<double>& body_axes(int body) const { return data_->body_axes[body]; }

  /// Some body whose spatial inertia is not safely positive definite (a massless body, a point mass, a slender rod):
  /// M̄ may then be singular, and answers are checked by a forward error estimate (lib/formulation/formulation.h).
  bool has_singular_inertia() const { return data_->singular_inertia_body >= 0; }
  int singular_inertia_body() const { return data_->singular_inertia_body; }

  std::optional<int> find_body(std::string_view name) const;
  std::vector<std::string> velocity_names() const;  // joint.coordinate
  std::vector<std::string> position_names() const;
  std::vector<std::string> drive_names() const;

 private:
  struct Data {
    using Index = std::unordered_map<std::string_view, int>;
    ModelSpec spec;
    Index body_index;  // by name; the keys are the names in spec.bodies
    std::vector<Link> links;
    std::vector<Mat3<double>> body_axes;
    int nq = 0, nv = 0;
    std::vector<int> body_of_velocity, body_of_drive, angles;
    std::vector<ColumnKind> column_kind;
    std::vector<double> armature;
    bool has_armature = false;
    std::vector<std::shared_ptr<const PrescribedMotion>> motions;
    std::vector<PassiveCoordinate> passive;
    std::vector<PointSpring> springs;
    std::vector<ConstantWrench> wrenches;
    ClosureSet closures;
    Vec3<double> gravity;
    double length = 1;
    int singular_inertia_body = -1;
  };
  friend class ModelBuilder;
  std::shared_ptr<const Data> data_;
};

/// Time, positions β and velocities η.
template <class S>
struct State {
  double t = 0;
  std::vector<S> q, v;
};

/// All coordinates zero, Euler parameters (1, 0, 0, 0).
State<double> neutral_state(const Model& model);

/// Throws InputError when sizes are wrong, something is not finite, or Euler parameters are not normalised to 1e-6
/// (they are then normalised exactly, eq. 2).
State<double> checked_state(const Model& model, State<double> state);

/// What acts beside the model's own forces: torque per velocity coordinate (empty: none) and wrenches on bodies.
template <class S>
struct Loads {
  struct Applied {
    int body;
    Wrench<S> wrench;  // world axes, about the body's reference point
  };
  std::vector<S> tau;
  std::vector<Applied> wrenches;
};

template <class S, class T>
State<S> cast(const State<T>& state) {
  return {state.t, {state.q.begin(), state.q.end()}, {state.v.begin(), state.v.end()}};
}

template <class S, class T>
Loads<S> cast(const Loads<T>& loads) {
  Loads<S> result{{loads.tau.begin(), loads.tau.end()}, {}};
  for (const auto& w : loads.wrenches) result.wrenches.push_back({w.body, cast<S>(w.wrench)});
  return result;
}

}  // namespace lanc
