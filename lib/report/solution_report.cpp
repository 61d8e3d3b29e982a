#include "lib/report/solution_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace lanc {
namespace {

Json six(const Vec3<double>& a, const Vec3<double>& b) {
  return {json_number(a.x), json_number(a.y), json_number(a.z), json_number(b.x), json_number(b.y), json_number(b.z)};
}

void add_six(std::vector<std::string>& cells, const Vec3<double>& a, const Vec3<double>& b) {
  for (const double x : {a.x, a.y, a.z, b.x, b.y, b.z}) cells.push_back(table_number(x));
}

/// Members and elements on lines of their own, but arrays and objects of plain values on one line.
void append(std::string& text, const Json& value, std::size_t indent) {
  const auto plain = [](const Json& x) { return !x.is_structured(); };
  if (value.empty() || plain(value) || (std::all_of(value.begin(), value.end(), plain) && indent > 0)) {
    text += value.dump(-1, ' ', false, Json::error_handler_t::replace);
    return;
  }
  const std::string margin(indent + 1, ' ');
  text += value.is_object() ? "{" : "[";
  for (auto item = value.begin(); item != value.end(); ++item) {
    text += (item == value.begin() ? "\n" : ",\n") + margin;
    if (value.is_object()) text += Json(item.key()).dump(-1, ' ', false, Json::error_handler_t::replace) + ": ";
    append(text, *item, indent + 1);
  }
  text += fmt::format("\n{:{}}{}", "", indent, value.is_object() ? "}" : "]");
}

}  // namespace

Json json_number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json json_rows(const std::vector<Motion<double>>& accelerations) {
  Json rows = Json::array();
  for (const auto& a : accelerations) rows.push_back(six(a.angular, a.linear));
  return rows;
}

Json json_rows(const std::vector<Wrench<double>>& wrenches) {
  Json rows = Json::array();
  for (const auto& f : wrenches) rows.push_back(six(f.moment, f.force));
  return rows;
}

Json json_names(const Model& model) {
  Json bodies = Json::array();
  for (const BodySpec& body : model.spec().bodies) bodies.push_back(body.name);
  return {{"velocities", model.velocity_names()},
          {"bodies", bodies},
          {"drives", model.drive_names()},
          {"closure_rows", model.closures().row_names}};
}

std::string json_text(const Json& document) {
  std::string text;
  append(text, document, 0);
  return text + "\n";
}

std::string force_unit(std::string_view coordinate_unit) { return coordinate_unit == "m" ? "N" : "N m"; }

std::string acceleration_unit(std::string_view velocity_unit) { return std::string(velocity_unit) + "²"; }

std::string acceleration_table(const Model& model, const std::vector<Motion<double>>& accelerations) {
  TextTable table({"body", "ω̇x [rad/s²]", "ω̇y", "ω̇z", "v̇x [m/s²]", "v̇y", "v̇z"});
  for (int i = 0; i < model.bodies(); ++i) {
    std::vector<std::string> cells = {model.spec().bodies[i].name};
    add_six(cells, accelerations[i].angular, accelerations[i].linear);
    table.row(std::move(cells));
  }
  if (table.empty()) return {};
  return "\nBody accelerations (of the reference point, world axes)\n" + table.text();
}

std::string wrench_table(const Model& model, const std::vector<Wrench<double>>& wrenches) {
  TextTable table({"joint", "from", "on body", "mx [N m]", "my", "mz", "fx [N]", "fy", "fz"}, 3);
  for (int i = 0; i < model.bodies(); ++i) {
    const JointSpec& joint = model.spec().joints[i];
    std::vector<std::string> cells = {joint.name, joint.parent.empty() ? "ground" : joint.parent, joint.body};
    add_six(cells, wrenches[i].moment, wrenches[i].force);
    table.row(std::move(cells));
  }
  if (table.empty()) return {};
  return "\nJoint wrenches (about the reference point of the body they act on, world axes)\n" + table.text();
}

std::string drive_table(const Model& model, const std::vector<double>& forces) {
  TextTable table({"prescribed coordinate", "drive force", "unit"});
  const std::vector<std::string> names = model.drive_names();
  for (int d = 0; d < model.drives(); ++d)
    table.row(
        {names[d], table_number(forces[d]), force_unit(model.link(model.body_of_drive(d)).kind.traits().q_units[0])});
  if (table.empty()) return {};
  return "\nDrive forces (of prescribed motions)\n" + table.text();
}

}  // namespace lanc
