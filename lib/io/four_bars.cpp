#include "lib/io/four_bars.h"

#include <numbers>

namespace lanc {
namespace {

/// A rod of 1 kg from its reference point to `tip`, 0.1 m thick.
BodySpec rod(std::string name, const Eigen::Vector3d& tip) {
  BodySpec body;
  body.name = std::move(name);
  body.mass = 1;
  body.com = tip / 2;
  const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() * tip.squaredNorm() - tip * tip.transpose();
  body.inertia = across / 12 + tip * tip.transpose() * (0.00125 / tip.squaredNorm());
  return body;
}

JointSpec hinge(std::string name, std::string parent, std::string body, const Eigen::Vector3d& position,
                const Eigen::Vector3d& axis = Eigen::Vector3d::UnitY()) {
  JointSpec joint;
  joint.name = std::move(name);
  joint.kind = *find_joint_kind("revolute");
  joint.parent = std::move(parent);
  joint.body = std::move(body);
  joint.frame.position = position;
  joint.axis = axis;
  return joint;
}

/// Collects rods with their hinges, and the angle and rate each hinge has.
struct Assembly {
  FourBarOptions options;
  ModelSpec spec;
  std::vector<double> q, v;

  explicit Assembly(const FourBarOptions& o, const std::string& name) : options(o) {
    spec.name = name;
    spec.gravity = {0, 0, -o.gravity};
    spec.length = 1;
  }
  /// sign: +1 leans with the uprights, −1 makes up for it.
  void add(const BodySpec& body, const std::string& parent, const Eigen::Vector3d& position, double sign) {
    spec.bodies.push_back(body);
    spec.joints.push_back(hinge("j_" + body.name, parent, body.name, position));
    q.push_back(sign * options.angle), v.push_back(sign * options.rate);
  }
  void upright(const std::string& name, const std::string& parent, double x) {
    add(rod(name, Eigen::Vector3d::UnitZ()), parent, {x, 0, 0}, 1);
  }
  /// A point or a hinge, as the options say.
  ClosureSpec joint_closure(const std::string& name) const {
    const bool is_hinge = options.cut == FourBarOptions::Cut::hinge;
    ClosureSpec closure;
    closure.name = name;
    closure.kind = *find_closure_kind(is_hinge ? "revolute" : "point-on-point");
    if (is_hinge) closure.axis = Eigen::Vector3d::UnitY();
    return closure;
  }
  /// The upright that closes a loop: whole, or a lower half with the upper half hanging on the coupler at `along`.
  void closing_upright(const std::string& name, const std::string& parent, double x, const std::string& coupler,
                       double along = 1) {
    ClosureSpec closure = joint_closure("close_" + name);
    closure.body_a = coupler;
    if (options.cut != FourBarOptions::Cut::weld) {
      upright(name, parent, x);
      closure.body_b = name;
      closure.frame_a.position = along * Eigen::Vector3d::UnitX();
      closure.frame_b.position = Eigen::Vector3d::UnitZ();
    } else {
      const Eigen::Vector3d half = Eigen::Vector3d::UnitZ() / 2;
      BodySpec lower = rod(name, half), upper = rod(name + "_upper", -half);
      lower.mass = upper.mass = 0.5;
      lower.inertia /= 2, upper.inertia /= 2;
      add(lower, parent, {x, 0, 0}, 1);
      add(upper, coupler, along * Eigen::Vector3d::UnitX(), 1);
      closure.kind = *find_closure_kind("fixed");
      closure.axis.reset();
      closure.body_a = name;
      closure.body_b = upper.name;
      closure.frame_a.position = half;
      closure.frame_b.position = -half;
    }
    spec.closures.push_back(closure);
  }
  void coupler(const std::string& name, const std::string& upright, double length = 1) {
    add(rod(name, length * Eigen::Vector3d::UnitX()), upright, Eigen::Vector3d::UnitZ(), -1);
  }
  Mechanism mechanism() {
    // Model::build keeps the order: parents come before children here
    return {Model::build(spec), {0, q, v}};
  }
};

}  // namespace

Mechanism four_bar_ladder(const FourBarOptions& options, const std::string& name) {
  Assembly a(options, name);
  a.upright("u0", "", 0);
  for (int i = 1; i <= options.loops; ++i) {
    const std::string number = std::to_string(i), coupler = "c" + number;
    a.coupler(coupler, "u" + std::to_string(i - 1));
    a.closing_upright("u" + number, "", i, coupler);
  }
  return a.mechanism();
}

Mechanism four_bar_tree(const FourBarOptions& options, const std::string& name) {
  Assembly a(options, name);
  for (int i = 1; i <= options.loops; ++i) {
    const std::string number = std::to_string(i), coupler = "c" + number;
    const std::string base = i == 1 ? "" : "c" + std::to_string((i - 2) / options.branching + 1);
    a.upright("l" + number, base, 0);
    a.coupler(coupler, "l" + number);
    a.closing_upright("r" + number, base, 1, coupler);
  }
  return a.mechanism();
}

Mechanism four_bar_chain(const FourBarOptions& options, const std::string& name) {
  FourBarOptions one_on_each = options;
  one_on_each.branching = 1;
  return four_bar_tree(one_on_each, name);
}

Mechanism four_bar_nest(const FourBarOptions& options, const std::string& name) {
  Assembly a(options, name);
  a.upright("u0", "", 0);
  a.coupler("coupler", "u0", options.loops);
  for (int i = 1; i <= options.loops; ++i) a.closing_upright("u" + std::to_string(i), "", i, "coupler", i);
  return a.mechanism();
}

Mechanism polygon(const FourBarOptions& options, const std::string& name) {
  const int n = options.loops;
  if (n < 2) throw InputError("a polygon needs 2 rods at least; its ground is one more side");
  FourBarOptions turning = options;
  turning.angle = 2 * std::numbers::pi / (n + 1), turning.rate = 0;
  Assembly a(turning, name);
  const bool weld = options.cut == FourBarOptions::Cut::weld;
  std::string parent;
  const Eigen::Vector3d side = Eigen::Vector3d::UnitX();
  for (int i = 1; i <= n; ++i) {
    const std::string rod_name = "b" + std::to_string(i);
    BodySpec body = rod(rod_name, i == n && weld ? Eigen::Vector3d(side / 2) : side);
    if (i == n && weld) body.mass /= 2, body.inertia /= 2;
    a.add(body, parent, side, 1);  // the first corner is the end of the side on the ground
    parent = rod_name;
  }
  ClosureSpec closure = a.joint_closure("close");
  closure.body_a = parent;
  if (weld) {
    BodySpec half = rod("b" + std::to_string(n) + "_end", -side / 2);
    half.mass /= 2, half.inertia /= 2;
    a.add(half, "", Eigen::Vector3d::Zero(), -1);
    closure.kind = *find_closure_kind("fixed");
    closure.axis.reset();
    closure.body_b = half.name;
    closure.frame_a.position = side / 2;
    closure.frame_b.position = -side / 2;
  } else {
    closure.frame_a.position = side;
  }
  a.spec.closures.push_back(closure);
  return a.mechanism();
}

Model planar_four_bar(double a, double b, double c, double d, bool hinge_cut) {
  ModelSpec spec;
  spec.name = "planar four-bar";
  spec.length = (a + b + c + d) / 4;
  const auto heavy_rod = [](const char* name, const Eigen::Vector3d& tip) {
    BodySpec body = rod(name, tip);
    body.mass = tip.norm();
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() * tip.squaredNorm() - tip * tip.transpose();
    body.inertia = body.mass * (across / 12 + Eigen::Matrix3d::Identity() * 1e-3);
    return body;
  };
  const Eigen::Vector3d z = Eigen::Vector3d::UnitZ();
  spec.bodies = {heavy_rod("crank", {a, 0, 0}), heavy_rod("coupler", {b, 0, 0}), heavy_rod("rocker", {0, -c, 0})};
  spec.joints = {hinge("beta1", "", "crank", {0, 0, 0}, z), hinge("beta2", "crank", "coupler", {a, 0, 0}, z),
                 hinge("beta3", "", "rocker", {0, d, 0}, z)};
  ClosureSpec cut;
  cut.name = "cut";
  cut.kind = *find_closure_kind(hinge_cut ? "revolute" : "point-on-line");  // the line is z: rows x and y
  // the frame that gives the axes of the rows stands on the rocker; for the lecture's rows it would be ground
  cut.body_a = "rocker";
  cut.body_b = "coupler";
  cut.frame_a.position = {0, -c, 0};
  cut.frame_b.position = {b, 0, 0};
  spec.closures = {cut};
  return Model::build(spec);
}

}  // namespace lanc
