#include "tests/support/zoo.h"

namespace lanc::test {
namespace {

const Features plain{.prescribed = false,
                     .singular_inertias = false,
                     .dissipation = false,
                     .springs = false,
                     .wrenches = false,
                     .armature = false};

Case case_of(const std::string& name, ModelSpec spec) {
  spec.name = name;
  Random random(77);
  Case c{name, Model::build(spec), {}, {}};
  c.state = random_state(random, c.model);
  return c;
}

/// Every body on the one before, all joints of one kind.
ModelSpec chain(int bodies, const std::string& joint, Features features = plain) {
  features.only_joint = joint;
  ModelSpec spec = random_spec(4000 + bodies, bodies, features);
  for (int i = 0; i < bodies; ++i) spec.joints[i].parent = i == 0 ? "" : spec.bodies[i - 1].name;
  return spec;
}

ModelSpec tree(int bodies, const std::string& joint, const std::function<int(int)>& parent) {
  ModelSpec spec = chain(bodies, joint);
  for (int i = 0; i < bodies; ++i) spec.joints[i].parent = parent(i) < 0 ? "" : spec.bodies[parent(i)].name;
  return spec;
}

ModelSpec edited(ModelSpec spec, const std::function<void(ModelSpec&)>& edit) {
  edit(spec);
  return spec;
}

void make_massless(BodySpec& body) { body.mass = 0, body.com.setZero(), body.inertia.setZero(); }

ModelSpec with_coordinates(const CoordinateSpec& coordinate) {
  return edited(chain(4, "revolute"), [&](ModelSpec& spec) {
    for (JointSpec& joint : spec.joints) joint.coordinates = {coordinate};
  });
}

ModelSpec with_motion(int kind) {
  return edited(chain(4, "revolute"), [&](ModelSpec& spec) {
    Random random(kind);
    spec.joints[1].motion = random_motion(random, kind);
  });
}

ModelSpec scaled_masses(double factor) {
  return edited(chain(4, "revolute"), [&](ModelSpec& spec) {
    for (int i = 2; i < 4; ++i) spec.bodies[i].mass *= factor, spec.bodies[i].inertia *= factor;
  });
}

using Make = std::function<ModelSpec()>;

std::vector<std::pair<std::string, Make>> solvable() {
  std::vector<std::pair<std::string, Make>> list;
  for (unsigned char k = 0; k < joint_kinds; ++k) {
    const std::string joint(JointKind{k}.traits().name);
    list.emplace_back("joint " + joint, [joint] { return chain(4, joint); });
  }
  static constexpr const char* motions[] = {"constant speed", "polynomial", "sine", "spline", "formula"};
  for (int k = 0; k < 5; ++k) list.emplace_back(std::string("motion ") + motions[k], [k] { return with_motion(k); });
  const std::vector<std::pair<std::string, Make>> others = {
      {"all joints prescribed",
       [] {
         return edited(chain(4, "prismatic"), [](ModelSpec& spec) {
           for (JointSpec& joint : spec.joints) joint.motion = Sine{0, 1, 2, 0.1};
         });
       }},
      {"massless body between",
       [] { return edited(chain(4, "revolute"), [](ModelSpec& s) { make_massless(s.bodies[1]); }); }},
      {"massless body at the end, welded",
       [] {
         return edited(chain(4, "revolute"), [](ModelSpec& s) {
           make_massless(s.bodies[3]);
           s.joints[3].kind = *find_joint_kind("fixed"), s.joints[3].axis.reset(), s.joints[3].coordinates.clear();
         });
       }},
      {"massless body with armature",
       [] {
         return edited(chain(4, "revolute"), [](ModelSpec& s) {
           make_massless(s.bodies[3]);
           s.joints[3].coordinates = {{.armature = 0.2}};
         });
       }},
      {"universal joint of two massless bodies",  // three axes through one point, as ZYX angles
       [] {
         return edited(chain(4, "revolute"), [](ModelSpec& s) {
           make_massless(s.bodies[1]), make_massless(s.bodies[2]);
           for (int i = 2; i < 4; ++i) s.joints[i].frame.position.setZero();
         });
       }},
      {"point mass", [] { return edited(chain(4, "revolute"), [](ModelSpec& s) { s.bodies[3].inertia.setZero(); }); }},
      {"slender rod",
       [] {
         return edited(chain(4, "revolute"), [](ModelSpec& s) {
           s.bodies[3].inertia = Eigen::Vector3d(0, 1, 1).asDiagonal();
           s.bodies[3].com = {0.5, 0, 0};
         });
       }},
      {"nonphysical inertia",
       [] {
         return edited(chain(4, "revolute"), [](ModelSpec& s) {
           s.bodies[0].inertia = Eigen::Vector3d(0, 0.35, 0).asDiagonal();
           s.bodies[0].allow_nonphysical_inertia = true;
         });
       }},
      {"mass matrix not positive definite",
       [] {
         return edited(chain(4, "revolute"), [](ModelSpec& s) {
           s.bodies[1].inertia = -20 * Eigen::Matrix3d::Identity();
           s.bodies[1].allow_nonphysical_inertia = true;
         });
       }},
      {"armature", [] { return with_coordinates({.armature = 0.3}); }},
      {"joint springs and dampers", [] { return with_coordinates({.stiffness = 5, .rest = 0.2, .damping = 0.4}); }},
      {"joint friction", [] { return with_coordinates({.friction_positive = 0.5, .friction_negative = 0.3}); }},
      {"point springs and wrenches",
       [] {
         return edited(chain(4, "revolute"), [](ModelSpec& s) {
           s.springs = {{"one", "", "body3", {0, 0, 1}, {0.1, 0, 0}, 5, 0.5, 0.2, {}},
                        {"two", "body1", "body3", {0, 0.3, 0}, {0.1, 0, 0}, 5, 0.5, 0.2, {}}};
           s.wrenches = {{"body2", {0.1, 0.2, 0.3}, {1, 2, 3}, {}}};
         });
       }},
      {"0 bodies", [] { return ModelSpec{}; }},
      {"1 body", [] { return chain(1, "revolute"); }},
      {"1 free body", [] { return chain(1, "free"); }},
      {"only fixed joints", [] { return tree(7, "fixed", [](int i) { return i == 0 ? -1 : (i - 1) / 2; }); }},
      {"forest", [] { return tree(6, "revolute", [](int i) { return i < 3 ? -1 : i - 3; }); }},
      {"binary tree of 63", [] { return tree(63, "revolute", [](int i) { return i == 0 ? -1 : (i - 1) / 2; }); }},
      {"star of 64", [] { return tree(64, "spherical", [](int i) { return i == 0 ? -1 : 0; }); }},
      {"chain of 2000", [] { return chain(2000, "revolute"); }},
      {"light bodies on heavy ones, 1e-6", [] { return scaled_masses(1e-6); }},
      {"heavy bodies on light ones, 1e6", [] { return scaled_masses(1e6); }},
      {"everything", [] { return random_spec(31, 20); }},
  };
  list.insert(list.end(), others.begin(), others.end());
  return list;
}

std::vector<std::pair<std::string, Make>> unsolvable() {
  return {
      {"singular: massless free body",
       [] { return edited(chain(1, "free"), [](ModelSpec& s) { make_massless(s.bodies[0]); }); }},
      {"singular: massless body at the end",
       [] { return edited(chain(4, "revolute"), [](ModelSpec& s) { make_massless(s.bodies[3]); }); }},
      {"singular: point mass on a spherical joint at its mass centre",
       [] {
         return edited(chain(3, "spherical"),
                       [](ModelSpec& s) { s.bodies[2].inertia.setZero(), s.bodies[2].com.setZero(); });
       }},
      {"singular: slender rod on a spherical joint",
       [] {
         return edited(chain(3, "spherical"), [](ModelSpec& s) {
           s.bodies[2].inertia = Eigen::Vector3d(0, 1, 1).asDiagonal(), s.bodies[2].com = {0.5, 0, 0};
         });
       }},
      {"singular: coaxial revolutes with a massless body between",
       [] {
         return edited(chain(4, "revolute"), [](ModelSpec& s) {
           make_massless(s.bodies[2]);
           s.joints[2].axis = s.joints[3].axis = Eigen::Vector3d(0, 0, 1);
           s.joints[3].frame = {};
           s.joints[3].frame.position = {0, 0, 0.4};
         });
       }},
      {"singular: parallel sliders with a massless body between",
       [] {
         return edited(chain(4, "prismatic"), [](ModelSpec& s) {
           make_massless(s.bodies[1]);
           s.joints[1].axis = s.joints[2].axis = Eigen::Vector3d(1, 2, 3);
           s.joints[2].frame.rotation.setIdentity();
         });
       }},
  };
}

}  // namespace

std::vector<Kind> zoo() {
  std::vector<Kind> result;
  for (const auto& entry : solvable()) {
    const auto name = entry.first;
    const auto make = entry.second;
    // LU and QR lose some of the six decades between the masses, maximal coordinates four
    const double condition = name.find("heavy") != std::string::npos ? 1e4 : 1;
    result.push_back({name, [name, make] { return case_of(name, make()); }, condition, true});
  }
  for (const auto& entry : unsolvable()) {
    const auto name = entry.first;
    const auto make = entry.second;
    result.push_back({name, [name, make] { return case_of(name, make()); }, 1, false});
  }
  return result;
}

std::vector<Case> small_zoo(int bodies) {
  std::vector<Case> result;
  for (const Kind& kind : zoo()) {
    if (!kind.solvable || kind.condition > 1) continue;
    Case c = kind.make();
    if (c.model.bodies() <= bodies) result.push_back(std::move(c));
  }
  return result;
}

}  // namespace lanc::test
