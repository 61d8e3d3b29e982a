// Kinematics: model, state and loads → coefficients of eq. 14. The only pass that sees joint kinds.
#pragma once

#include "lib/system/system.h"

namespace lanc {

/// Bound to a model; allocates here and never again. One object per thread.
/// Scalars: double, long double, Count, Dual<8>. Tested by tests/lib/evaluator_test.cpp and the contract tests.
template <class S>
class Evaluator {
 public:
  explicit Evaluator(const Model& model);

  /// Coefficients of eq. 14 at a state. Sizes must be right (checked_state) and Euler parameters normalised. O(n).
  /// About 260 flops and two trigonometric functions per revolute body.
  const System<S>& system(const State<S>& state, const Loads<S>& loads = {});

  /// Baumgarte's stabilisation (1972) of the coefficients evaluated last: conditions g̈ + 2α ġ + α² g = 0 in place of
  /// g̈ = 0. α in 1/s.
  const System<S>& stabilise(double alpha);

  /// World axes of body i's joint axes and position of its reference point, at the last state.
  const Mat3<S>& rotation(int body) const { return frames_[body].R; }
  const Vec3<S>& angular_velocity(int body) const { return frames_[body].omega; }
  /// World axes of the user's body axes.
  Mat3<S> body_rotation(int body) const;
  /// Positions of all reference points and twists v̂ (eq. 7) at the last state; one pass over the bodies.
  const std::vector<Vec3<S>>& positions();
  const std::vector<Motion<S>>& twists();

 private:
  struct Frame {
    Mat3<S> R;
    Vec3<S> omega;
    Vec3<S> linear;  // relative velocity C η of the origin, for twists()
  };
  template <class Joint>
  void step(int body, const S* q, const S* v);
  void sample_motions(double t);
  void apply_passive(const State<S>& state);
  void apply_springs();
  void close_loops(const State<S>& state);
  void apply_point_force(int body, const Vec3<S>& arm, const Vec3<S>& force);

  System<S> system_;
  std::vector<Frame> frames_;
  std::vector<MotionSample> motions_;
  std::vector<Vec3<S>> positions_;
  std::vector<Motion<S>> twists_;
};

extern template class Evaluator<double>;
extern template class Evaluator<long double>;
extern template class Evaluator<Count>;
extern template class Evaluator<Dual<8>>;

}  // namespace lanc
