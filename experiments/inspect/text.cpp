#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>

#include "experiments/inspect/mechanism_report.h"
#include "lib/formulation/formulation.h"
#include "lib/system/evaluator.h"

namespace lanc {
namespace {

std::string triple(const Eigen::Vector3d& a) { return fmt::format("({:.4g}, {:.4g}, {:.4g})", a.x(), a.y(), a.z()); }

std::string summary(const StateInput& input) {
  const Model& model = input.model;
  double mass = 0;
  int deepest = 0, leaves = 0;
  std::vector<int> depth(model.bodies(), 1);
  for (int i = 0; i < model.bodies(); ++i) {
    const Link& link = model.link(i);
    mass += link.inertia.mass;
    if (link.parent != ground) depth[i] = depth[link.parent] + 1;
    deepest = std::max(deepest, depth[i]);
    leaves += link.leaf;
  }
  std::string text = fmt::format("{}: {} bodies, {:.6g} kg, gravity {} m/s²\n", model.name(), model.bodies(), mass,
                                 triple(model.spec().gravity));
  text +=
      fmt::format("Tree of depth {}, with {} {}; position coordinates: {}; prescribed motions: {}\n", deepest, leaves,
                  leaves == 1 ? "end" : "ends", model.nq(), model.drives() + model.closures().motions.size());
  return text;
}

std::string body_table(const StateInput& input) {
  const Model& model = input.model;
  Evaluator<double> evaluator(model);
  evaluator.system(input.state, input.loads);
  const std::vector<Vec3<double>>& positions = evaluator.positions();
  TextTable table({"body", "mass [kg]", "centre of mass [m]", "principal inertias [kg m²]", "now at [m]"});
  for (int i = 0; i < model.bodies(); ++i) {
    const BodySpec& body = model.spec().bodies[i];
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(body.inertia, Eigen::EigenvaluesOnly);
    table.row({body.name, fmt::format("{:.6g}", body.mass), triple(body.com), triple(solver.eigenvalues()),
               triple({positions[i].x, positions[i].y, positions[i].z})});
  }
  return table.empty() ? std::string()
                       : "\nBodies (body axes; place of the reference point in the world)\n" + table.text();
}

std::string axis_of(const JointSpec& joint) {
  if (joint.kind.traits().axes == JointAxes::none) return "-";
  return triple(joint.frame.rotation * joint.axis.value_or(Eigen::Vector3d::UnitZ()));
}

std::string joint_table(const StateInput& input) {
  const Model& model = input.model;
  TextTable table({"joint", "type", "from", "on body", "position [m]", "axis", "freedoms"}, 4);
  for (int i = 0; i < model.bodies(); ++i) {
    const JointSpec& joint = model.spec().joints[i];
    table.row({joint.name, std::string(joint.kind.traits().name), named(joint.parent), joint.body,
               triple(joint.frame.position), axis_of(joint),
               joint.motion ? "prescribed" : std::to_string(model.link(i).nv)});
  }
  return table.empty() ? std::string() : "\nJoints (in axes of the body they start from)\n" + table.text();
}

/// Positions with their limits, in the order of q.
std::string coordinate_table(const StateInput& input) {
  const Model& model = input.model;
  TextTable table({"position", "value", "unit", "lower", "upper", "note"});
  const std::vector<std::string> names = model.position_names();
  for (int i = 0; i < model.bodies(); ++i) {
    const Link& link = model.link(i);
    const auto& limits = model.spec().joints[i].limits;
    for (int k = 0; k < link.nq; ++k) {
      const double value = input.state.q[link.q + k];
      const auto limit = limits.empty() ? std::nullopt : limits[k];
      const bool outside = limit && (value < limit->lower || value > limit->upper);
      table.row({names[link.q + k], table_number(value), std::string(link.kind.traits().q_units[k]),
                 limit ? table_number(limit->lower) : "-", limit ? table_number(limit->upper) : "-",
                 outside ? "outside" : ""});
    }
  }
  return table.empty() ? std::string() : "\nPosition coordinates, in the order of --q\n" + table.text();
}

std::string force_table(const Model& model) {
  TextTable table(
      {"joint", "freedom", "stiffness", "rest", "damping", "friction −", "friction +", "torque", "armature"}, 2);
  for (int i = 0; i < model.bodies(); ++i) {
    const JointSpec& joint = model.spec().joints[i];
    for (std::size_t k = 0; k < joint.coordinates.size(); ++k) {
      const CoordinateSpec& c = joint.coordinates[k];
      std::vector<std::string> cells = {joint.name, std::string(joint.kind.traits().v_names[k])};
      for (const double x :
           {c.stiffness, c.rest, c.damping, c.friction_negative, c.friction_positive, c.torque, c.armature})
        cells.push_back(x == 0 ? "-" : table_number(x));
      table.row(std::move(cells));
    }
  }
  return table.empty() ? std::string() : "\nForces in the joints (SI units of the freedom)\n" + table.text();
}

std::string motion_text(const MotionSpec& motion) {
  return std::visit(
      []<class M>(const M& m) -> std::string {
        if constexpr (std::is_same_v<M, ConstantSpeed>) return fmt::format("{:.6g} + {:.6g} t", m.start, m.rate);
        if constexpr (std::is_same_v<M, Polynomial>)
          return fmt::format("polynomial, coefficients {:.6g}", fmt::join(m.coefficients, ", "));
        if constexpr (std::is_same_v<M, Sine>)
          return fmt::format("{:.6g} + {:.6g} sin({:.6g} t + {:.6g})", m.offset, m.amplitude, m.frequency, m.phase);
        if constexpr (std::is_same_v<M, SplineTable>)
          return fmt::format("spline through {} points, t = {:.6g} to {:.6g} s", m.times.size(), m.times.front(),
                             m.times.back());
        if constexpr (std::is_same_v<M, Formula>) return m.text;
      },
      motion);
}

std::string drive_list(const StateInput& input) {
  const Model& model = input.model;
  TextTable table({"prescribed", "motion", "value now", "unit", "rate now", "unit"}, 2);
  const std::vector<std::string> names = model.drive_names();
  for (int d = 0; d < model.drives(); ++d) {
    const MotionSample now = model.motion(d).at(input.state.t);
    const JointSpec& joint = model.spec().joints[model.body_of_drive(d)];
    const JointTraits& traits = joint.kind.traits();
    table.row({names[d], motion_text(*joint.motion), table_number(now.position), std::string(traits.q_units[0]),
               table_number(now.velocity), std::string(traits.v_units[0])});
  }
  return table.empty() ? std::string() : fmt::format("\nDrives, at t = {} s\n", input.state.t) + table.text();
}

std::string load_tables(const Model& model) {
  TextTable springs(
      {"spring", "from", "point [m]", "to", "point [m]", "stiffness [N/m]", "damping [N s/m]", "rest length [m]"}, 5);
  for (const PointSpringSpec& s : model.spec().springs)
    springs.row({s.name, named(s.body_a), triple(s.point_a), named(s.body_b), triple(s.point_b),
                 table_number(s.stiffness), table_number(s.damping), table_number(s.rest_length)});
  TextTable wrenches({"wrench on", "moment [N m]", "force [N]"});
  for (const WrenchSpec& w : model.spec().wrenches) wrenches.row({w.body, triple(w.moment), triple(w.force)});
  std::string text;
  if (!springs.empty()) text += "\nPoint springs (points in body axes)\n" + springs.text();
  if (!wrenches.empty()) text += "\nConstant wrenches (world axes)\n" + wrenches.text();
  return text;
}

std::string warning_text(const Model& model) {
  TextTable table({"about", "what to know"}, 2);
  for (const Warning& warning : warnings(model)) table.row({warning.about, warning.text});
  std::string text = table.empty() ? "\nNo warnings\n" : "\nWarnings\n" + table.text();
  TextTable objections({"formulation", "objects because"}, 2);
  std::vector<std::string_view> willing;
  for (const FormulationInfo& info : formulations()) {
    if (const auto objection = info.objection(model))
      objections.row({std::string(info.name), *objection});
    else
      willing.push_back(info.name);
  }
  text += fmt::format("\nFormulations that take it: {}\n", fmt::join(willing, ", "));
  return objections.empty() ? text : text + objections.text();
}

}  // namespace

std::string to_text(const MechanismReport& report) {
  const StateInput& input = report.input;
  return summary(input) + mobility_text(report) + body_table(input) + joint_table(input) + coordinate_table(input) +
         force_table(input.model) + drive_list(input) + load_tables(input.model) + warning_text(input.model);
}

}  // namespace lanc
