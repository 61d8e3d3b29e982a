#include "formulations/recursive-loops/free_delassus.h"

#include <algorithm>
#include <cmath>

namespace lanc {
namespace {

struct FreeBody {
  double by_force, by_moment;  // 1/m, 1/(½ tr J_c)
  Vec3<double> centre;
};

}  // namespace

std::vector<double> free_delassus_diagonal(const Model& model) {
  double mean = 0;
  for (const Link& link : model.links()) mean += std::abs(link.inertia.mass) / model.bodies();
  if (!(mean > 0)) mean = 1;
  constexpr double small = 0.01;
  const auto free = [&](int body) {
    const RigidInertia<double>& M = model.link(body).inertia;
    const double mass = std::max(M.mass, small * mean);
    const Vec3<double> c = M.mass > 0 ? M.h * (1 / M.mass) : Vec3<double>{};
    const double half_trace = (M.J.xx + M.J.yy + M.J.zz) / 2 - M.mass * dot(c, c);
    return FreeBody{1 / mass, 1 / std::max(half_trace, small * mass * model.length() * model.length()), c};
  };
  const ClosureSet& set = model.closures();
  std::vector<double> diagonal(set.rows(), 0.0);
  for (const Closure& closure : set.closures)
    for (const auto& [body, point] : {std::pair{closure.body_a, closure.point_a}, {closure.body_b, closure.point_b}}) {
      if (body == ground) continue;
      const FreeBody b = free(body);
      const Vec3<double> arm = point - b.centre;
      for (int k = closure.row; k < closure.row + closure.conditions().count; ++k)
        diagonal[k] += set.row_is_length[k] ? b.by_force + dot(arm, arm) * b.by_moment : b.by_moment;
    }
  for (const Coupler& coupler : set.couplers)
    for (const Coupler::Term& term : coupler.terms) {
      const FreeBody b = free(model.body_of_velocity(term.v));
      const bool length = model.column_kind(term.v) == ColumnKind::translation;
      diagonal[coupler.row] += term.factor * term.factor * (length ? b.by_force : b.by_moment);
    }
  return diagonal;
}

}  // namespace lanc
