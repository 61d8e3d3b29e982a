#include "experiments/inspect/mechanism_report.h"

namespace lanc {
namespace {

Json vector(const Eigen::Vector3d& a) { return {a.x(), a.y(), a.z()}; }

Json body_json(const BodySpec& body, const std::vector<Warning>& all) {
  Json inertia = Json::array(), told = Json::array();
  for (int r = 0; r < 3; ++r) inertia.push_back(vector(body.inertia.row(r)));
  for (const Warning& warning : all)
    if (warning.about == body.name) told.push_back(warning.text);
  return {
      {"name", body.name}, {"mass", body.mass}, {"com", vector(body.com)}, {"inertia", inertia}, {"warnings", told}};
}

Json coordinate_json(const CoordinateSpec& c) {
  return {{"stiffness", c.stiffness}, {"rest", c.rest},
          {"damping", c.damping},     {"friction", {c.friction_negative, c.friction_positive}},
          {"torque", c.torque},       {"armature", c.armature}};
}

Json joint_json(const Model& model, int i) {
  const JointSpec& joint = model.spec().joints[i];
  const JointTraits& traits = joint.kind.traits();
  const Link& link = model.link(i);
  Json limits = Json::array(), coordinates = Json::array(), q = Json::array(), v = Json::array();
  for (const auto& limit : joint.limits) limits.push_back(limit ? Json{limit->lower, limit->upper} : Json(nullptr));
  for (const CoordinateSpec& c : joint.coordinates) coordinates.push_back(coordinate_json(c));
  for (int k = 0; k < link.nq; ++k) q.push_back(traits.q_names[k]);
  for (int k = 0; k < link.nv; ++k) v.push_back(traits.v_names[k]);
  return {{"name", joint.name},
          {"type", traits.name},
          {"parent", joint.parent.empty() ? "ground" : joint.parent},
          {"body", joint.body},
          {"position", vector(joint.frame.position)},
          {"axis", traits.axes == JointAxes::none
                       ? Json(nullptr)
                       : vector(joint.frame.rotation * joint.axis.value_or(Eigen::Vector3d::UnitZ()))},
          {"prescribed", joint.motion.has_value()},
          {"q", q},
          {"v", v},
          {"limits", limits},
          {"forces", coordinates}};
}

}  // namespace

Json to_json(const StateInput& input) {
  const Model& model = input.model;
  const std::vector<Warning> all = warnings(model);
  Json bodies = Json::array(), joints = Json::array(), unique = Json::object();
  for (int i = 0; i < model.bodies(); ++i) {
    bodies.push_back(body_json(model.spec().bodies[i], all));
    joints.push_back(joint_json(model, i));
    unique[model.spec().joints[i].name] = {true, true, true, true, true, true};
  }
  // A tree: no loop, so no closure row; every count is that of the joints.
  return {{"bodies", bodies},
          {"joints", joints},
          {"loops", Json::array()},
          {"velocities", model.nv()},
          {"closure_rows", 0},
          {"grubler", model.nv()},
          {"rank", 0},
          {"generic_rank", 0},
          {"redundant", 0},
          {"mobility", model.nv()},
          {"finite_mobility", model.nv()},
          {"verdict", "regular"},
          {"sigma", {nullptr, nullptr}},
          {"redundant_rows", Json::array()},
          {"removable_rows", Json::array()},
          {"unique_reactions", unique}};
}

}  // namespace lanc
