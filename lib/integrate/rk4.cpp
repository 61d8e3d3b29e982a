#include "lib/integrate/rk4.h"

#include <cmath>

namespace lanc {
namespace {

/// The classical fourth-order method of Runge and Kutta with steps of equal length; the last one before a limit ends
/// there, and one that cannot be evaluated is divided. The same numbers in the same order whatever happens between
/// steps, so that a run can be continued bit by bit.
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
    const double end = t_ + step_ * (1 + 1e-9) >= limit ? limit : t_ + step_;
    if (!advance(end, most_halvings)) return false;
    ++counts_.steps;
    return true;
  }

  double next_step() const override { return step_; }

 private:
  /// In two halves where an evaluation says that nearer states may do, and so on.
  bool advance(double end, int halvings) {
    const Evaluation evaluation = try_step(end);
    if (evaluation == Evaluation::fine) {
      if (form_.settle(t_, y_) != Settled::failed) return true;
    } else if (evaluation == Evaluation::retry && halvings > 0) {
      ++counts_.rejected;
      const double middle = t_ + (end - t_) / 2;
      return advance(middle, halvings - 1) && advance(end, halvings - 1);
    }
    message_ = form_.outcome().message;
    return false;
  }

  Evaluation try_step(double end) {
    const double h = end - t_;
    const auto rate = [&](double t, const std::vector<double>& y, std::vector<double>& k) {
      return form_.rate(t, y.data(), k.data());
    };
    const auto at = [&](double c, const std::vector<double>& k) -> const std::vector<double>& {
      for (std::size_t i = 0; i < y_.size(); ++i) trial_[i] = y_[i] + c * h * k[i];
      return trial_;
    };
    Evaluation last = rate(t_, y_, k1_);
    if (last == Evaluation::fine) last = rate(t_ + h / 2, at(0.5, k1_), k2_);
    if (last == Evaluation::fine) last = rate(t_ + h / 2, at(0.5, k2_), k3_);
    if (last == Evaluation::fine) last = rate(end, at(1, k3_), k4_);
    if (last != Evaluation::fine) return last;
    for (std::size_t i = 0; i < y_.size(); ++i) y_[i] += h / 6 * (k1_[i] + 2 * (k2_[i] + k3_[i]) + k4_[i]);
    t_ = end;
    return last;
  }

  static constexpr int most_halvings = 8;
  OdeForm& form_;
  double step_;
  std::vector<double> k1_, k2_, k3_, k4_, trial_;
};

}  // namespace

std::unique_ptr<Stepper> create_rk4(MotionForm& form, const StepperOptions& options) {
  return std::make_unique<Rk4>(dynamic_cast<OdeForm&>(form), options);
}

}  // namespace lanc
