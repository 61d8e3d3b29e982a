#include "lib/integrate/branch_choice.h"

#include <algorithm>
#include <cmath>

#include "lib/closure/branch.h"
#include "lib/system/energy.h"
#include "lib/system/mass_matrix.h"

namespace lanc {
namespace {

State<double> with_velocities(State<double> state, const Eigen::VectorXd& v) {
  state.v.assign(v.begin(), v.end());
  return state;
}

}  // namespace

std::optional<BranchStart> choose_branch(MotionSolver& solver, const State<double>& near, int choice) {
  constexpr double way = 1e-3;
  const Model& model = solver.model();
  const int rank = solver.policy().rank;
  if (model.nv() - rank != 1) return std::nullopt;
  std::optional<SingularPoint> singular = locate_singular_point(model, near, rank);
  if (!singular || singular->tangents.empty()) return std::nullopt;

  const ClosureScaling scaling(model);
  const Eigen::Map<const Eigen::VectorXd> unit(scaling.column.data(), model.nv()), v(near.v.data(), model.nv());
  Evaluator<double> evaluator(model);
  const std::vector<double> mass = mass_matrix(evaluator.system(singular->state));
  const Eigen::Map<const Eigen::MatrixXd> M(mass.data(), model.nv(), model.nv());
  struct Candidate {
    Eigen::VectorXd direction, scaled;  // velocities; along, not against, the present ones
    double along, straight;             // of v, in the metric M̄; cosine of the angle between them
  };
  std::vector<Candidate> candidates;
  const double size = std::sqrt(v.dot(M * v));
  for (const Eigen::VectorXd& tangent : singular->tangents) {
    Eigen::VectorXd direction = tangent.cwiseProduct(unit);
    const double part = direction.dot(M * v), norm2 = direction.dot(M * direction);
    const double sign = part < 0 ? -1 : 1;
    candidates.push_back({sign * direction, sign * tangent, std::abs(part) / norm2,
                          std::abs(part) / (std::sqrt(norm2) * std::max(size, 1e-300))});
  }
  std::sort(candidates.begin(), candidates.end(), [](const auto& a, const auto& b) { return a.straight > b.straight; });
  if (choice < 1 || choice > static_cast<int>(candidates.size())) return std::nullopt;
  const Candidate& chosen = candidates[choice - 1];
  if (!(chosen.along > 0)) return std::nullopt;  // the velocities have no part in it

  const State<double> before = with_velocities(singular->state, v),
                      crossing = with_velocities(singular->state, chosen.along * chosen.direction);
  BranchStart result;
  result.branches = static_cast<int>(candidates.size());
  result.energy_change = energy(evaluator, crossing).kinetic - energy(evaluator, before).kinetic;
  const double energy_here = energy(evaluator, near).total() + result.energy_change;
  result.crossing = near.t;

  // a little way along the branch; the speed there by the energy, the time by the mean of both speeds
  const BranchTracer tracer(model, singular->state, rank, chosen.scaled);
  const std::optional<BranchPoint> behind = tracer.at(way);
  if (!behind) return std::nullopt;
  const Eigen::VectorXd tangent = behind->tangent.cwiseProduct(unit);
  const Energy<double> at_unit_speed = energy(evaluator, with_velocities(behind->state, tangent));
  const double speed2 = (energy_here - at_unit_speed.potential) / at_unit_speed.kinetic;
  if (!(speed2 > 0)) return std::nullopt;  // it turns back before
  const double speed = std::sqrt(speed2);
  result.state = with_velocities(behind->state, speed * tangent);
  result.state.t = near.t + 2 * way / (speed + chosen.along);
  return result;
}

}  // namespace lanc
