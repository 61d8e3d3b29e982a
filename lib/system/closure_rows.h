// Closure conditions and their exact derivatives: g, ġ, G_a, G_b and γ̿ of every row (theory, section 2).
//
// A condition is a formula in two primitives, the product of an axis of A with an axis of B and the place of B's origin
// along an axis of A. A Row carries value and derivatives through the formula, on and off the manifold, so that no
// derivative is written down twice.
#pragma once

#include "lib/system/system.h"

namespace lanc::closure {

/// Origin of frame A or B at one instant, world axes: fixed on its body, or moved on it by a prescribed motion.
template <class S>
struct Origin {
  Vec3<S> arm;  // from the body's reference point
  Vec3<S> position;
  Vec3<S> angular;  // angular velocity of the frame
  Vec3<S> linear;   // velocity of the origin
  Vec3<S> bias;     // acceleration of the origin while â of the body is zero
};

template <class S>
struct Frame : Origin<S> {
  Mat3<S> axes;
  Vec3<S> angular_bias;  // angular acceleration of the frame while â of the body is zero
};

/// A function f of two bodies' poses and time: ḟ = rate, f̈ = a·â_a + b·â_b + bias.
template <class S>
struct Row {
  S value;
  Wrench<S> a, b;
  S rate, bias;

  friend Row operator+(const Row& f, const Row& g) {
    return {f.value + g.value, f.a + g.a, f.b + g.b, f.rate + g.rate, f.bias + g.bias};
  }
  friend Row operator-(const Row& f, const Row& g) { return f + g * S(-1.0); }
  friend Row operator*(const Row& f, const S& s) { return {f.value * s, f.a * s, f.b * s, f.rate * s, f.bias * s}; }
  friend Row operator*(const Row& f, const Row& g) {
    const auto mix = [](const auto& x, const auto& y, const S& fx, const S& gy) { return x * gy + y * fx; };
    return {f.value * g.value, mix(f.a, g.a, f.value, g.value), mix(f.b, g.b, f.value, g.value),
            mix(f.rate, g.rate, f.value, g.value), mix(f.bias, g.bias, f.value, g.value) + f.rate * g.rate * S(2.0)};
  }
  /// h(f) from h, h′ and h″ at f.
  Row through(const S& h, const S& h1, const S& h2) const {
    Row r = *this * h1;
    r.value = h;
    r.bias += h2 * rate * rate;
    return r;
  }
};

/// u·w for u fixed in A and w fixed in B.
template <class S>
Row<S> product(const Frame<S>& A, const Vec3<S>& u, const Frame<S>& B, const Vec3<S>& w) {
  const Vec3<S> s = cross(w, u), none{S(0.0), S(0.0), S(0.0)};
  const Vec3<S> relative = B.angular - A.angular;
  const Vec3<S> s_rate = cross(cross(B.angular, w), u) + cross(w, cross(A.angular, u));
  return {dot(u, w),
          {-s, none},
          {s, none},
          dot(s, relative),
          dot(s_rate, relative) + dot(s, B.angular_bias - A.angular_bias)};
}

/// Where the origin of B is, seen from A: for any u fixed in A, u·d and its derivatives u·rate and, while no â acts,
/// u·bias. Common to the rows of a closure; (ω × u)·d = u·(d × ω) takes the turning of u out of each.
template <class S>
struct Separation {
  Vec3<S> d, rate, bias;

  Separation() = default;
  /// A turns as its body does.
  [[gnu::always_inline]] Separation(const Origin<S>& A, const Origin<S>& B) : d(B.position - A.position) {
    const Vec3<S> d_rate = B.linear - A.linear;
    rate = d_rate + cross(d, A.angular);
    bias = B.bias - A.bias + cross(d_rate + rate, A.angular);
  }
  [[gnu::always_inline]] Separation(const Frame<S>& A, const Frame<S>& B)
      : Separation(static_cast<const Origin<S>&>(A), static_cast<const Origin<S>&>(B)) {
    bias += cross(d, A.angular_bias);
  }
};

/// u·(p_B − p_A) for u fixed in A. Always inlined, as condition() is: a row returned through memory costs the
/// kinematics of one loop 7 %.
template <class S>
[[gnu::always_inline]] inline Row<S> along(const Origin<S>& A, const Vec3<S>& u, const Origin<S>& B,
                                           const Separation<S>& from_a) {
  return {dot(u, from_a.d),
          {cross(u, from_a.d + A.arm), -u},
          {cross(B.arm, u), u},
          dot(u, from_a.rate),
          dot(u, from_a.bias)};
}

/// |p_B − p_A|; not finite where the points meet.
template <class S>
Row<S> distance(const Origin<S>& A, const Origin<S>& B) {
  const Vec3<S> d = B.position - A.position, d_rate = B.linear - A.linear;
  const S length = sqrt(dot(d, d)), inverse = S(1.0) / length;
  const Vec3<S> n = d * inverse;
  const S rate = dot(n, d_rate);
  return {length,
          {-cross(A.arm, n), -n},
          {cross(B.arm, n), n},
          rate,
          dot(n, B.bias - A.bias) + (dot(d_rate, d_rate) - rate * rate) * inverse};
}

template <class S>
[[gnu::always_inline]] inline const Vec3<S>& axis(const Mat3<S>& frame, int i) {
  return i == 0 ? frame.x : i == 1 ? frame.y : frame.z;
}

/// One condition as a row. `from_a` is the separation of A and B where Conditions::has_along(), `length` the distance
/// demanded, with its derivatives.
template <class S>
[[gnu::always_inline]] inline Row<S> condition(const Condition& c, const Frame<S>& A, const Frame<S>& B,
                                               const Separation<S>& from_a, const S& pitch,
                                               const MotionSample& length) {
  switch (c.kind) {
    case ConditionKind::along: return along(A, axis(A.axes, c.i), B, from_a);
    case ConditionKind::perpendicular: return product(A, axis(A.axes, c.i), B, axis(B.axes, c.j));
    case ConditionKind::turn: {
      const int j = (c.i + 1) % 3, k = (c.i + 2) % 3;
      return (product(A, axis(A.axes, k), B, axis(B.axes, j)) - product(A, axis(A.axes, j), B, axis(B.axes, k))) *
             S(0.5);
    }
    case ConditionKind::distance: {
      Row<S> row = distance(A, B);
      row.value -= S(length.position), row.rate -= S(length.velocity);
      row.bias -= S(length.acceleration);
      return row;
    }
    case ConditionKind::screw: {
      // twice cosine and sine of the angle while the z axes are parallel
      const Row<S> cosine = product(A, A.axes.x, B, B.axes.x) + product(A, A.axes.y, B, B.axes.y);
      const Row<S> sine = product(A, A.axes.y, B, B.axes.x) - product(A, A.axes.x, B, B.axes.y);
      const Row<S> phase = along(A, A.axes.z, B, from_a) * (S(1.0) / pitch);
      const S sn = sin(phase.value), cs = cos(phase.value);
      return (phase.through(sn, cs, -sn) * cosine - phase.through(cs, -sn, -cs) * sine) * S(0.5);
    }
  }
  return {};
}

}  // namespace lanc::closure
