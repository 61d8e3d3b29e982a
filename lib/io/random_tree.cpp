#include "lib/io/random_tree.h"

#include <fmt/format.h>

#include <algorithm>

#include "lib/io/draw_space.h"

namespace lanc {
namespace {

using Eigen::Vector3d;

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
    add(draw_body(draw_), std::move(joint));
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
      add(k < count ? light_body() : draw_body(draw_), std::move(joint));
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
