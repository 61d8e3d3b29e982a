#include <fmt/format.h>

#include <Eigen/Eigenvalues>

#include "experiments/inspect/mechanism_report.h"

namespace lanc {
namespace {

Eigen::Vector3d principal_inertias(const BodySpec& body) {
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(body.inertia, Eigen::EigenvaluesOnly).eigenvalues();
}

std::optional<std::string> inertia_warning(const BodySpec& body) {
  if (body.mass == 0 && body.inertia.isZero(0))
    return "massless; what it carries must give inertia to each of its freedoms";
  if (body.inertia.isZero(0)) return "a point mass: no inertia about its own centre";
  const Eigen::Vector3d e = principal_inertias(body);
  if (e[0] < -1e-12 * e[2]) return fmt::format("nonphysical inertia: negative principal value {:.4g} kg m²", e[0]);
  if (e[0] + e[1] < e[2] * (1 - 1e-9))
    return fmt::format("nonphysical inertia: principal values {:.4g}, {:.4g}, {:.4g} violate the triangle inequality",
                       e[0], e[1], e[2]);
  if (e[0] < 1e-8 * e[2]) return "slender: no inertia about one axis";
  return std::nullopt;
}

}  // namespace

std::vector<Warning> warnings(const Model& model) {
  std::vector<Warning> list;
  for (int i = 0; i < model.bodies(); ++i) {
    const BodySpec& body = model.spec().bodies[i];
    const Link& link = model.link(i);
    const bool frame = link.nv == 0 && body.mass == 0 && body.inertia.isZero(0);
    if (frame)
      list.push_back({body.name, "massless and without a freedom of its own: a frame"});
    else if (const auto text = inertia_warning(body))
      list.push_back({body.name, *text});
    bool armature = link.nv > 0;
    for (int k = link.v; k < link.v + link.nv; ++k) armature = armature && model.armature()[k] > 0;
    if (link.leaf && link.nv > 0 && body.mass == 0 && body.inertia.isZero(0) && !armature)
      list.push_back({model.spec().joints[i].name, "moves a massless body that carries nothing: no solution"});
  }
  return list;
}

}  // namespace lanc
