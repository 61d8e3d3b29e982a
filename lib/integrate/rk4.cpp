#include "lib/integrate/rk4.h"

#include <cmath>

namespace lanc {
namespace {

/// The classical fourth-order method of Runge and Kutta with steps of equal length; the last one before a limit ends
/// there. The same numbers in the same order whatever happens between steps, so that a run can be continued bit by bit.
class Rk4 : public Stepper {
 public:
  Rk4(OdeForm& form, const StepperOptions& options) : form_(form), step_(options.step) {
    const int n = form.size();
    for (std::vector<double>* k : {&k1_, &k2_, &k3_, &k4_, &trial_}) k->resize(n);
  }

  void start(double t, std::span<const double> y) override {
    t_ = t;
    y_.assign(y.begin(), y.end());
  }

  bool step(double limit) override {
    // a remainder that is rounding only belongs to this step
    const bool last = t_ + step_ * (1 + 1e-9) >= limit;
    const double end = last ? limit : t_ + step_, h = end - t_;
    const auto stage = [&](double c, const std::vector<double>& k) {
      for (std::size_t i = 0; i < y_.size(); ++i) trial_[i] = y_[i] + c * h * k[i];
      return trial_.data();
    };
    if (!good(form_.rate(t_, y_.data(), k1_.data())) ||
        !good(form_.rate(t_ + h / 2, stage(0.5, k1_), k2_.data())) ||
        !good(form_.rate(t_ + h / 2, stage(0.5, k2_), k3_.data())) ||
        !good(form_.rate(end, stage(1, k3_), k4_.data())))
      return false;
    for (std::size_t i = 0; i < y_.size(); ++i) y_[i] += h / 6 * (k1_[i] + 2 * (k2_[i] + k3_[i]) + k4_[i]);
    t_ = end;
    ++counts_.steps;
    if (form_.settle(t_, y_) != Settled::failed) return true;
    message_ = form_.outcome().message;
    return false;
  }

  double next_step() const override { return step_; }

 private:
  bool good(Evaluation evaluation) {
    if (evaluation == Evaluation::fine) return true;
    message_ = form_.outcome().message;
    return false;
  }

  OdeForm& form_;
  double step_;
  std::vector<double> k1_, k2_, k3_, k4_, trial_;
};

}  // namespace

std::unique_ptr<Stepper> create_rk4(MotionForm& form, const StepperOptions& options) {
  return std::make_unique<Rk4>(dynamic_cast<OdeForm&>(form), options);
}

}  // namespace lanc
