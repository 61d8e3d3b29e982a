#include "lib/integrate/generalized_alpha.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "lib/integrate/residual_form.h"
#include "lib/model/coordinates.h"
#include "lib/solve/dense_algebra.h"

namespace lanc {
namespace {

/// The generalized-α method of Chung & Hulbert for the index-3 equations, on the group of the joints' motions
/// (Arnold & Brüls 2007, Multibody Syst. Dyn. 18, 185-202; Brüls, Cardona & Arnold 2012, Mech. Mach. Theory 48,
/// 121-137): second order, closure conditions held at the level of positions. Newton's method with exact derivatives,
/// renewed when it becomes slow.
class GeneralizedAlpha : public Stepper {
 public:
  GeneralizedAlpha(ResidualForm& form, const StepperOptions& options) : form_(form), step_(options.step) {
    const double rho = options.spectral_radius;
    alpha_m_ = (2 * rho - 1) / (rho + 1);
    alpha_f_ = rho / (rho + 1);
    gamma_ = 0.5 + alpha_f_ - alpha_m_;
    beta_ = 0.25 * (gamma_ + 0.5) * (gamma_ + 0.5);
  }

  void start(double t, std::span<const double> y) override {
    t_ = t;
    y_.assign(y.begin(), y.end());
    const MotionPoint point = form_.unpack(t, y.data());
    started_ = form_.start(point.state, vdot_, lambda_).usable();
    a_ = vdot_;
    if (started_) power_ = form_.residual(point.state, vdot_, lambda_).power;
  }

  bool step(double limit) override {
    if (!started_) return message_ = form_.outcome().message, false;
    const bool last = t_ + step_ * (1 + 1e-9) >= limit;
    const double end = last ? limit : t_ + step_, h = end - t_;
    const MotionPoint before = form_.unpack(t_, y_.data());
    const Eigen::VectorXd v = Eigen::Map<const Eigen::VectorXd>(before.state.v.data(), a_.size());
    // the new a follows from the new η̇: a = a0 + c η̇, which begins with the old η̇
    const double c = (1 - alpha_f_) / (1 - alpha_m_);
    const Eigen::VectorXd a0 = (alpha_f_ * vdot_ - alpha_m_ * a_) / (1 - alpha_m_), guess = a0 + c * vdot_;
    Trial trial{before.state, v + h * ((0.5 - beta_) * a_ + beta_ * guess),
                v + h * ((1 - gamma_) * a_ + gamma_ * guess), vdot_, lambda_};
    trial.state.t = end;
    if (!newton(before.state, h, trial)) return false;
    a_ = a0 + c * trial.vdot;
    vdot_ = trial.vdot, lambda_ = trial.lambda;
    const double power = form_.residual(trial.state, vdot_, lambda_).power;
    form_.pack({trial.state, before.work + h / 2 * (power_ + power)}, y_.data());
    power_ = power;
    t_ = end;
    ++counts_.steps;
    return true;
  }

  double next_step() const override { return step_; }

 private:
  struct Trial {
    State<double> state;
    Eigen::VectorXd u, v;  // mean velocity over the step, velocity at its end
    Eigen::VectorXd vdot, lambda;
  };

  /// Unknowns: the displacement x = h u and λ; η and η̇ change with x by γ' and β'.
  bool newton(const State<double>& before, double h, Trial& trial) {
    constexpr double tolerance = 1e-12;
    constexpr int most_iterations = 25, slow = 5;
    const double beta = (1 - alpha_m_) / (h * h * beta_ * (1 - alpha_f_)), gamma = gamma_ / (h * beta_);
    const std::vector<double> scale = velocity_scale(form_.model());
    const Eigen::Index nv = trial.v.size(), rows = trial.lambda.size();
    double last = std::numeric_limits<double>::infinity();
    for (int k = 0; k < most_iterations; ++k) {
      const Eigen::VectorXd x = h * trial.u;
      trial.state.q = displaced(form_.model(), before.q, {x.begin(), x.end()});
      trial.state.v.assign(trial.v.begin(), trial.v.end());
      const MotionResidual& r = form_.residual(trial.state, trial.vdot, trial.lambda);
      if (!r.balance.allFinite()) return failed(Status::not_finite, "the equations of motion are not finite");
      if (k % slow == 0) factorise(trial, beta, gamma);
      Eigen::VectorXd rhs(nv + rows);
      rhs << -r.balance / beta, -r.position;
      const Eigen::VectorXd change = iteration_.solve(rhs);
      trial.u += change.head(nv) / h;
      trial.v += gamma * change.head(nv);
      trial.vdot += beta * change.head(nv);
      trial.lambda += beta * change.tail(rows);
      ++counts_.newton_iterations;
      double size = 0;
      for (Eigen::Index i = 0; i < nv; ++i) size = std::max(size, std::abs(change[i]) / scale[i]);
      // as far as rounding allows, once it is small
      if (size < tolerance || (size < 1e3 * tolerance && size > last / 2)) {
        const Eigen::VectorXd end = h * trial.u;
        trial.state.q = displaced(form_.model(), before.q, {end.begin(), end.end()});
        trial.state.v.assign(trial.v.begin(), trial.v.end());
        return true;
      }
      last = size;
    }
    return failed(Status::not_converged, fmt::format("Newton's method of generalized-alpha does not converge from "
                                                     "t = {:.9g} s with a step of {:.3g} s; choose a smaller one",
                                                     t_, h));
  }

  /// [M̄ + γ'/β' C + K/β', −Gᵀ; G, 0], the first rows and λ divided by β' so that small steps do not spoil it.
  void factorise(const Trial& trial, double beta, double gamma) {
    const Eigen::Index nv = trial.v.size(), rows = trial.lambda.size(), nq = form_.model().nq();
    const MotionDerivatives& d = form_.derivatives(trial.state, trial.vdot, trial.lambda);
    const auto damping = d.balance.rightCols(nv);
    const auto G = d.velocity.rightCols(nv);
    // dq = H dx: the rate of the coordinates depends on η linearly
    const Eigen::MatrixXd K = d.balance.leftCols(nq) * d.coordinate_rate.rightCols(nv);
    Eigen::MatrixXd S = Eigen::MatrixXd::Zero(nv + rows, nv + rows);
    S.topLeftCorner(nv, nv) = form_.mass() + gamma / beta * damping + K / beta;
    S.topRightCorner(nv, rows) = -G.transpose();
    S.bottomLeftCorner(rows, nv) = G;
    iteration_.compute(S);
  }

  bool failed(Status status, std::string message) {
    message_ = message;
    form_.fail(status, std::move(message));
    return false;
  }

  ResidualForm& form_;
  double step_, alpha_m_, alpha_f_, beta_, gamma_;
  bool started_ = false;
  Eigen::VectorXd vdot_, a_, lambda_;
  double power_ = 0;
  Lu<double> iteration_;
};

}  // namespace

std::unique_ptr<Stepper> create_generalized_alpha(MotionForm& form, const StepperOptions& options) {
  return std::make_unique<GeneralizedAlpha>(dynamic_cast<ResidualForm&>(form), options);
}

}  // namespace lanc
