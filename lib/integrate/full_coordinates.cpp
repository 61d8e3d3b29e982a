#include "lib/integrate/full_coordinates.h"

#include "lib/model/coordinates.h"

namespace lanc {

Evaluation evaluation_of(const Outcome& outcome, const RankPolicy& policy) {
  switch (outcome.status) {
    case Status::solved:
    case Status::redundant: return Evaluation::fine;
    case Status::not_converged:
    case Status::not_finite:
    case Status::inconsistent: return Evaluation::retry;
    case Status::singular: return policy.smallest > 0 ? Evaluation::retry : Evaluation::stop;
    default: return Evaluation::stop;
  }
}

FullCoordinates::FullCoordinates(MotionSolver& solver, Stabilisation stabilisation, double alpha)
    : solver_(solver),
      differentiator_(solver.model(), solver.loads()),
      stabilisation_(stabilisation),
      alpha_(stabilisation == Stabilisation::baumgarte ? alpha : 0),
      nq_(solver.model().nq()),
      nv_(solver.model().nv()),
      rhs_(solver.model()),
      answer_(solver.model()) {
  scale_ = position_scale(solver.model());
  const std::vector<double> speeds = velocity_scale(solver.model());
  scale_.insert(scale_.end(), speeds.begin(), speeds.end());
  scale_.push_back(1);
}

void FullCoordinates::pack(const MotionPoint& point, double* y) const {
  std::copy(point.state.q.begin(), point.state.q.end(), y);
  std::copy(point.state.v.begin(), point.state.v.end(), y + nq_);
  y[nq_ + nv_] = point.work;
}

MotionPoint FullCoordinates::unpack(double t, const double* y) const {
  MotionPoint point{{t, {y, y + nq_}, {y + nq_, y + nq_ + nv_}}, y[nq_ + nv_]};
  normalise(solver_.model(), point.state.q.data());
  return point;
}

/// Near a singular configuration, where the weakest condition is hardly stronger than what the state violates, it
/// cannot be told from a redundant one: the evaluation is then made at the nearest state that obeys the conditions. On
/// these nothing changes, so that the order of the method is kept.
Outcome FullCoordinates::solve(State<double>& state) {
  constexpr double clear = 1e-3;
  Outcome outcome = solver_.solve(state, alpha_);
  const bool weak = solver_.policy().smallest > 0 && stabilisation_ == Stabilisation::projection &&
                    solver_.position_violation() > clear * outcome.sigma;
  if (!weak) return outcome;
  outcome = solver_.project(state);
  return outcome.usable() ? solver_.solve(state, alpha_) : outcome;
}

Evaluation FullCoordinates::rate(double t, const double* y, double* ydot) {
  State<double> state = unpack(t, y).state;
  outcome_ = solve(state);
  if (!outcome_.usable()) return evaluation_of(outcome_, solver_.policy());
  coordinate_rates(solver_.model(), state.q.data(), state.v.data(), ydot);
  std::copy(solver_.solution().vdot.begin(), solver_.solution().vdot.end(), ydot + nq_);
  ydot[nq_ + nv_] = solver_.power().total();
  return Evaluation::fine;
}

/// M̄ ∂η̇ − Gᵀ ∂λ = −∂r and G ∂η̇ + ∂g̈ = 0, ∂r and ∂g̈ at constant η̇ and λ. Nothing depends on the work; that the
/// work's own row is left out costs Newton's method one more iteration for this number.
Evaluation FullCoordinates::jacobian(double t, const double* y, double* J) {
  State<double> state = unpack(t, y).state;
  outcome_ = solve(state);
  if (!outcome_.usable()) return evaluation_of(outcome_, solver_.policy());
  const MotionDerivatives& d = differentiator_.at(state, solver_.solution().vdot, solver_.solution().lambda);
  solver_.counts().add_derivatives(differentiator_.passes());
  const int n = size();
  std::fill(J, J + static_cast<std::ptrdiff_t>(n) * n, 0.0);
  for (int c = 0; c < nq_ + nv_; ++c) {
    rhs_.set_zero();
    for (int k = 0; k < nv_; ++k) rhs_.tau[k] = -d.balance(k, c);
    for (std::size_t k = 0; k < rhs_.closure.size(); ++k)
      rhs_.closure[k] = d.acceleration(k, c) + alpha_ * (2 * d.velocity(k, c) + alpha_ * d.position(k, c));
    solver_.respond(rhs_, answer_);
    double* column = J + static_cast<std::ptrdiff_t>(c) * n;
    for (int k = 0; k < nq_; ++k) column[k] = d.coordinate_rate(k, c);
    for (int k = 0; k < nv_; ++k) column[nq_ + k] = answer_.vdot[k];
  }
  return Evaluation::fine;
}

Settled FullCoordinates::settle(double t, std::span<double> y) {
  MotionPoint point = unpack(t, y.data());
  if (stabilisation_ == Stabilisation::projection) {
    outcome_ = solver_.project(point.state);
    if (!outcome_.usable()) return Settled::failed;
  }
  pack(point, y.data());
  return Settled::kept;
}

}  // namespace lanc
