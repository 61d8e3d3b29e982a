#include "lib/io/random_tree.h"

#include <fmt/format.h>

#include <algorithm>

namespace lanc {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Eigen holds numbers here and multiplies none: its kernels contract on some processors, whatever the flags say.

Vector3d draw_vector(Draw& draw, double size) {
  const double x = draw.between(-size, size), y = draw.between(-size, size), z = draw.between(-size, size);
  return {x, y, z};
}

Vector3d draw_direction(Draw& draw) {
  double a[3];
  draw.direction(a, 3);
  return {a[0], a[1], a[2]};
}

Matrix3d draw_rotation(Draw& draw) {
  double e[4];
  draw.direction(e, 4);
  const double w = e[0], x = e[1], y = e[2], z = e[3];
  Matrix3d R;
  R << 1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),  //
      2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),   //
      2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y);
  return R;
}

/// a × b of perpendicular unit vectors.
Vector3d across(const Vector3d& a, const Vector3d& b) {
  return {a.y() * b.z() - a.z() * b.y(), a.z() * b.x() - a.x() * b.z(), a.x() * b.y() - a.y() * b.x()};
}

/// Some unit vector perpendicular to the unit vector `a`.
Vector3d draw_perpendicular(Draw& draw, const Vector3d& a) {
  for (;;) {
    const Vector3d b = across(a, draw_direction(draw));
    const double square = b.x() * b.x() + b.y() * b.y() + b.z() * b.z();
    if (square < 0.1) continue;
    const double norm = std::sqrt(square);
    return {b.x() / norm, b.y() / norm, b.z() / norm};
  }
}

/// Tensor of a homogeneous box in any orientation.
Matrix3d draw_inertia(Draw& draw, double mass) {
  double side[3], principal[3];
  for (double& s : side) s = draw.between(0.1, 0.5), s *= s;
  for (int k = 0; k < 3; ++k) principal[k] = mass * (side[(k + 1) % 3] + side[(k + 2) % 3]) / 12;
  const Matrix3d R = draw_rotation(draw);
  Matrix3d I;
  for (int a = 0; a < 3; ++a)
    for (int b = a; b < 3; ++b) {
      double sum = 0;
      for (int k = 0; k < 3; ++k) sum += R(a, k) * principal[k] * R(b, k);
      I(a, b) = I(b, a) = sum;
    }
  return I;
}

/// Any of the five kinds of prescribed motion, moderate for |t| ≤ 2.
MotionSpec draw_motion(Draw& draw) {
  const double a = draw.between(-1, 1), b = draw.between(-1, 1), c = draw.between(-1, 1);
  switch (draw.index(5)) {
    case 0: return ConstantSpeed{a, b};
    case 1: return Polynomial{{a, b, c}};
    case 2: return Sine{a, b, 2 + c, draw.between(-1, 1)};
    case 3: return SplineTable{{-2, -1, 0, 1, 2}, {a, b, c, draw.between(-1, 1), draw.between(-1, 1)}};
    default: return Formula{fmt::format("{} * sin(2 * t) + {} * t^2", a, b)};
  }
}

bool one_freedom(JointKind kind) { return kind.traits().nv == 1; }

class RandomTree {
 public:
  RandomTree(const RandomTreeOptions& options, Draw& draw) : options_(options), draw_(draw) {
    std::copy_if(options.kinds.begin(), options.kinds.end(), std::back_inserter(single_), one_freedom);
    constexpr double follow[] = {0.2, 0.6, 0.95};  // bushy, mixed, chains with a few branches
    follow_ = follow[draw.index(3)];
    // A third of the trees has no light body, so that formulations that object to them are tested as widely.
    light_ = options.massless && !single_.empty() && draw.chance(0.67) ? 0.1 : 0.0;
    spec_.bodies.reserve(options.bodies), spec_.joints.reserve(options.bodies);
  }

  ModelSpec spec() {
    while (missing() > 0) {
      if (!draw_.chance(light_))
        add_ordinary();
      else if (missing() == 1 || draw_.chance(0.4))
        add_light_leaf();
      else
        add_carried(missing() > 2 && draw_.chance(0.3) ? 2 : 1);
    }
    if (options_.forces) add_springs_and_wrenches();
    return std::move(spec_);
  }

 private:
  int missing() const { return options_.bodies - static_cast<int>(spec_.bodies.size()); }

  /// Name of a body to hang the next one on, often the last one; empty is the ground.
  std::string draw_parent() {
    const int n = static_cast<int>(spec_.bodies.size());
    if (n > 0 && draw_.chance(follow_)) return spec_.bodies.back().name;
    const int k = draw_.index(n + 1);
    return k == n ? std::string() : spec_.bodies[k].name;
  }

  void add(BodySpec body, JointSpec joint) {
    const std::string number = std::to_string(spec_.bodies.size() + 1);
    body.name = "b" + number;
    joint.name = "j" + number;
    joint.body = body.name;
    spec_.bodies.push_back(std::move(body));
    spec_.joints.push_back(std::move(joint));
  }

  BodySpec full_body() {
    BodySpec body;
    body.mass = draw_.between(0.5, 2);
    body.com = draw_vector(draw_, 0.2);
    body.inertia = draw_inertia(draw_, body.mass);
    return body;
  }

  /// No inertia; a point mass or none at all.
  BodySpec light_body() {
    BodySpec body;
    if (draw_.chance(0.5)) return body;
    body.mass = draw_.between(0.5, 2);
    body.com = draw_vector(draw_, 0.2);
    return body;
  }

  // Arguments are evaluated in an order of the compiler's choice: a call may draw for one of its arguments only.
  JointKind draw_kind(const std::vector<JointKind>& kinds) {
    return kinds[draw_.index(static_cast<int>(kinds.size()))];
  }

  JointSpec joint_on(const std::string& parent, JointKind kind) {
    JointSpec joint;
    joint.parent = parent;
    joint.kind = kind;
    joint.frame.position = draw_vector(draw_, 0.3);
    if (kind.traits().axes != JointAxes::none) joint.axis = draw_direction(draw_);
    if (kind.traits().axes == JointAxes::two) joint.axis2 = draw_perpendicular(draw_, *joint.axis);
    if (kind.traits().has_pitch) joint.pitch = draw_.between(0.02, 0.2);
    return joint;
  }

  void drive_or_load(JointSpec& joint) {
    if (options_.driven && one_freedom(joint.kind) && draw_.chance(0.15)) joint.motion = draw_motion(draw_);
    const JointTraits& traits = joint.kind.traits();
    if (!options_.forces || traits.nv == 0 || !draw_.chance(0.3)) return;
    joint.coordinates.resize(traits.nv);
    for (CoordinateSpec& c : joint.coordinates) {
      if (traits.rates_are_velocities() && draw_.chance(0.5))
        c.stiffness = draw_.between(1, 10), c.rest = draw_.between(-1, 1);
      if (draw_.chance(0.5)) c.damping = draw_.between(0.1, 1);
      if (draw_.chance(0.3)) {
        c.friction_positive = draw_.between(0, 1);
        c.friction_negative = draw_.between(0, 1);
        c.friction_speed = 0.1;
      }
      if (draw_.chance(0.3)) c.torque = draw_.between(-1, 1);
      if (draw_.chance(0.3)) c.armature = draw_.between(0.01, 0.1);
    }
  }

  void add_ordinary() {
    const std::string parent = draw_parent();
    JointSpec joint = joint_on(parent, draw_kind(options_.kinds));
    joint.frame.rotation = draw_rotation(draw_);
    drive_or_load(joint);
    add(full_body(), std::move(joint));
  }

  /// `count` light bodies in series and a full one on them, on mutually perpendicular axes.
  void add_carried(int count) {
    Vector3d axes[3];
    axes[0] = draw_direction(draw_);
    axes[1] = draw_perpendicular(draw_, axes[0]);
    axes[2] = across(axes[0], axes[1]);
    std::string parent = draw_parent();
    for (int k = 0; k <= count; ++k) {
      JointSpec joint = joint_on(parent, draw_kind(single_));
      joint.axis = axes[k];
      if (k == 0) joint.frame.rotation = draw_rotation(draw_);
      if (k == 0 || k == count) drive_or_load(joint);  // a driven joint in the middle could align the outer axes
      add(k < count ? light_body() : full_body(), std::move(joint));
      parent = spec_.bodies.back().name;
    }
  }

  void add_light_leaf() {
    const std::string parent = draw_parent();
    JointSpec joint = joint_on(parent, draw_kind(single_));
    joint.frame.rotation = draw_rotation(draw_);
    BodySpec body = light_body();
    if (body.mass > 0) {  // off the axis: seen by the freedom whether it turns or slides
      const Vector3d arm = draw_perpendicular(draw_, *joint.axis);
      body.com = {0.2 * arm.x(), 0.2 * arm.y(), 0.2 * arm.z()};
    } else if (options_.driven && draw_.chance(0.5)) {
      joint.motion = draw_motion(draw_);
    } else if (options_.forces) {
      joint.coordinates.resize(1);
      joint.coordinates[0].armature = draw_.between(0.05, 0.2);
    } else {
      joint = joint_on(parent, *find_joint_kind("fixed"));
    }
    add(std::move(body), std::move(joint));
  }

  void add_springs_and_wrenches() {
    const int n = options_.bodies;
    const auto end = [&](int k) { return k == n ? std::string() : spec_.bodies[k].name; };
    for (int s = draw_.index(2 + n / 10); s > 0; --s) {
      const int a = draw_.index(n), b = (a + 1 + draw_.index(n)) % (n + 1);  // two of the bodies and the ground
      PointSpringSpec spring;
      spring.name = fmt::format("s{}", spec_.springs.size() + 1);
      spring.body_a = end(a), spring.body_b = end(b);
      spring.point_a = draw_vector(draw_, 0.3), spring.point_b = draw_vector(draw_, 0.3);
      spring.stiffness = draw_.between(1, 10), spring.damping = draw_.between(0, 1);
      spring.rest_length = draw_.between(0, 0.5);
      spec_.springs.push_back(std::move(spring));
    }
    if (draw_.chance(0.3)) {
      WrenchSpec wrench;
      wrench.body = end(draw_.index(n));
      wrench.moment = draw_vector(draw_, 1), wrench.force = draw_vector(draw_, 1);
      spec_.wrenches.push_back(std::move(wrench));
    }
  }

  const RandomTreeOptions& options_;
  Draw& draw_;
  std::vector<JointKind> single_;  // the kinds of one freedom
  double follow_, light_;
  ModelSpec spec_;
};

}  // namespace

ModelSpec random_tree(const RandomTreeOptions& options, Draw& draw) { return RandomTree(options, draw).spec(); }

}  // namespace lanc
