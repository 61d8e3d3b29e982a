// What SUNDIALS' integrators of ẏ = f(t, y) share: calls into the form, and what its answers mean.
// Private to lib/integrate.
#pragma once

#include "lib/integrate/stepper.h"
#include "lib/integrate/sundials.h"

namespace lanc {

class OdeStepper : public Stepper {
 public:
  OdeStepper(OdeForm& form, const StepperOptions& options)
      : form_(form), options_(options), context_(sundials::make_context()) {
    options_.tolerance = sundials::of_single_numbers(options.tolerance, form.size());
    vector_ = sundials::make_vector(context_, form.size());
    tolerance_ = sundials::make_vector(context_, form.size());
    for (int k = 0; k < form.size(); ++k) sundials::data(tolerance_.get())[k] = options_.tolerance * form.scale()[k];
  }

 protected:
  static constexpr int retry = 1, stop = -1;  // SUNDIALS: positive is recoverable

  static int code(Evaluation evaluation) {
    return evaluation == Evaluation::fine ? 0 : evaluation == Evaluation::retry ? retry : stop;
  }
  static int rate(realtype t, N_Vector y, N_Vector ydot, void* self) {
    return code(static_cast<OdeStepper*>(self)->form_.rate(t, sundials::data(y), sundials::data(ydot)));
  }
  static int jacobian(realtype t, N_Vector y, N_Vector /*ydot*/, SUNMatrix J, void* self, N_Vector, N_Vector,
                      N_Vector) {
    return code(static_cast<OdeStepper*>(self)->form_.jacobian(t, sundials::data(y), SM_DATA_D(J)));
  }

  /// What to tell when a call failed: the form's reason if it has one, else SUNDIALS'.
  bool failed() {
    message_ = form_.outcome().usable() ? library_message_ : form_.outcome().message;
    if (message_.empty()) message_ = "the integrator gave up";
    return false;
  }

  OdeForm& form_;
  StepperOptions options_;
  sundials::Context context_;
  sundials::Vector vector_, tolerance_;
  std::string library_message_;
};

}  // namespace lanc
