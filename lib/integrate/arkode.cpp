#include "lib/integrate/arkode.h"

#include <arkode/arkode_arkstep.h>

#include "lib/integrate/ode_stepper.h"

namespace lanc {
namespace {

struct Method {
  ARKODE_ERKTableID explicit_table = ARKODE_ERK_NONE;
  ARKODE_DIRKTableID implicit_table = ARKODE_DIRK_NONE;
};

class Arkode : public OdeStepper {
 public:
  Arkode(OdeForm& form, const StepperOptions& options, Method method) : OdeStepper(form, options), method_(method) {}
  ~Arkode() override { ARKStepFree(&memory_); }

  void start(double t, std::span<const double> y) override {
    t_ = t;
    y_.assign(y.begin(), y.end());
    std::copy(y.begin(), y.end(), sundials::data(vector_.get()));
    if (memory_) ARKStepFree(&memory_);
    const bool implicit = method_.implicit_table != ARKODE_DIRK_NONE;
    memory_ = sundials::needed(
        ARKStepCreate(implicit ? nullptr : &rate, implicit ? &rate : nullptr, t, vector_.get(), context_.get()));
    ARKStepSetErrHandlerFn(memory_, &sundials::keep_message, &library_message_);
    ARKStepSetUserData(memory_, static_cast<OdeStepper*>(this));
    ARKStepSVtolerances(memory_, options_.tolerance, tolerance_.get());
    ARKStepSetMaxNumSteps(memory_, sundials::most_steps);
    ARKStepSetTableNum(memory_, method_.implicit_table, method_.explicit_table);
    ARKStepSetPostprocessStepFn(memory_, &settle);
    if (options_.first_step > 0) ARKStepSetInitStep(memory_, options_.first_step);
    if (implicit) {
      newton_.emplace(context_, vector_, form_.size());
      ARKStepSetLinearSolver(memory_, newton_->solver.get(), newton_->matrix.get());
      ARKStepSetJacFn(memory_, &jacobian);
    }
  }

  bool step(double limit) override {
    ARKStepSetStopTime(memory_, limit);
    settled_ = Settled::kept;
    realtype reached = t_;
    if (ARKStepEvolve(memory_, limit, vector_.get(), &reached, ARK_ONE_STEP) < 0) return failed();
    t_ = reached;
    const double* y = sundials::data(vector_.get());
    y_.assign(y, y + y_.size());
    count();
    if (settled_ == Settled::failed) return failed();
    if (settled_ == Settled::renewed) ARKStepReset(memory_, t_, vector_.get());
    return true;
  }

  double next_step() const override {
    realtype h = 0;
    ARKStepGetCurrentStep(memory_, &h);
    return h;
  }

 private:
  static int settle(realtype t, N_Vector y, void* self) {
    Arkode& me = *static_cast<Arkode*>(static_cast<OdeStepper*>(self));
    me.settled_ = me.form_.settle(t, {sundials::data(y), me.y_.size()});
    return me.settled_ == Settled::failed ? stop : 0;
  }

  void count() {
    ARKStepGetNumSteps(memory_, &counts_.steps);
    ARKStepGetNumErrTestFails(memory_, &counts_.rejected);
    if (newton_) ARKStepGetNumNonlinSolvIters(memory_, &counts_.newton_iterations);
  }

  Method method_;
  void* memory_ = nullptr;
  std::optional<sundials::Newton> newton_;
  Settled settled_ = Settled::kept;
};

std::unique_ptr<Stepper> create(MotionForm& form, const StepperOptions& options, Method method) {
  return std::make_unique<Arkode>(dynamic_cast<OdeForm&>(form), options, method);
}

}  // namespace

std::unique_ptr<Stepper> create_erk5(MotionForm& form, const StepperOptions& options) {
  return create(form, options, {.explicit_table = ARKODE_DORMAND_PRINCE_7_4_5});
}
std::unique_ptr<Stepper> create_erk6(MotionForm& form, const StepperOptions& options) {
  return create(form, options, {.explicit_table = ARKODE_VERNER_8_5_6});
}
std::unique_ptr<Stepper> create_erk8(MotionForm& form, const StepperOptions& options) {
  return create(form, options, {.explicit_table = ARKODE_FEHLBERG_13_7_8});
}
std::unique_ptr<Stepper> create_dirk(MotionForm& form, const StepperOptions& options) {
  return create(form, options, {.implicit_table = ARKODE_ARK548L2SA_DIRK_8_4_5});
}

}  // namespace lanc
