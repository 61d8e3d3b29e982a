// Kinematics: model, state and loads → coefficients of eq. 14. The only pass that sees joint kinds.
#pragma once

#include "lib/spatial/block.h"
#include "lib/spatial/principal_tensor.h"
#include "lib/system/between_bodies.h"
#include "lib/system/body_frame.h"
#include "lib/system/closure_blocks.h"
#include "lib/system/prefetch.h"
#include "lib/system/system.h"

namespace lanc {

/// Bound to a model; allocates here and never again. One object per thread.
/// Scalars: double, long double, Count, Dual<8>, NativePack. Tested by tests/lib/evaluator_test.cpp and the contract
/// tests.
template <class S>
class Evaluator {
 public:
  explicit Evaluator(const Model& model);

  /// Coefficients of eq. 14 at a state. Sizes must be right (checked_state) and Euler parameters normalised. O(n).
  /// About 235 flops and two trigonometric functions per revolute body. Packs take the steps of `ahead` on the way.
  const System<S>& system(const State<S>& state, const Loads<S>& loads = {}, Prefetch* ahead = nullptr);

  /// Baumgarte's stabilisation (1972) of the coefficients evaluated last: conditions g̈ + 2α ġ + α² g = 0 in place of
  /// g̈ = 0. α in 1/s.
  const System<S>& stabilise(double alpha);

  /// World axes of body i's joint axes and position of its reference point, at the last state.
  [[gnu::always_inline]] Mat3<S> rotation(int body) const { return axes_of(frames_[body]); }
  Vec3<S> angular_velocity(int body) const { return vector_at<S>(frames_[body].omega); }
  /// World axes of the user's body axes.
  Mat3<S> body_rotation(int body) const;
  /// Positions of all reference points and twists v̂ (eq. 7) at the last state; one pass over the bodies.
  const std::vector<Vec3<S>>& positions();
  const std::vector<Motion<S>>& twists();
  /// A body, or the ground, by the last positions() and twists().
  MovingBody<S> moving_body(int body) const;

 private:
  using B = Packed<S>;
  static constexpr unsigned lanes = PackedScalar<S>::lanes;
  /// Their inertias in joint axes, and weights.
  struct Masses {
    Vec3<PackedConstant<S>> h{};
    PrincipalTensor<PackedConstant<S>> J{};
    Vec3<PackedConstant<S>> weight{};
  };
  /// The ground, as bodies are kept.
  struct Ground {
    BodyFrame<S> frame{{S(1.0), S(0.0), S(0.0)}, {S(0.0), S(1.0), S(0.0)}, {S(0.0), S(0.0), S(1.0)}, {}};
    Vec3<S> position{S(0.0), S(0.0), S(0.0)};
    Motion<S> twist{position, position};
  };
  static unsigned lane(int body) { return static_cast<unsigned>(body) % lanes; }
  template <class Joint, FrameTurn turn>
  void step(int body, const S* q, const S* v);
  void weigh(int block);
  void sample_motions(double t);
  void sample_angles(const State<S>& state);
  template <bool positions, bool twists>
  void move_bodies();
  void apply_passive(const State<S>& state);
  void apply_springs();
  void close_loops(const State<S>& state);
  void close_side_by_side(const ClosureBlock& block);
  void set_moving_body(MovingBody<B>& block, int lane, int body) const;

  System<S> system_;
  std::vector<BodyFrame<S>> frames_;  // in whole blocks
  Ground ground_;
  std::vector<Masses> masses_;
  std::vector<Vec3<S>> origin_velocities_;  // C η of the origins of joints that move them, for twists()
  std::vector<MotionSample> motions_;
  std::vector<int> sampled_;  // Model::angles(), the last one filling whole blocks up
  bool only_angles_;          // they are β
  std::vector<S> angles_, sines_, cosines_;
  std::vector<ClosureBlock> closure_blocks_;
  MovingBody<B> ends_a_{}, ends_b_{};  // of a block of closures
  std::vector<Vec3<S>> positions_;
  std::vector<Motion<S>> twists_;
};

extern template class Evaluator<double>;
extern template class Evaluator<long double>;
extern template class Evaluator<Count>;
extern template class Evaluator<Dual<8>>;

}  // namespace lanc
