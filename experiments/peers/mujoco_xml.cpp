#include "experiments/peers/mujoco_xml.h"

#include <fmt/format.h>

#include <algorithm>

#include "experiments/peers/parts.h"
#include "lib/model/error.h"

namespace lanc::peers {
namespace {

constexpr int deepest_mjcf = 90;  // levels of bodies; tinyxml2 takes 100 levels of elements

std::string numbers(const Eigen::Vector3d& a) { return fmt::format("{:.17g} {:.17g} {:.17g}", a.x(), a.y(), a.z()); }
std::string numbers(const Eigen::Quaterniond& a) {
  return fmt::format("{:.17g} {:.17g} {:.17g} {:.17g}", a.w(), a.x(), a.y(), a.z());
}

int depth(const Model& model) {
  std::vector<int> levels(model.bodies(), 1);
  for (int i = 0; i < model.bodies(); ++i)
    if (const int p = model.link(i).parent; p != ground) levels[i] = levels[p] + 1;
  return *std::max_element(levels.begin(), levels.end());
}

/// A body with its joint and all that it carries.
void write_body(const Model& model, const std::vector<std::vector<int>>& children, int i, std::string& text) {
  const Link& link = model.link(i);
  const BodyMass body(link.inertia);
  // MuJoCo would find the principal axes to 1e-12 only
  const PrincipalFrame principal = body.principal_frame();
  text += fmt::format("<body name=\"b{}\" pos=\"{}\" quat=\"{}\">\n", i, numbers(eigen(link.o)),
                      numbers(Eigen::Quaterniond(eigen(link.X))));
  text += fmt::format("<inertial pos=\"{}\" quat=\"{}\" mass=\"{:.17g}\" diaginertia=\"{}\"/>\n", numbers(body.com),
                      numbers(Eigen::Quaterniond(principal.axes)), body.mass, numbers(principal.moments));
  if (is(link, "free"))
    text += fmt::format("<freejoint name=\"j{}\"/>\n", i);
  else if (!is(link, "fixed"))
    text += fmt::format("<joint name=\"j{}\" type=\"{}\" axis=\"0 0 1\"/>\n", i,
                        is(link, "revolute")    ? "hinge"
                        : is(link, "prismatic") ? "slide"
                                                : "ball");
  for (const int child : children[i]) write_body(model, children, child, text);
  text += "</body>\n";
}

std::string mjcf(const Model& model) {
  std::vector<std::vector<int>> children(model.bodies());
  std::string bodies, equalities;
  for (int i = 0; i < model.bodies(); ++i)
    if (const int p = model.link(i).parent; p != ground) children[p].push_back(i);
  for (int i = 0; i < model.bodies(); ++i)
    if (model.link(i).parent == ground) write_body(model, children, i, bodies);
  const auto name = [](int body) { return body == ground ? std::string("world") : fmt::format("b{}", body); };
  for (const Closure& c : model.closures().closures)
    // anchors and poses follow from zero positions here; mujoco.cpp then writes the true ones
    equalities += fmt::format("<{} body1=\"{}\" body2=\"{}\" {}solimp=\"0.9999 0.9999 1\"/>\n",
                              c.kind.traits().name == "fixed" ? "weld" : "connect", name(c.body_a), name(c.body_b),
                              c.kind.traits().name == "fixed" ? "" : "anchor=\"0 0 0\" ");
  const long nv = model.nv(), rows = model.closures().rows();
  return fmt::format(
      "<mujoco><compiler angle=\"radian\" boundmass=\"0\" boundinertia=\"0\" inertiafromgeom=\"false\"/>\n"
      "<size njmax=\"{}\" nconmax=\"0\" nstack=\"{}\"/>\n<option gravity=\"{}\" solver=\"Newton\"/>\n"
      "<worldbody>\n{}</worldbody>\n<equality>\n{}</equality></mujoco>\n",
      rows + 1, 100000 + 4 * nv * (nv + rows + 100), numbers(eigen(model.gravity())), bodies, equalities);
}

/// Roll, pitch and yaw about fixed axes.
Eigen::Vector3d rpy(const Eigen::Matrix3d& R) {
  const Eigen::Vector3d a = R.eulerAngles(2, 1, 0);
  return {a.z(), a.y(), a.x()};
}

std::string urdf(const Model& model) {
  std::string text =
      "<robot name=\"lanc\">\n<mujoco><compiler fusestatic=\"false\" boundmass=\"0\" boundinertia=\"0\"/></mujoco>\n"
      "<link name=\"ground\"/>\n";
  for (int i = 0; i < model.bodies(); ++i) {
    const Link& link = model.link(i);
    if (!is(link, "revolute") && !is(link, "prismatic") && !is(link, "fixed"))
      throw InputError("mujoco is given trees of more than 90 levels as URDF, which has no such joint");
    const BodyMass body(link.inertia);
    const PrincipalFrame principal = body.principal_frame();
    text += fmt::format("<link name=\"b{}\"><inertial><origin xyz=\"{}\" rpy=\"{}\"/><mass value=\"{:.17g}\"/>", i,
                        numbers(body.com), numbers(rpy(principal.axes)), body.mass);
    text += fmt::format("<inertia ixx=\"{:.17g}\" iyy=\"{:.17g}\" izz=\"{:.17g}\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/>",
                        principal.moments.x(), principal.moments.y(), principal.moments.z());
    text += "</inertial></link>\n";
    text += fmt::format("<joint name=\"j{}\" type=\"{}\"><parent link=\"{}\"/><child link=\"b{}\"/>", i,
                        is(link, "revolute") ? "continuous" : link.kind.traits().name,
                        link.parent == ground ? std::string("ground") : fmt::format("b{}", link.parent), i);
    text += fmt::format("<origin xyz=\"{}\" rpy=\"{}\"/><axis xyz=\"0 0 1\"/></joint>\n", numbers(eigen(link.o)),
                        numbers(rpy(eigen(link.X))));
  }
  return text + "</robot>\n";
}

}  // namespace

std::string mujoco_xml(const Model& model) {
  if (depth(model) <= deepest_mjcf) return mjcf(model);
  if (model.has_closures()) throw InputError("mujoco reads closed loops from MJCF alone, of 90 levels at most");
  return urdf(model);
}

}  // namespace lanc::peers
