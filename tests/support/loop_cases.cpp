#include "tests/support/loop_cases.h"

#include "lib/io/mechanism.h"
#include "lib/solve/dense.h"
#include "lib/system/closure_jacobian.h"
#include "lib/system/evaluator.h"

namespace lanc::test {
namespace {

/// Velocities that satisfy the closure conditions, near the given ones.
void make_consistent(Case& c) {
  Evaluator<double> evaluator(c.model);
  ClosureJacobian<double> jacobian(c.model);
  const System<double>& system = evaluator.system(c.state, c.loads);
  jacobian.evaluate(system);
  Eigen::MatrixXd G = Eigen::MatrixXd::Zero(jacobian.rows(), c.model.nv());
  Eigen::VectorXd rate(jacobian.rows());
  for (int k = 0; k < jacobian.rows(); ++k) {
    for (int p = jacobian.starts()[k]; p < jacobian.starts()[k + 1]; ++p)
      G(k, jacobian.columns()[p]) = jacobian.values()[p];
    rate[k] = system.closure_rows[k].rate;
  }
  Eigen::Map<Eigen::VectorXd>(c.state.v.data(), c.model.nv()) -= least_squares(G, rate, 1e-10);
}

struct Vertex {
  const char* joint;
  Eigen::Vector3d position;
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();
};

/// A single loop: ground, a body from each vertex to the next, the last joint cut. All coordinates are zero.
ModelSpec polygon(const std::vector<Vertex>& vertices) {
  Random random(17);
  ModelSpec spec;
  spec.name = "polygon";
  spec.length = 1;
  const auto placed = [&](std::size_t i) {
    Placement p;
    p.position = i == 0 ? vertices[0].position : Eigen::Vector3d(vertices[i].position - vertices[i - 1].position);
    return p;
  };
  for (std::size_t i = 0; i + 1 < vertices.size(); ++i) {
    const std::string number = std::to_string(i);
    JointSpec joint;
    joint.name = "j" + number;
    joint.kind = *find_joint_kind(vertices[i].joint);
    joint.parent = i == 0 ? "" : spec.bodies.back().name;
    joint.body = "b" + number;
    joint.frame = placed(i);
    if (joint.kind.traits().axes != JointAxes::none) joint.axis = vertices[i].axis;
    spec.joints.push_back(joint);
    spec.bodies.push_back(random_body(random, "b" + number));
  }
  const std::size_t last = vertices.size() - 1;
  ClosureSpec closure;
  closure.name = "cut";
  closure.kind = *find_closure_kind(vertices[last].joint);
  closure.body_a = spec.bodies.back().name;
  closure.frame_a = placed(last);
  closure.frame_b.position = vertices[last].position;
  if (closure.kind.traits().axes != JointAxes::none) closure.axis = vertices[last].axis;
  spec.closures.push_back(closure);
  return spec;
}

Case at_rest_position(const std::string& name, const ModelSpec& spec, std::uint64_t seed = 3) {
  Case c{name, Model::build(spec), {}, {}};
  Random random(seed);
  c.state = neutral_state(c.model);
  for (double& v : c.state.v) v = random.uniform(-1, 1);
  c.loads = random_loads(random, c.model);
  make_consistent(c);
  return c;
}

ModelSpec five_bar() {
  return polygon({{"revolute", {0, 0, 0}},
                  {"revolute", {-0.3, 1, 0}},
                  {"revolute", {0.6, 1.7, 0}},
                  {"revolute", {1.5, 0.9, 0}},
                  {"revolute", {1.1, 0, 0}}});
}

ModelSpec spatial_loop() {
  return polygon({{"revolute", {0, 0, 0}, {0.2, 0.1, 1}},
                  {"spherical", {-0.3, 1, 0.2}},
                  {"cylindrical", {0.6, 1.7, 0.5}, {1, 0.3, -0.2}},
                  {"universal", {1.5, 0.9, -0.4}, {0, 1, 0}},
                  {"spherical", {1.1, 0, 0}}});
}

CouplerSpec gear(const std::string& a, const std::string& b) {
  CouplerSpec coupler;
  coupler.name = "gear_" + a + "_" + b;
  coupler.terms = {{a, 0, 1.0}, {b, 0, -2.5}};
  return coupler;
}

/// A length from a body to a point of the ground, prescribed from what it is at zero position.
ClosureSpec cylinder(const std::string& body, const Eigen::Vector3d& at, const Eigen::Vector3d& anchor) {
  ClosureSpec closure;
  closure.name = "cylinder";
  closure.kind = *find_closure_kind("distance");
  closure.body_b = body;
  closure.frame_a.position = anchor;
  closure.motion = Polynomial{{(at - anchor).norm(), 0.4, 0.3}};
  return closure;
}

/// A rod of 1 m and 1 kg on a hinge about y.
void add_rod(ModelSpec& spec, const std::string& name, const Eigen::Vector3d& tip, const std::string& parent,
             const Eigen::Vector3d& at) {
  BodySpec body;
  body.name = name;
  body.mass = 1, body.com = tip / 2;
  body.inertia = Eigen::Matrix3d(Eigen::Vector3d(0.1, 0.1, 0.1).asDiagonal());
  spec.bodies.push_back(body);
  JointSpec joint;
  joint.name = "j_" + name, joint.kind = *find_joint_kind("revolute");
  joint.parent = parent, joint.body = name, joint.frame.position = at, joint.axis = Eigen::Vector3d::UnitY();
  spec.joints.push_back(joint);
}

ClosureSpec point(const std::string& name, const std::string& a, const Eigen::Vector3d& on_a, const std::string& b,
                  const Eigen::Vector3d& on_b) {
  ClosureSpec closure;
  closure.name = name, closure.kind = *find_closure_kind("point-on-point");
  closure.body_a = a, closure.body_b = b;
  closure.frame_a.position = on_a, closure.frame_b.position = on_b;
  return closure;
}

ModelSpec empty_spec(const std::string& name) {
  ModelSpec spec;
  spec.name = name;
  spec.gravity = {0, 0, -9.81};
  spec.length = 1;
  return spec;
}

}  // namespace

std::vector<Case> closed_loops() {
  std::vector<Case> result;
  for (const char* kind : {"ladder", "chain"})
    for (const char* cut : {"point", "weld"})
      for (const int n : {1, 3, 12}) {
        const std::string name = std::string("four-bar-") + kind + ":" + std::to_string(n) + ":cut=" + cut;
        const Mechanism m = load_mechanism(name);
        result.push_back({name, m.model, m.state, {}});
      }
  result.push_back(at_rest_position("five-bar", five_bar()));
  result.push_back(at_rest_position("spatial loop", spatial_loop()));
  ModelSpec spec = five_bar();
  spec.couplers.push_back(gear("j0", "j2"));
  result.push_back(at_rest_position("geared five-bar", spec));
  spec.joints[2].coordinates.push_back({.armature = 0.3});
  result.push_back(at_rest_position("geared five-bar with a rotor", spec));
  spec = five_bar();
  spec.closures[0].motion = ConstantSpeed{0, 1.5};
  result.push_back(at_rest_position("five-bar driven at its cut", spec));
  spec = spatial_loop();
  spec.closures.push_back(cylinder("b2", {0.6, 1.7, 0.5}, {2, 2, 1}));
  result.push_back(at_rest_position("spatial loop with a hydraulic cylinder", spec));
  spec.closures.push_back(cylinder("b3", {1.5, 0.9, -0.4}, {2, -1, 1}));
  spec.closures.back().name = "inner";
  spec.closures.back().body_a = "b0", spec.closures.back().frame_a.position = {0.5, 0.5, 0.5};
  spec.closures.back().motion = Polynomial{{(Eigen::Vector3d(1.5, 0.9, -0.4) - Eigen::Vector3d(0.5, 0.5, 0.5)).norm()}};
  spec.closures.push_back(spec.closures[1]);  // the same condition again
  spec.closures.back().name = "cylinder_again";
  result.push_back(at_rest_position("loops in a loop", spec));
  spec = polygon({{"revolute", {0, 0, 0}},
                  {"revolute", {1, 0.2, 0.1}, {0, 1, 0}},
                  {"prismatic", {2, 0.3, -0.1}},
                  {"spherical", {2.5, 1, 0.4}}});
  spec.closures.clear();
  spec.couplers = {gear("j0", "j1"), gear("j1", "j2")};
  result.push_back(at_rest_position("gears on an open chain", spec));
  return result;
}

Case tangle(std::uint64_t seed, int closures) {
  Random random(seed);
  ModelSpec spec = random_spec(seed, 12, {.prescribed = true, .singular_inertias = false});
  spec.length = 1;
  const auto body = [&] { return spec.bodies[random.below(static_cast<int>(spec.bodies.size()))].name; };
  for (int k = 0; k < closures; ++k) {
    ClosureSpec closure;
    closure.name = "c" + std::to_string(k);
    closure.kind = {static_cast<unsigned char>(random.below(static_cast<int>(closures::all_closures.size())))};
    closure.body_a = random.chance(0.2) ? std::string() : body();
    do closure.body_b = body();
    while (closure.body_b == closure.body_a);
    closure.frame_a = {random.rotation(), random.vector(0.7)},
    closure.frame_b = {random.rotation(), random.vector(0.7)};
    if (closure.kind.traits().axes != JointAxes::none) closure.axis = random.direction();
    if (closure.kind.traits().has_pitch) closure.pitch = 0.3;
    if (closure.kind.traits().has_length) closure.length = 0.6;
    spec.closures.push_back(closure);
  }
  std::vector<std::string> gears;
  for (const JointSpec& joint : spec.joints)
    if (!joint.motion && joint.kind.traits().nv > 0 && joint.kind.traits().rates_are_velocities())
      gears.push_back(joint.name);
  for (std::size_t k = 0; seed % 2 == 0 && k + 1 < gears.size(); k += 4)
    spec.couplers.push_back(gear(gears[k], gears[k + 1]));
  Case c{"tangle " + std::to_string(seed), Model::build(spec), {}, {}};
  c.state = random_state(random, c.model);
  c.loads = random_loads(random, c.model);
  return c;
}

std::vector<Case> held_by_loops() {
  std::vector<Case> result;
  Mechanism m = load_mechanism("four-bar-ladder:2");
  ModelSpec spec = m.model.spec();
  for (BodySpec& body : spec.bodies)
    if (body.name[0] == 'c') body.mass = 0, body.inertia.setZero();
  result.push_back({"massless couplers", Model::build(spec), m.state, {}});
  for (BodySpec& body : spec.bodies)
    if (body.name[0] == 'c') body.mass = 1e-11, body.inertia = Eigen::Matrix3d::Identity() * 1e-12;
  result.push_back({"couplers with hardly any mass", Model::build(spec), m.state, {}});

  spec = spatial_loop();
  for (BodySpec& body : spec.bodies)
    if (body.name == "b3") body.mass = 0, body.com.setZero(), body.inertia.setZero();
  result.push_back(at_rest_position("massless end of a spatial loop", spec));

  // a rod without axial inertia on a ball joint; the closure holds its rotation about its own axis
  spec = polygon({{"spherical", {0, 0, 0}}, {"spherical", {0, 0, 1}}});
  const Eigen::Vector3d tip(0.3, 0.2, 0.9);
  spec.bodies[0].mass = 2, spec.bodies[0].com = tip / 2;
  spec.bodies[0].inertia = (Eigen::Matrix3d::Identity() * tip.squaredNorm() - tip * tip.transpose()) / 6;
  ClosureSpec& closure = spec.closures[0];
  closure.kind = *find_closure_kind("universal");
  closure.frame_a = closure.frame_b = Placement();
  closure.axis = Eigen::Vector3d::UnitX(), closure.axis2 = Eigen::Vector3d::UnitY();
  result.push_back(at_rest_position("slender rod", spec));
  return result;
}

Case long_chain_tied_to_ground(int n, double angle) {
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX(), z = Eigen::Vector3d::UnitZ();
  ModelSpec spec = empty_spec("chain tied to ground");
  add_rod(spec, "u0", z, "", {0, 0, 0});
  std::vector<double> q = {angle};
  for (int i = 1; i <= n; ++i) {
    const std::string number = std::to_string(i);
    add_rod(spec, "c" + number, x, i == 1 ? "u0" : "c" + std::to_string(i - 1), i == 1 ? z : x);
    add_rod(spec, "u" + number, -z, "c" + number, x);
    q.push_back(i == 1 ? -angle : 0), q.push_back(angle);
    spec.closures.push_back(point("tie" + number, "u" + number, -z, "", i * x));
  }
  Case c{spec.name, Model::build(spec), {}, {}};
  c.state = {0, q, std::vector<double>(q.size(), 0.0)};
  return c;
}

Case chains_with_rungs(int n, double angle) {
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX(), z = Eigen::Vector3d::UnitZ();
  ModelSpec spec = empty_spec("chains with rungs");
  std::vector<double> q;
  for (int i = 1; i <= n; ++i) {
    const std::string number = std::to_string(i), below = std::to_string(i - 1);
    add_rod(spec, "a" + number, z, i == 1 ? "" : "a" + below, i == 1 ? 0 * x : z);
    add_rod(spec, "b" + number, z, i == 1 ? "" : "b" + below, i == 1 ? x : z);
    add_rod(spec, "r" + number, x, "a" + number, z);
    q.insert(q.end(), {i == 1 ? angle : 0, i == 1 ? angle : 0, -angle});
    spec.closures.push_back(point("rung" + number, "r" + number, x, "b" + number, z));
  }
  Case c{spec.name, Model::build(spec), {}, {}};
  c.state = {0, q, std::vector<double>(q.size(), 0.0)};
  return c;
}

State<double> at_rest(const Model& model, std::vector<double> q) {
  return {0, std::move(q), std::vector<double>(model.nv(), 0.0)};
}

State<double> at_rest(std::vector<double> q) {
  std::vector<double> v(q.size(), 0.0);
  return {0, std::move(q), std::move(v)};
}

double largest_violation_of(const Model& model, const State<double>& state) {
  Evaluator<double> evaluator(model);
  double largest = 0;
  for (const auto& row : evaluator.system(state).closure_rows) largest = std::max(largest, std::abs(row.g));
  return largest;
}

}  // namespace lanc::test
