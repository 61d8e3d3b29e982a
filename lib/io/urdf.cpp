// URDF in. data/models/README.md tells users what becomes of its parts.
#include <console_bridge/console.h>
#include <fmt/format.h>
#include <urdf_parser/urdf_parser.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <mutex>

#include "lib/io/mechanism.h"
#include "lib/io/text.h"
#include "lib/io/urdf_document.h"

namespace lanc {
namespace {

/// Collects what urdfdom would print to the terminal.
class Messages final : public console_bridge::OutputHandler {
 public:
  Messages() { console_bridge::useOutputHandler(this); }
  ~Messages() override { console_bridge::restorePreviousOutputHandler(); }
  void log(const std::string& text, console_bridge::LogLevel level, const char*, int) override {
    if (level >= console_bridge::CONSOLE_BRIDGE_LOG_ERROR) text_ += (text_.empty() ? "" : "; ") + text;
  }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

urdf::ModelInterfaceSharedPtr parse(const std::string& xml, const std::string& file) {
  static std::mutex one_at_a_time;  // console_bridge has one handler for the whole program
  const std::lock_guard lock(one_at_a_time);
  const Messages messages;
  urdf::ModelInterfaceSharedPtr robot = urdf::parseURDF(xml);
  if (!robot || !messages.text().empty())
    throw InputError(Place{file}, "urdfdom cannot use the model: " + messages.text());
  // Links own their children; without this a chain of many links would be destroyed by as many nested calls.
  for (const auto& [name, link] : robot->links_) link->child_links.clear();
  return robot;
}

Eigen::Vector3d vector(const urdf::Vector3& v) { return {v.x, v.y, v.z}; }

Placement placement(const urdf::Pose& pose) {
  const urdf::Rotation& r = pose.rotation;
  return {Eigen::Quaterniond(r.w, r.x, r.y, r.z).normalized().toRotationMatrix(), vector(pose.position)};
}

BodySpec body(const UrdfDocument::LinkItem& item, const urdf::Link& link) {
  BodySpec body;
  body.name = item.name;
  body.place = item.place;
  body.allow_nonphysical_inertia = item.allow_nonphysical_inertia;
  if (!item.has_inertia) return body;
  const urdf::Inertial& inertial = *link.inertial;
  const Placement frame = placement(inertial.origin);
  Eigen::Matrix3d I;
  I << inertial.ixx, inertial.ixy, inertial.ixz,  //
      inertial.ixy, inertial.iyy, inertial.iyz,   //
      inertial.ixz, inertial.iyz, inertial.izz;
  body.mass = inertial.mass;
  body.com = frame.position;
  I = frame.rotation * I * frame.rotation.transpose();
  body.inertia = (I + I.transpose()) / 2;  // exactly symmetric after the rotation
  return body;
}

std::string_view kind_name(const urdf::Joint& joint) {
  switch (joint.type) {
    case urdf::Joint::PRISMATIC: return "prismatic";
    case urdf::Joint::FIXED: return "fixed";
    case urdf::Joint::FLOATING: return "free";
    case urdf::Joint::PLANAR: return "planar";
    default: return "revolute";  // or continuous; no other type passes read_urdf_document
  }
}

JointSpec joint(const UrdfDocument::JointItem& item, const urdf::Joint& source) {
  JointSpec joint;
  joint.name = item.name;
  joint.place = item.place;
  joint.kind = *find_joint_kind(kind_name(source));
  joint.parent = item.parent;
  joint.body = item.child;
  joint.frame = placement(source.parent_to_joint_origin_transform);
  const JointTraits& traits = joint.kind.traits();
  if (traits.axes != JointAxes::none) joint.axis = vector(source.axis);
  const bool limited = source.type == urdf::Joint::REVOLUTE || source.type == urdf::Joint::PRISMATIC;
  if (limited && source.limits) joint.limits.push_back(LimitSpec{source.limits->lower, source.limits->upper});
  if (!source.dynamics || (source.dynamics->damping == 0 && source.dynamics->friction == 0)) return joint;
  if (traits.nv != 1)
    throw InputError(item.place, fmt::format("joint {}: damping and friction of a {} joint have no defined meaning in "
                                             "URDF; set them to zero, or write the model in TOML",
                                             in_quotes(item.name), traits.name));
  CoordinateSpec coordinate;
  coordinate.damping = source.dynamics->damping;
  coordinate.friction_positive = coordinate.friction_negative = source.dynamics->friction;
  joint.coordinates.push_back(coordinate);
  return joint;
}

/// The root link as a body welded to ground, so that its mass is not lost.
JointSpec weld(const UrdfDocument::LinkItem& root) {
  JointSpec joint;
  joint.name = root.name + "_to_ground";
  joint.place = root.place;
  joint.kind = *find_joint_kind("fixed");
  joint.body = root.name;
  return joint;
}

/// q = multiplier × q of the joint mimicked + offset, as a coupler. `joints`: all of the robot's.
CouplerSpec mimic(const UrdfDocument::JointItem& item, const urdf::JointMimic& source,
                  const std::vector<JointSpec>& joints) {
  CouplerSpec coupler;
  coupler.name = item.name + "_mimic";
  coupler.place = item.mimic_place;
  coupler.offset = source.offset;
  coupler.terms.push_back({item.name, 0, 1.0});
  if (source.joint_name == item.name)
    throw InputError(item.mimic_place, fmt::format("joint {} mimics itself; name another joint", in_quotes(item.name)));
  if (source.multiplier != 0) coupler.terms.push_back({source.joint_name, 0, -source.multiplier});
  for (const std::string& name : {item.name, source.joint_name}) {
    const auto joint = std::find_if(joints.begin(), joints.end(), [&](const JointSpec& j) { return j.name == name; });
    if (joint == joints.end())
      throw InputError(item.mimic_place,
                       fmt::format("joint {}: it mimics {}, but there is no such joint; mend the name",
                                   in_quotes(item.name), in_quotes(name)));
    if (joint->kind.traits().nv != 1)
      throw InputError(item.mimic_place,
                       fmt::format("joint {}: mimic couples joints with one freedom, but {} is {}; remove it",
                                   in_quotes(item.name), in_quotes(name), joint->kind.traits().name));
  }
  return coupler;
}

/// Positions that follow from mimicked ones at zero; joints that mimic one another in a circle are left alone.
void follow_mimics(const Model& model, State<double>& state) {
  const auto& couplers = model.closures().couplers;
  for (std::size_t pass = 0; pass < couplers.size(); ++pass) {
    bool changed = false;
    for (const Coupler& c : couplers) {
      double& q = state.q[c.terms[0].q];
      const double wanted = c.terms.size() > 1 ? c.offset - c.terms[1].factor * state.q[c.terms[1].q] : c.offset;
      changed |= q != wanted;
      q = wanted;
    }
    if (!changed) return;
  }
}

}  // namespace

Mechanism load_urdf_text(std::string_view text, const std::string& name) {
  const UrdfDocument document = read_urdf_document(text, name);
  const urdf::ModelInterfaceSharedPtr robot = parse(document.clean, name);
  const UrdfDocument::LinkItem& root = document.links[document.root];
  ModelSpec spec;
  spec.name = document.name;
  spec.place = Place{name};
  spec.gravity = {0, 0, -9.81};  // URDF has none
  for (const UrdfDocument::LinkItem& item : document.links) {
    const urdf::LinkConstSharedPtr link = robot->getLink(item.name);
    if (!link || item.has_inertia != static_cast<bool>(link->inertial))
      throw InputError(item.place, fmt::format("urdfdom lost link {}; simplify its name", in_quotes(item.name)));
    if (item.name != root.name || root.has_inertia) spec.bodies.push_back(body(item, *link));
  }
  if (root.has_inertia) spec.joints.push_back(weld(root));
  for (const UrdfDocument::JointItem& item : document.joints) {
    const urdf::JointConstSharedPtr source = robot->getJoint(item.name);
    if (!source)
      throw InputError(item.place, fmt::format("urdfdom lost joint {}; simplify its name", in_quotes(item.name)));
    spec.joints.push_back(joint(item, *source));
    if (item.parent == root.name && !root.has_inertia) spec.joints.back().parent.clear();
  }
  for (const UrdfDocument::JointItem& item : document.joints)
    if (const auto source = robot->getJoint(item.name); source->mimic)
      spec.couplers.push_back(mimic(item, *source->mimic, spec.joints));
  if (spec.bodies.empty()) throw InputError(spec.place, "the robot has no link with inertia and no joint; add one");
  Model model = Model::build(spec);
  State<double> state = neutral_state(model);
  follow_mimics(model, state);
  return {std::move(model), std::move(state)};
}

Mechanism load_urdf(const std::string& path) { return load_urdf_text(read_model_file(path), path); }

}  // namespace lanc
