// What acts between two bodies, from where they are and how they move: point springs, and the rows of closures.
#pragma once

#include "lib/model/model.h"
#include "lib/scalar/pack.h"
#include "lib/system/closure_rows.h"

namespace lanc {

/// A body at one instant, world axes: its joint axes, its reference point, and the twist of that point.
template <class S>
struct MovingBody {
  Mat3<S> axes;
  Vec3<S> position;
  Motion<S> twist;
};

/// Force on end a of a spring whose other end is away by `d` and moves away with `speed`. A spring without rest length
/// pulls with stiffness · d, smooth at d = 0; its damper there acts along the speed, as it does just before and after.
/// A spring with a rest length has no limit at d = 0: the force is not a number.
template <class S>
Vec3<S> spring_pull(const PointSpring& spring, const Vec3<S>& d, const Vec3<S>& speed) {
  const S stiffness(spring.stiffness), damping(spring.damping);
  if (spring.rest_length != 0 && spring.stiffness != 0) {
    const S length = sqrt(dot(d, d));
    const Vec3<S> u = {d.x / length, d.y / length, d.z / length};
    return u * (stiffness * (length - S(spring.rest_length)) + damping * dot(u, speed));
  }
  if (spring.damping == 0) return d * stiffness;
  // The direction without asking whether d is zero: where it is, the speed's, and none where that is zero, too.
  constexpr bool single = is_single_precision<S>;
  const Vec3<S> along = d + speed * S(single ? 1e-15 : 1e-140);
  const S squared = dot(along, along) + S(single ? 1e-35 : 1e-300);
  return d * stiffness + along * (damping * dot(along, speed) / squared);
}

/// Wrenches on two bodies, about their reference points.
template <class S>
struct WrenchPair {
  Wrench<S> a, b;
};

template <class S>
WrenchPair<S> spring_wrenches(const PointSpring& spring, const MovingBody<S>& a, const MovingBody<S>& b) {
  const auto speed = [](const MovingBody<S>& body, const Vec3<S>& arm) {
    return body.twist.linear + cross(body.twist.angular, arm);
  };
  const Vec3<S> arm_a = a.axes * cast<S>(spring.point_a), arm_b = b.axes * cast<S>(spring.point_b);
  const Vec3<S> d = (b.position + arm_b) - (a.position + arm_a);
  const Vec3<S> pull = spring_pull(spring, d, speed(b, arm_b) - speed(a, arm_a));
  return {{cross(arm_a, pull), pull}, {-cross(arm_b, pull), -pull}};
}

namespace closure {

/// Point and frame that the model gives in the body's joint axes.
template <class S, class Constant>
[[gnu::always_inline]] inline Origin<S> origin_on(const MovingBody<S>& body, const Vec3<Constant>& point) {
  const Motion<S>& v = body.twist;
  const Vec3<S> arm = body.axes * cast<S>(point), turn = cross(v.angular, arm);
  return {arm, body.position + arm, v.angular, v.linear + turn, cross(v.angular, turn)};
}
template <class S, class Constant>
[[gnu::always_inline]] inline Frame<S> frame_on(const MovingBody<S>& body, const Mat3<Constant>& axes,
                                                const Vec3<Constant>& point) {
  const Vec3<S> none{S(0.0), S(0.0), S(0.0)};
  return {origin_on(body, point), body.axes * cast<S>(axes), none};
}

/// Moves frame A by the prescribed motion of a joint with one freedom, as (5), (7) and (9) do for a tree joint.
template <class S, class Joint>
void move_frame(Frame<S>& A, double pitch, const MotionSample& motion) {
  const Vec3<S> none{S(0.0), S(0.0), S(0.0)};
  JointStep<S> step{.F = A.axes, .pitch = pitch, .displacement = none, .angular = none, .linear = none};
  Motion<S> C{none, none};
  const S position(motion.position), velocity(motion.velocity);
  Joint::move(&position, turns_of<Joint>(&position).data(), &velocity, step, &C);
  const Vec3<S>&w = A.angular, &r = step.displacement, &u = step.linear;
  A.angular_bias += cross(w, step.angular) + C.angular * S(motion.acceleration);
  A.bias += cross(w, cross(w, r)) + cross(w, u) * S(2.0) + C.linear * S(motion.acceleration);
  A.linear += cross(w, r) + u;
  A.angular += step.angular;
  A.axes = step.R;
  A.arm += r, A.position += r;
}

/// Rows of a closure that is only about a point (Conditions::only_along) and has no motion: axes of B need not be
/// known, nor what else a Frame has. A seventh of the kinematics of one loop. `c`: a Closure, or a ClosureBlock on
/// packs.
template <class Places, class S, class Store>
[[gnu::always_inline]] inline void rows_of_points(const Conditions& conditions, const Places& c, const MovingBody<S>& a,
                                                  const MovingBody<S>& b, Store&& store) {
  const Origin<S> A = origin_on(a, c.point_a), B = origin_on(b, c.point_b);
  const Separation<S> from_a(A, B);
  for (int k = 0; k < conditions.count; ++k)
    store(k, along(A, a.axes * cast<S>(axis(c.axes_a, conditions.rows[k].i)), B, from_a));
}

/// Those of any other. Takes the bodies by value: by reference their numbers, and those of the frames, would wait in
/// memory for a closure that is only about a point, too.
template <class S, class Store>
[[gnu::noinline]] void rows_of_frames(const Closure& c, const ClosureSet& set, double t, MovingBody<S> a,
                                      MovingBody<S> b, Store&& store) {
  static constexpr auto movers = for_each_joint_kind([]<class Joint>() {
    if constexpr (Joint::traits.nv == 1)
      return &move_frame<S, Joint>;
    else
      return static_cast<void (*)(Frame<S>&, double, const MotionSample&)>(nullptr);
  });
  Frame<S> A = frame_on(a, c.axes_a, c.point_a);
  const Frame<S> B = frame_on(b, c.axes_b, c.point_b);
  MotionSample motion{c.length, 0, 0};
  if (c.motion >= 0) motion = set.motions[c.motion]->at(t);
  const ClosureTraits& traits = c.kind.traits();
  if (c.motion >= 0 && !traits.has_length) movers[traits.joint->index](A, c.pitch, motion);
  const Conditions& conditions = c.conditions();
  const Separation<S> from_a = conditions.has_along() ? Separation<S>(A, B) : Separation<S>();
  for (int k = 0; k < conditions.count; ++k) store(k, condition(conditions.rows[k], A, B, from_a, S(c.pitch), motion));
}

/// Calls store(k, row) for the conditions k = 0, 1, ... of a closure.
template <class S, class Store>
[[gnu::always_inline]] inline void rows_of(const Closure& c, const ClosureSet& set, double t, const MovingBody<S>& a,
                                           const MovingBody<S>& b, Store&& store) {
  if (const Conditions& conditions = c.conditions(); c.motion < 0 && conditions.only_along())
    rows_of_points(conditions, c, a, b, store);
  else
    rows_of_frames(c, set, t, a, b, store);
}

}  // namespace closure
}  // namespace lanc
