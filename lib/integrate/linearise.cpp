#include "lib/integrate/linearise.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <optional>
#include <set>

#include "lib/closure/assembly.h"
#include "lib/closure/explicit.h"
#include "lib/closure/retraction.h"
#include "lib/closure/scaling.h"
#include "lib/derivatives/motion_derivatives.h"
#include "lib/integrate/motion_solver.h"
#include "lib/solve/dense.h"
#include "lib/solve/dense_algebra.h"
#include "lib/solve/eigenvalues.h"
#include "lib/system/equations.h"
#include "lib/system/mass_matrix.h"

namespace lanc {
namespace {

using Matrix = Eigen::MatrixXd;

/// Departures of all velocities' integrals, velocities and accelerations from those of the independent ones:
/// δx = J δs, δη = J δṡ + V δs, δη̇ = J δs̈ + A δṡ + B δs.
constexpr double most_conditioned = 1e12;

struct Departures {
  std::vector<int> independent;
  double condition = 1;
  Matrix J, V, A, B;
};

/// By the derivatives of g, ġ and g̈, whose dependent columns are solved for.
Departures departures(const Model& model, const System<double>& system, const ClosureDecision& decision,
                      const MotionDerivatives& d, const std::vector<int>& chosen) {
  const int nv = model.nv(), nq = model.nq();
  Departures result;
  ExplicitClosures closures(model, {.leave = chosen.empty() ? 1e3 : std::numeric_limits<double>::infinity()});
  if (!chosen.empty()) closures.choose(chosen);
  const ExplicitConditions& conditions = closures.at(system, decision);
  result.independent = conditions.independent;
  result.condition = conditions.condition;
  if (!(result.condition < most_conditioned)) return result;
  result.J = conditions.J;
  const auto f = static_cast<Eigen::Index>(conditions.independent.size());
  result.V = result.A = result.B = Matrix::Zero(nv, f);
  std::vector<int> rows;
  for (int k = 0; k < model.closures().rows(); ++k)
    if (decision.independent[k]) rows.push_back(k);
  if (rows.empty()) return result;
  const Matrix H = d.coordinate_rate.rightCols(nv);
  const auto of = [&](const Matrix& all) { return Matrix(all(rows, Eigen::all)); };
  const Matrix velocity = of(d.velocity), acceleration = of(d.acceleration);
  const Matrix G = velocity.rightCols(nv);
  Lu<double> dependent;
  dependent.compute(G(Eigen::all, conditions.dependent));
  const auto solve = [&](const Matrix& rhs) {
    Matrix x = Matrix::Zero(nv, f);
    x(conditions.dependent, Eigen::all) = -dependent.solve(rhs);
    return x;
  };
  const Matrix dq = H * result.J;
  result.V = solve(velocity.leftCols(nq) * dq);
  result.A = solve(acceleration.rightCols(nv) * result.J);
  result.B = solve(acceleration.leftCols(nq) * dq + acceleration.rightCols(nv) * result.V);
  return result;
}

std::vector<double> row_major(const Matrix& m) {
  std::vector<double> values;
  for (Eigen::Index r = 0; r < m.rows(); ++r)
    for (Eigen::Index c = 0; c < m.cols(); ++c) values.push_back(m(r, c));
  return values;
}

Matrix full_mass(const System<double>& system) {
  const std::vector<double> M = mass_matrix(system);
  return Eigen::Map<const Matrix>(M.data(), system.model.nv(), system.model.nv());
}

}  // namespace

Outcome linearise(const Model& model, const State<double>& state, const std::vector<int>& chosen,
                  LinearisedMotion& result) {
  const FormulationInfo* const formulation = default_formulation();
  if (!formulation) return {Status::objection, "no recursive formulation is registered"};
  MotionSolver solver(model, *formulation, {});
  const Outcome outcome = solver.solve(state);
  if (!outcome.usable() || model.nv() == 0) return outcome;
  const int freedoms = model.nv() - (model.has_closures() ? outcome.rank : 0);
  if (!chosen.empty() && (static_cast<int>(chosen.size()) != freedoms ||
                          static_cast<int>(std::set<int>(chosen.begin(), chosen.end()).size()) != freedoms))
    throw InputError(
        fmt::format("{} independent velocities are named; the mechanism has {} freedoms here, name as many, "
                    "each once",
                    chosen.size(), freedoms));
  ClosureRank<double> rank(model);
  const ClosureDecision& decision = rank.decide(solver.system());
  Differentiator differentiator(model, {});
  const MotionDerivatives& d = differentiator.at(state, solver.solution().vdot, solver.solution().lambda);
  const Departures way = departures(model, solver.system(), decision, d, chosen);
  if (!(way.condition < most_conditioned))
    return {Status::singular, "the velocities named are not independent here: the others do not follow from them"};

  const Matrix M = full_mass(solver.system());
  const Matrix stiffness = d.balance.leftCols(model.nq()) * d.coordinate_rate.rightCols(model.nv());
  const Matrix damping = d.balance.rightCols(model.nv());
  const Matrix Jt = way.J.transpose();
  const Matrix Mr = Jt * M * way.J, Cr = Jt * (damping * way.J + M * way.A),
               Kr = Jt * (stiffness * way.J + damping * way.V + M * way.B);
  result.independent = way.independent;
  result.condition = way.condition;
  result.vdot = solver.solution().vdot;
  result.M = row_major(Mr), result.C = row_major(Cr), result.K = row_major(Kr);
  result.eigenvalues = quadratic_eigenvalues(Mr, Cr, Kr);
  return outcome;
}

namespace {

/// Forces that are out of balance at rest, in independent coordinates, and the stiffness against departures.
struct Unbalance {
  Matrix J;
  Eigen::VectorXd force;  // Jᵀ(b + Gᵀλ) = Jᵀ b
  Matrix stiffness;
  double size = 0;  // of the forces it is made of
};

Unbalance unbalance(const Model& model, const State<double>& state, const Eigen::VectorXd& scale) {
  Evaluator<double> evaluator(model);
  const System<double>& system = evaluator.system(state);
  Solution<double> rest(model);
  std::vector<double> tau(model.nv());
  inverse_dynamics(system, rest, tau);  // η̇ = 0, λ = 0: what would have to be applied
  Eigen::VectorXd r = Eigen::Map<const Eigen::VectorXd>(tau.data(), model.nv());
  Unbalance result;
  result.J = Matrix::Identity(model.nv(), model.nv());
  std::vector<double> lambda(model.closures().rows(), 0.0);
  if (model.has_closures()) {
    ClosureRank<double> rank(model);
    const ClosureDecision& decision = rank.decide(system);
    ExplicitClosures closures(model);
    result.J = closures.at(system, decision).J;
  }
  Differentiator differentiator(model, {});
  const std::vector<double> still(model.nv(), 0.0);
  if (model.has_closures()) {  // the multipliers that balance best
    const Matrix G = differentiator.at(state, still, lambda).velocity.rightCols(model.nv());
    const Eigen::VectorXd best = least_squares(scale.asDiagonal() * G.transpose(), scale.cwiseProduct(r));
    lambda.assign(best.begin(), best.end());
  }
  const MotionDerivatives& d = differentiator.at(state, still, lambda);
  result.force = -(result.J.transpose() * r);
  result.stiffness =
      result.J.transpose() * d.balance.leftCols(model.nq()) * d.coordinate_rate.rightCols(model.nv()) * result.J;
  // weights and springs: the wrenches that the joints carry
  for (int i = 0; i < model.bodies(); ++i) {
    const Wrench<double>& f = system.rhs.force[i];
    result.size =
        std::max({result.size, std::sqrt(dot(f.force, f.force)) * model.length(), std::sqrt(dot(f.moment, f.moment))});
  }
  for (int k = 0; k < model.nv(); ++k) result.size = std::max(result.size, std::abs(system.rhs.tau[k]) * scale[k]);
  return result;
}

/// The step −K⁻¹ force; `downhill`: with |eigenvalues| of the symmetric part, small ones raised.
Eigen::VectorXd newton_step(const Unbalance& u, bool downhill) {
  if (!downhill) return least_squares(u.stiffness, u.force);
  const SymmetricEigen eigen = symmetric_eigen((u.stiffness + u.stiffness.transpose()) / 2);
  const double largest = eigen.values.cwiseAbs().maxCoeff();
  const Eigen::VectorXd steep = eigen.values.cwiseAbs().cwiseMax(1e-6 * largest);
  return eigen.V * (eigen.V.transpose() * u.force).cwiseQuotient(steep);
}

/// The direction in which the potential falls most steeply from a state of rest, if it falls at all.
std::optional<Eigen::VectorXd> unstable(const Unbalance& u) {
  const SymmetricEigen eigen = symmetric_eigen((u.stiffness + u.stiffness.transpose()) / 2);
  if (!(eigen.values[0] < -1e-9 * eigen.values.cwiseAbs().maxCoeff())) return std::nullopt;
  return eigen.V.col(0);
}

}  // namespace

Outcome equilibrium(const Model& model, State<double>& state, const EquilibriumOptions& options) {
  constexpr double accepted = 1e-12, longest = 0.2;
  const ClosureScaling scaling(model);
  const Eigen::Map<const Eigen::VectorXd> scale(scaling.column.data(), model.nv());
  std::fill(state.v.begin(), state.v.end(), 0.0);
  if (model.nv() == 0) return {};
  double left = 0, before = std::numeric_limits<double>::infinity();
  for (int step = 0; step < options.steps; ++step) {
    if (model.has_closures()) {
      const AssemblyResult assembled = assemble(model, state);
      if (!assembled.assembled()) return {Status::inconsistent, assembled.message};
      state.q = assembled.state.q;
    }
    const Unbalance u = unbalance(model, state, scale);
    if (!u.force.allFinite()) return {Status::not_finite, "a force is not finite at rest"};
    if (u.force.size() == 0) return {};
    const Eigen::VectorXd sizes = (u.J.cwiseAbs().transpose() * scale.cwiseInverse()).cwiseInverse();
    left = u.force.cwiseProduct(sizes).cwiseAbs().maxCoeff() / std::max(u.size, 1e-300);
    const bool there = left == 0 || (left < accepted && left > before / 2);  // as far as rounding allows
    if (there && !(options.stable && unstable(u))) return {};
    before = left;
    constexpr double near = 1e-6;  // pure Newton's method from here on
    Eigen::VectorXd x = u.J * (there ? *unstable(u) : newton_step(u, options.stable && left > near));
    const double length = x.cwiseQuotient(scale).cwiseAbs().maxCoeff();
    if (there) x *= longest / length;
    if (!(length < 1e6)) return {Status::singular, "the stiffness is singular: no single state of rest nearby"};
    if (length > longest) x *= longest / length;
    state.q = moved(model, state.q, {x.begin(), x.end()});
  }
  if (left < accepted) return {};
  return {Status::not_converged,
          fmt::format("no state of rest was found in {} steps: {:.1e} of the forces is left", options.steps, left)};
}

}  // namespace lanc
