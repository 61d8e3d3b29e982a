#pragma once
#include "lib/model/joints/joint.h"

namespace lanc::joints {

/// Weld: no freedom. The body stays a body of its own, so its wrench is an output like any other.
struct Fixed {
  static constexpr JointTraits traits{.name = "fixed",
                                      .closure = {6,
                                                  {conditions::x, conditions::y, conditions::z, conditions::turn_x,
                                                   conditions::turn_y, conditions::turn_z},
                                                  "xyz"}};
  static constexpr bool has_column_rate = false;

  template <class S, class W>
  static void move(const S*, const SinCos<S>*, const S*, JointStep<W>& step, Motion<W>*) {
    step.R = step.F;
  }
};

}  // namespace lanc::joints
