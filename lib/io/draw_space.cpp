#include "lib/io/draw_space.h"

#include <fmt/format.h>

namespace lanc {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Eigen holds numbers here and multiplies none: its kernels contract on some processors, whatever the flags say.

Vector3d draw_vector(Draw& draw, double size) {
  const double x = draw.between(-size, size), y = draw.between(-size, size), z = draw.between(-size, size);
  return {x, y, z};
}

Vector3d draw_direction(Draw& draw) {
  double a[3];
  draw.direction(a, 3);
  return {a[0], a[1], a[2]};
}

Matrix3d draw_rotation(Draw& draw) {
  double e[4];
  draw.direction(e, 4);
  const double w = e[0], x = e[1], y = e[2], z = e[3];
  Matrix3d R;
  R << 1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),  //
      2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),   //
      2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y);
  return R;
}

Vector3d across(const Vector3d& a, const Vector3d& b) {
  return {a.y() * b.z() - a.z() * b.y(), a.z() * b.x() - a.x() * b.z(), a.x() * b.y() - a.y() * b.x()};
}

Vector3d draw_perpendicular(Draw& draw, const Vector3d& a) {
  for (;;) {
    const Vector3d b = across(a, draw_direction(draw));
    const double square = b.x() * b.x() + b.y() * b.y() + b.z() * b.z();
    if (square < 0.1) continue;
    const double norm = std::sqrt(square);
    return {b.x() / norm, b.y() / norm, b.z() / norm};
  }
}

Matrix3d draw_inertia(Draw& draw, double mass) {
  double side[3], principal[3];
  for (double& s : side) s = draw.between(0.1, 0.5), s *= s;
  for (int k = 0; k < 3; ++k) principal[k] = mass * (side[(k + 1) % 3] + side[(k + 2) % 3]) / 12;
  const Matrix3d R = draw_rotation(draw);
  Matrix3d I;
  for (int a = 0; a < 3; ++a)
    for (int b = a; b < 3; ++b) {
      double sum = 0;
      for (int k = 0; k < 3; ++k) sum += R(a, k) * principal[k] * R(b, k);
      I(a, b) = I(b, a) = sum;
    }
  return I;
}

MotionSpec draw_motion(Draw& draw) {
  const double a = draw.between(-1, 1), b = draw.between(-1, 1), c = draw.between(-1, 1);
  switch (draw.index(5)) {
    case 0: return ConstantSpeed{a, b};
    case 1: return Polynomial{{a, b, c}};
    case 2: return Sine{a, b, 2 + c, draw.between(-1, 1)};
    case 3: return SplineTable{{-2, -1, 0, 1, 2}, {a, b, c, draw.between(-1, 1), draw.between(-1, 1)}};
    default: return Formula{fmt::format("{} * sin(2 * t) + {} * t^2", a, b)};
  }
}

BodySpec draw_body(Draw& draw) {
  BodySpec body;
  body.mass = draw.between(0.5, 2);
  body.com = draw_vector(draw, 0.2);
  body.inertia = draw_inertia(draw, body.mass);
  return body;
}

State<double> draw_state(const Model& model, Draw& draw) {
  State<double> state = neutral_state(model);
  for (const Link& link : model.links()) {
    const int w = link.kind.traits().quaternion;
    for (int k = 0; k < link.nq; ++k)
      if (w < 0 || k < w || k >= w + 4) state.q[link.q + k] = draw.between(-1, 1);
    if (w >= 0) draw.direction(&state.q[link.q + w], 4);
    for (int k = 0; k < link.nv; ++k) state.v[link.v + k] = draw.between(-1, 1);
  }
  return state;
}

}  // namespace lanc
