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

Json closure_json(const Model& model, int k) {
  const ClosureSpec& closure = model.spec().closures[k];
  const Closure& c = model.closures().closures[k];
  Json rows = Json::array();
  for (int r = c.row; r < c.row + c.conditions().count; ++r) rows.push_back(model.closures().row_names[r]);
  return {{"name", closure.name},
          {"type", closure.kind.traits().name},
          {"body_a", closure.body_a.empty() ? "ground" : closure.body_a},
          {"body_b", closure.body_b.empty() ? "ground" : closure.body_b},
          {"prescribed", closure.motion.has_value()},
          {"rows", rows}};
}

Json coupler_json(const Model& model, int k) {
  const CouplerSpec& coupler = model.spec().couplers[k];
  Json joints = Json::array();
  for (const CouplerSpec::Term& term : coupler.terms) joints.push_back(term.joint);
  return {{"name", coupler.name},
          {"type", "coupler"},
          {"joints", joints},
          {"prescribed", coupler.motion.has_value()},
          {"rows", {model.closures().row_names[model.closures().couplers[k].row]}}};
}

Json cuts_json(const GraphRecord& graph) {
  Json cuts = Json::array();
  for (const LoopCut& cut : graph.cuts)
    cuts.push_back({{"joint", cut.joint},
                    {"type", cut.kind.traits().name},
                    {"conditions", cut.conditions},
                    {"demanded", cut.demanded},
                    {"loop", cut.loop}});
  return cuts;
}

}  // namespace

Json to_json(const MechanismReport& report) {
  const Model& model = report.input.model;
  const Mobility& m = report.mobility;
  const std::vector<Warning> all = warnings(model);
  Json bodies = Json::array(), joints = Json::array(), loops = Json::array(), unique = Json::object();
  for (int i = 0; i < model.bodies(); ++i) {
    bodies.push_back(body_json(model.spec().bodies[i], all));
    joints.push_back(joint_json(model, i));
    unique[model.spec().joints[i].name] = m.unique[i];
  }
  for (std::size_t k = 0; k < model.spec().closures.size(); ++k) {
    loops.push_back(closure_json(model, static_cast<int>(k)));
    Json rows = Json::array();
    const Closure& c = model.closures().closures[k];
    for (int r = c.row; r < c.row + c.conditions().count; ++r) rows.push_back(bool(m.unique_row[r]));
    unique[model.spec().closures[k].name] = rows;
  }
  for (std::size_t k = 0; k < model.spec().couplers.size(); ++k) {
    loops.push_back(coupler_json(model, static_cast<int>(k)));
    unique[model.spec().couplers[k].name] = {bool(m.unique_row[model.closures().couplers[k].row])};
  }
  const auto names = [&](const std::vector<int>& rows) {
    Json list = Json::array();
    for (const int r : rows) list.push_back(model.closures().row_names[r]);
    return list;
  };
  Json result = {
      {"bodies", bodies},
      {"joints", joints},
      {"loops", loops},
      {"cuts", cuts_json(report.input.graph)},
      {"reversed", report.input.graph.reversed},
      {"velocities", m.velocities},
      {"closure_rows", m.closure_rows},
      {"grubler", m.grubler},
      {"rank", m.rank},
      {"generic_rank", m.generic_rank},
      {"redundant", m.redundant()},
      {"mobility", m.mobility},
      {"finite_mobility", m.finite_mobility},
      {"verdict", to_string(m.verdict)},
      {"sigma", {m.rank > 0 ? Json(m.sigma) : Json(nullptr), m.redundant() > 0 ? Json(m.next_sigma) : Json(nullptr)}},
      {"redundant_rows", names(m.redundant_rows)},
      {"removable_rows", names(m.removable_rows)},
      {"unique_reactions", unique}};
  if (report.absolute)
    result["absolute"] = {{"coordinates", m.absolute_coordinates},
                          {"rows", m.absolute_rows},
                          {"rank", m.absolute_rank},
                          {"redundant", m.redundant()}};
  return result;
}

}  // namespace lanc
