#include "tests/support/random_model.h"

#include <Eigen/Geometry>
#include <cmath>

namespace lanc::test {

std::uint64_t Random::next() {
  std::uint64_t z = (state_ += 0x9e3779b97f4a7c15u);
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}

double Random::uniform(double lower, double upper) {
  return lower + (upper - lower) * (static_cast<double>(next() >> 11) * 0x1p-53);
}

Eigen::Vector3d Random::vector(double size) {
  const double x = uniform(-size, size), y = uniform(-size, size), z = uniform(-size, size);
  return {x, y, z};
}

Eigen::Vector3d Random::direction() {
  for (;;) {
    const Eigen::Vector3d a = vector(1);
    if (a.norm() > 0.1 && a.norm() < 1) return a.normalized();
  }
}

Eigen::Matrix3d Random::rotation() {
  const Eigen::Vector3d axis = direction();
  return Eigen::AngleAxisd(uniform(-3, 3), axis).toRotationMatrix();
}

JointSpec random_joint(Random& random, JointKind kind, const std::string& name) {
  JointSpec joint;
  joint.name = name;
  joint.kind = kind;
  joint.frame.rotation = random.rotation();
  joint.frame.position = random.vector(0.5);
  const JointTraits& traits = kind.traits();
  if (traits.axes != JointAxes::none && random.chance(0.8)) {
    const Eigen::Vector3d a = random.direction();
    joint.axis = a * random.uniform(0.1, 10);  // need not be a unit vector
    if (traits.axes == JointAxes::two && random.chance(0.8)) joint.axis2 = a.cross(random.direction());
  }
  if (traits.has_pitch) joint.pitch = random.uniform(-0.5, 0.5);
  return joint;
}

BodySpec random_body(Random& random, const std::string& name) {
  BodySpec body;
  body.name = name;
  body.mass = random.uniform(0.5, 2);
  body.com = random.vector(0.3);
  const Eigen::Vector3d side = random.vector(0.25).cwiseAbs() + Eigen::Vector3d::Constant(0.25), s = side.cwiseAbs2();
  const Eigen::Matrix3d R = random.rotation();
  const Eigen::Vector3d box(s.y() + s.z(), s.x() + s.z(), s.x() + s.y());  // a homogeneous box
  const Eigen::Matrix3d I = R * Eigen::Matrix3d((body.mass / 12 * box).asDiagonal()) * R.transpose();
  body.inertia = (I + I.transpose()) / 2;
  return body;
}

MotionSpec random_motion(Random& random, int kind) {
  const double a = random.uniform(-1, 1), b = random.uniform(-1, 1), c = random.uniform(-1, 1);
  switch (kind) {
    case 0: return ConstantSpeed{a, b};
    case 1: return Polynomial{{a, b, c, random.uniform(-1, 1)}};
    case 2: return Sine{a, b, random.uniform(0.5, 3), c};
    case 3: {
      SplineTable table;  // no knot near t = 1/2, where the states are: differences must not cross one
      for (int k = 0; k <= 8; ++k)
        table.times.push_back(-1 + 0.4 * k), table.values.push_back(random.uniform(-0.3, 0.3));
      return table;
    }
    default: {
      static constexpr const char* formulas[] = {"0.3*sin(2*t) + t^2/4", "exp(-t)*cos(3*t) - 0.5",
                                                 "sqrt(2 + t)/(1 + t^2)", "tanh(t - 0.2) + pi/7",
                                                 "log(3 + t)*t^3 - tan(t/4)"};
      return Formula{formulas[random.below(5)]};
    }
  }
}

namespace {

void add_coordinates(Random& random, const Features& features, JointSpec& joint) {
  const JointTraits& traits = joint.kind.traits();
  joint.coordinates.resize(traits.nv);
  for (CoordinateSpec& c : joint.coordinates) {
    if (features.springs && traits.rates_are_velocities())
      c.stiffness = random.uniform(0, 20), c.rest = random.uniform(-1, 1);
    if (features.dissipation) {
      c.damping = random.uniform(0, 2);
      c.friction_positive = random.uniform(0, 1), c.friction_negative = random.uniform(0, 1);
      c.friction_speed = random.uniform(0.05, 0.5);
    }
    if (features.wrenches) c.torque = random.uniform(-1, 1);
    if (features.armature && random.chance(0.5)) c.armature = random.uniform(0, 0.3);
  }
}

void add_springs_and_wrenches(Random& random, const Features& features, ModelSpec& spec) {
  const int n = static_cast<int>(spec.bodies.size());
  if (n == 0) return;
  const auto name = [&](int i) { return i < 0 ? std::string() : spec.bodies[i].name; };
  if (features.springs)
    for (int k = random.below(3); k > 0; --k) {
      const int a = random.below(n) - 1;
      int b = random.below(n);
      if (a == b) continue;
      PointSpringSpec spring;
      spring.name = "spring" + std::to_string(k);
      spring.body_a = name(a), spring.body_b = name(b);
      spring.point_a = random.vector(0.5), spring.point_b = random.vector(0.5) + Eigen::Vector3d(0, 0, 1);
      spring.stiffness = random.uniform(0, 20), spring.rest_length = random.uniform(0, 1);
      if (features.dissipation) spring.damping = random.uniform(0, 2);
      spec.springs.push_back(spring);
    }
  if (features.wrenches && random.chance(0.3))
    spec.wrenches.push_back({name(random.below(n)), random.vector(1), random.vector(1), {}});
}

/// Shapes of trees: long ones, bushy ones, and those between.
int random_parent(Random& random, int style, int i) {
  if (i == 0) return ground;
  switch (style) {
    case 0: return i - 1;
    case 1: return random.chance(0.9) ? i - 1 : random.below(i + 1) - 1;
    case 2: return std::max(ground, i - 1 - random.below(4));
    default: return random.below(i + 1) - 1;
  }
}

}  // namespace

/// Singular inertias only where the mechanism keeps a solution: the body has at most one freedom; a massless one has
/// none, or carries the next body, which is massive and has at most one freedom in a generic direction.
ModelSpec random_spec(std::uint64_t seed, int bodies, const Features& features) {
  Random random(seed);
  ModelSpec spec;
  spec.name = "random-" + std::to_string(bodies) + "-" + std::to_string(seed);
  spec.gravity = random.vector(10);
  const int style = random.below(4);
  bool carried_by_massless = false;  // the next body is the one a massless body needs
  for (int i = 0; i < bodies; ++i) {
    int kind = random.below(joint_kinds);
    if (!features.only_joint.empty()) kind = find_joint_kind(features.only_joint)->index;
    if (carried_by_massless)
      while (JointKind{static_cast<unsigned char>(kind)}.traits().nv > 1) kind = random.below(joint_kinds);
    const std::string number = std::to_string(i);
    JointSpec joint = random_joint(random, JointKind{static_cast<unsigned char>(kind)}, "joint" + number);
    BodySpec body = random_body(random, "body" + number);
    const int parent = carried_by_massless ? i - 1 : random_parent(random, style, i);
    if (parent != ground) joint.parent = spec.bodies[parent].name;
    joint.body = body.name;
    const int nv = joint.kind.traits().nv;
    if (features.prescribed && nv == 1 && random.chance(0.25)) joint.motion = random_motion(random, random.below(5));
    if (random.chance(0.4)) add_coordinates(random, features, joint);
    const int freedoms = joint.motion ? 0 : nv;
    bool massless = false;
    if (features.singular_inertias && freedoms <= 1 && !carried_by_massless) {
      massless = (freedoms == 0 || i + 1 < bodies) && random.chance(0.15);
      if (massless) {
        body.mass = 0, body.inertia.setZero();
      } else if (random.chance(0.1)) {
        body.inertia.setZero();  // a point mass
      } else if (random.chance(0.1)) {
        const Eigen::Vector3d along = random.direction();  // a slender rod
        body.inertia = body.mass / 12 * (Eigen::Matrix3d::Identity() - along * along.transpose());
      }
    }
    carried_by_massless = massless && freedoms > 0;
    spec.bodies.push_back(body);
    spec.joints.push_back(joint);
  }
  add_springs_and_wrenches(random, features, spec);
  return spec;
}

State<double> random_state(Random& random, const Model& model) {
  State<double> state = neutral_state(model);
  state.t = 0.5;
  for (double& x : state.q) x = random.uniform(-1, 1);
  for (double& x : state.v) x = random.uniform(-1, 1);
  for (const Link& link : model.links())
    if (const int w = link.kind.traits().quaternion; w >= 0) {
      const Eigen::Quaterniond e(random.rotation());
      double* q = state.q.data() + link.q + w;
      q[0] = e.w(), q[1] = e.x(), q[2] = e.y(), q[3] = e.z();
    }
  return checked_state(model, state);
}

Loads<double> random_loads(Random& random, const Model& model) {
  Loads<double> loads;
  for (int k = 0; k < model.nv(); ++k) loads.tau.push_back(random.uniform(-2, 2));
  if (model.bodies() > 0)
    loads.wrenches.push_back({random.below(model.bodies()), {{random.uniform(-1, 1), 0.5, 0.25}, {0.5, -1, 2}}});
  return loads;
}

Case random_case(std::uint64_t seed, int bodies, const Features& features) {
  const ModelSpec spec = random_spec(seed, bodies, features);
  Random random(seed ^ 0xabcdef);
  Case result{spec.name, Model::build(spec), {}, {}};
  result.state = random_state(random, result.model);
  if (features.wrenches) result.loads = random_loads(random, result.model);
  return result;
}

}  // namespace lanc::test
