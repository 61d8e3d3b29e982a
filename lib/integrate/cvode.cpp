#include "lib/integrate/cvode.h"

#include <cvode/cvode.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

#include "lib/integrate/ode_stepper.h"

namespace lanc {
namespace {

struct DeleteNonlinearSolver {
  void operator()(SUNNonlinearSolver s) const { SUNNonlinSolFree(s); }
};

/// Adams by functional iteration, BDF by Newton's method. Steps are the method's own: a limit inside of one is reached
/// by the method's interpolation, which is as accurate as its steps.
class Cvode : public OdeStepper {
 public:
  Cvode(OdeForm& form, const StepperOptions& options, int method) : OdeStepper(form, options), method_(method) {}
  ~Cvode() override { CVodeFree(&memory_); }

  void start(double t, std::span<const double> y) override {
    t_ = reached_ = t;
    y_.assign(y.begin(), y.end());
    std::copy(y.begin(), y.end(), sundials::data(vector_.get()));
    if (memory_) CVodeFree(&memory_);
    memory_ = sundials::needed(CVodeCreate(method_, context_.get()));
    CVodeSetErrHandlerFn(memory_, &sundials::keep_message, &library_message_);
    CVodeInit(memory_, &rate, t, vector_.get());
    CVodeSetUserData(memory_, static_cast<OdeStepper*>(this));
    CVodeSVtolerances(memory_, options_.tolerance, tolerance_.get());
    CVodeSetMaxNumSteps(memory_, sundials::most_steps);
    if (options_.first_step > 0) CVodeSetInitStep(memory_, options_.first_step);
    if (method_ == CV_BDF) {
      newton_.emplace(context_, vector_, form_.size());
      CVodeSetLinearSolver(memory_, newton_->solver.get(), newton_->matrix.get());
      CVodeSetJacFn(memory_, &jacobian);
    } else {
      fixed_point_.reset(sundials::needed(SUNNonlinSol_FixedPoint(vector_.get(), 0, context_.get())));
      CVodeSetNonlinearSolver(memory_, fixed_point_.get());
    }
  }

  bool step(double limit) override {
    if (reached_ <= t_) {  // what the last step reached has been told
      realtype reached = t_;
      if (CVode(memory_, limit, vector_.get(), &reached, CV_ONE_STEP) < 0) return failed();
      reached_ = reached;
      CVodeGetNumSteps(memory_, &counts_.steps);
      CVodeGetNumErrTestFails(memory_, &counts_.rejected);
      CVodeGetNumNonlinSolvIters(memory_, &counts_.newton_iterations);
    }
    t_ = std::min(reached_, limit);
    if (t_ < reached_)
      CVodeGetDky(memory_, t_, 0, vector_.get());
    else
      CVodeGetDky(memory_, reached_, 0, vector_.get());
    double* y = sundials::data(vector_.get());
    y_.assign(y, y + y_.size());
    if (t_ < reached_) return true;
    switch (form_.settle(t_, {y, y_.size()})) {  // of a copy: what the method remembers stays undisturbed
      case Settled::failed: return failed();
      case Settled::renewed:
        y_.assign(y, y + y_.size());
        CVodeReInit(memory_, t_, vector_.get());
        break;
      case Settled::kept: break;
    }
    return true;
  }

  double next_step() const override {
    realtype h = 0;
    CVodeGetCurrentStep(memory_, &h);
    return h;
  }

 private:
  int method_;
  void* memory_ = nullptr;
  double reached_ = 0;
  std::optional<sundials::Newton> newton_;
  std::unique_ptr<std::remove_pointer_t<SUNNonlinearSolver>, DeleteNonlinearSolver> fixed_point_;
};

std::unique_ptr<Stepper> create(MotionForm& form, const StepperOptions& options, int method) {
  return std::make_unique<Cvode>(dynamic_cast<OdeForm&>(form), options, method);
}

}  // namespace

std::unique_ptr<Stepper> create_adams(MotionForm& form, const StepperOptions& options) {
  return create(form, options, CV_ADAMS);
}
std::unique_ptr<Stepper> create_bdf(MotionForm& form, const StepperOptions& options) {
  return create(form, options, CV_BDF);
}

}  // namespace lanc
