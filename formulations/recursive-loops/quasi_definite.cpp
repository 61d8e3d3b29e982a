#include "formulations/recursive-loops/quasi_definite.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "formulations/recursive-loops/free_delassus.h"
#include "lib/system/equations.h"

namespace lanc {
namespace {

/// μ and ρ relative to what the body alone would have in their place. Smaller ones need fewer steps, larger ones leave
/// more digits to each: pivots of f̂ meet 1/ρ.
constexpr double relative_mu = 1e-10, relative_rho = 1e-7;
constexpr int most_steps = 30;
/// Of the answer: where steps end; and what a step may be, and what it may leave open of the closures, when steps have
/// come to the rounding errors of large wrenches, and get no smaller.
constexpr double converged = 1e-13, acceptable = 1e-7;

void add(const Solution<double>& step, Solution<double>& solution) {
  for (std::size_t k = 0; k < solution.vdot.size(); ++k) solution.vdot[k] += step.vdot[k];
  for (std::size_t i = 0; i < solution.wrench.size(); ++i) {
    solution.acceleration[i] += step.acceleration[i];
    solution.wrench[i] += step.wrench[i];
  }
  for (std::size_t k = 0; k < solution.lambda.size(); ++k) solution.lambda[k] += step.lambda[k];
}

double half_trace(const RigidInertia<double>& M) { return (M.J.xx + M.J.yy + M.J.zz) / 2; }

}  // namespace

QuasiDefinite::QuasiDefinite(const Model& model)
    : model_(model),
      matrix_(model, {.upper_triangle = true}),
      starts_{0},
      free_(free_delassus_diagonal(model)),
      sign_(matrix_.size(), 1.0),
      shift_(matrix_.size()),
      residual_(model),
      step_(model),
      b_(matrix_.size()),
      x_(matrix_.size()) {
  for (int c = 0; c < matrix_.size(); ++c) {
    const int end = matrix_.starts()[c + 1];
    rows_.insert(rows_.end(), matrix_.rows().begin() + matrix_.starts()[c], matrix_.rows().begin() + end);
    if (matrix_.starts()[c] == end || rows_.back() != c) rows_.push_back(c);
    starts_.push_back(static_cast<int>(rows_.size()));
  }
  values_.resize(rows_.size());
  // for the sample of eq. 14: anything of the right sign
  for (int i = 0; i < model.bodies(); ++i) {
    std::fill_n(sign_.begin() + matrix_.column(i, Block::wrench), 6, -1.0);
    std::fill_n(shift_.begin() + matrix_.column(i, Block::wrench), 6, -1.0);
    std::fill_n(shift_.begin() + matrix_.column(i, Block::velocity), model.link(i).nv, 1.0);
  }
  for (int k = 0; k < model.closures().rows(); ++k) {
    sign_[matrix_.column(k, Block::closure)] = -1;
    shift_[matrix_.column(k, Block::closure)] = -2;
  }
  fill();
  solver_ = make_cholmod(view(), {.order = EliminationOrder::amd});
}

SparseView QuasiDefinite::view() const { return {matrix_.size(), starts_.data(), rows_.data(), values_.data()}; }

void QuasiDefinite::fill() {
  for (int c = 0; c < matrix_.size(); ++c) {
    const int begin = matrix_.starts()[c], count = matrix_.starts()[c + 1] - begin;
    double& diagonal = values_[starts_[c + 1] - 1];
    diagonal = 0;
    std::copy_n(matrix_.values().begin() + begin, count, values_.begin() + starts_[c]);
    diagonal += shift_[c];
  }
}

/// ρ and −μ, `strength` times; rows that do not count have 1 on the diagonal of eq. 14, and −1 after this.
void QuasiDefinite::regularise(const System<double>& system, std::span<const char> independent, double strength) {
  const double mu = strength * relative_mu, rho = strength * relative_rho;
  for (int i = 0; i < model_.bodies(); ++i) {
    const RigidInertia<double>& M = system.bodies[i].inertia;
    const double turning = half_trace(M);
    double* const f = shift_.data() + matrix_.column(i, Block::wrench);
    for (int k = 0; k < 3; ++k) f[k] = -mu / turning, f[3 + k] = -mu / M.mass;
    const Link& link = model_.link(i);
    for (int k = link.v; k < link.v + link.nv; ++k) {
      const bool slides = model_.column_kind(k) == ColumnKind::translation;
      shift_[matrix_.column(i, Block::velocity) + k - link.v] =
          model_.armature()[k] != 0 ? 0 : rho * (slides ? M.mass : turning);
    }
  }
  for (int k = 0; k < model_.closures().rows(); ++k)
    shift_[matrix_.column(k, Block::closure)] = independent[k] ? -mu * free_[k] : -2;
}

bool QuasiDefinite::factorise(const System<double>& system, std::span<const char> independent) {
  independent_.assign(independent.begin(), independent.end());
  matrix_.refill(system, independent);
  // Rounding may make a pivot vanish that ρ and μ keep from zero, then ten times as much does.
  for (const double strength : {1.0, 10.0}) {
    regularise(system, independent, strength);
    fill();
    if (solver_->factorise(view()).result == Factorisation::Result::done && signs_are_right()) return true;
  }
  return false;
}

bool QuasiDefinite::signs_are_right() const {
  const LdlFactors f = solver_->factors();
  for (int j = 0; j < matrix_.size(); ++j)
    if (!(f.values[f.starts[j]] * sign_[f.order[j]] > 0)) return false;
  return true;
}

/// The largest acceleration of the solution in m/s², rotations times the model's length.
double QuasiDefinite::size(const Solution<double>& solution) const {
  double largest = 0;
  for (int k = 0; k < model_.nv(); ++k) {
    const double unit = model_.column_kind(k) == ColumnKind::translation ? 1 : model_.length();
    if (const double x = std::abs(solution.vdot[k]) * unit; !(x <= largest)) largest = x;
  }
  return largest;
}

/// With what accelerations the loads would move the bodies one by one, and conditions ask for: an equilibrium has η̇ = 0
/// and still a size.
double QuasiDefinite::size(const System<double>& system, const RightHandSide<double>& rhs) const {
  double largest = 0;
  for (int i = 0; i < model_.bodies(); ++i) {
    const auto length = [](const Vec3<double>& a) { return std::sqrt(dot(a, a)); };
    const RigidInertia<double>& M = system.bodies[i].inertia;
    const double pulled = length(rhs.force[i].force) / M.mass;
    const double turned = length(rhs.force[i].moment) / half_trace(M) * model_.length();
    const Motion<double>& bias = rhs.bias[i];
    largest = std::max({largest, pulled, turned, length(bias.linear), length(bias.angular) * model_.length()});
  }
  return largest;
}

void QuasiDefinite::substitute(const System<double>& system, const RightHandSide<double>& rhs,
                               Solution<double>& solution) {
  const auto solve = [&](const RightHandSide<double>& b, Solution<double>& x) {
    matrix_.scatter(b, b_);
    solver_->solve(view(), b_, x_);
    matrix_.gather(x_, x);
  };
  solve(rhs, solution);
  const double loads = size(system, rhs);
  double change = std::numeric_limits<double>::infinity(), open = change, unit = 0;
  for (steps_ = 0; steps_ < most_steps; ++steps_) {
    residual(system, rhs, solution, residual_);
    solve(residual_, step_);
    add(step_, solution);
    const double last = change;
    unit = std::max(size(solution), loads);
    change = size(step_);
    open = open_closures();
    if (change <= converged * unit && open <= converged * unit) break;
    const bool settled = change <= acceptable * unit && open <= acceptable * unit;
    if (settled && change > last / 2) break;  // rounding errors of the residual
  }
  if (!(change <= acceptable * unit && open <= acceptable * unit))
    std::fill(solution.vdot.begin(), solution.vdot.end(), std::numeric_limits<double>::quiet_NaN());
}

/// What the answer before the last step left open of the conditions that count, as `size`.
double QuasiDefinite::open_closures() const {
  double largest = 0;
  for (std::size_t k = 0; k < independent_.size(); ++k) {
    const double unit = model_.closures().row_is_length[k] ? 1 : model_.length();
    if (const double x = std::abs(residual_.closure[k]) * unit; independent_[k] && !(x <= largest)) largest = x;
  }
  return largest;
}

}  // namespace lanc
