#include "lib/formulation/inertia_rank.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <limits>

namespace lanc {

int inertia_rank(const Model& model, int body) {
  const BodySpec& spec = model.spec().bodies[body];
  const Eigen::Vector3d principal =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spec.inertia, Eigen::EigenvaluesOnly).eigenvalues().cwiseAbs();
  // against the inertia about the reference point: a rounded zero of a body far from its centre of mass is a zero
  const double scale = std::max(principal.maxCoeff(), spec.mass * spec.com.squaredNorm());
  int rank = spec.mass != 0 ? 3 : 0;
  for (const double J : principal) rank += J > 16 * std::numeric_limits<double>::epsilon() * scale;
  return rank;
}

std::vector<int> articulated_rank_bound(const Model& model) {
  std::vector<int> rank(model.bodies(), 0);
  for (int i = model.bodies() - 1; i >= 0; --i) {
    rank[i] = std::min(6, rank[i] + inertia_rank(model, i));
    const Link& link = model.link(i);
    if (link.parent == ground) continue;
    int handed_down = rank[i];
    for (int k = link.v; k < link.v + link.nv; ++k) handed_down -= model.armature()[k] == 0;
    rank[link.parent] = std::min(6, rank[link.parent] + std::max(0, handed_down));
  }
  return rank;
}

}  // namespace lanc
