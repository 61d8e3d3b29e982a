// Position coordinates of all joints: rates, norms, units.
// Private to the library.
#pragma once

#include <cmath>
#include <vector>

#include "lib/model/model.h"

namespace lanc {

/// β̇ = H(β) η (eq. 1) of all joints.
template <class S>
void coordinate_rates(const Model& model, const S* q, const S* v, S* rate) {
  for (const Link& link : model.links())
    if (link.nq > 0) coordinate_rate(link.kind, q + link.q, v + link.v, rate + link.q);
}

/// Euler parameters back to length 1 (eq. 2).
template <class S>
void normalise(const Model& model, S* q) {
  for (const Link& link : model.links()) {
    const int w = link.kind.traits().quaternion;
    if (w < 0 || link.nq == 0) continue;
    S* e = q + link.q + w;
    const S norm = sqrt(e[0] * e[0] + e[1] * e[1] + e[2] * e[2] + e[3] * e[3]);
    for (int k = 0; k < 4; ++k) e[k] = e[k] / norm;
  }
}

/// The positions that are reached from q by the constant velocities δ in unit time: the exponential of the joint's
/// group of motions; for a free body that of its screw, δ = (rotation, translation) in its own axes.
inline std::vector<double> displaced(const Model& model, const std::vector<double>& q, const std::vector<double>& d) {
  std::vector<double> result = q;
  for (const Link& link : model.links()) {
    const JointTraits& traits = link.kind.traits();
    if (link.nq == 0) continue;
    const double* x = d.data() + link.v;
    double* p = result.data() + link.q;
    if (traits.quaternion < 0) {
      for (int k = 0; k < link.nq; ++k) p[k] += x[k];
      continue;
    }
    const Vec3<double> w{x[0], x[1], x[2]};
    const double angle2 = dot(w, w), angle = std::sqrt(angle2);
    const bool small = angle < 1e-4;
    double* e = p + traits.quaternion;
    if (traits.moves_origin) {
      const double b = small ? 0.5 - angle2 / 24 : (1 - std::cos(angle)) / angle2;
      const double c = small ? 1.0 / 6 - angle2 / 120 : (angle - std::sin(angle)) / (angle2 * angle);
      const Vec3<double> u{x[3], x[4], x[5]}, wu = cross(w, u);
      const Vec3<double> moved = turned_by_quaternion(identity3<double>(), e) * (u + wu * b + cross(w, wu) * c);
      p[0] += moved.x, p[1] += moved.y, p[2] += moved.z;
    }
    const double s = small ? 0.5 - angle2 / 48 : std::sin(angle / 2) / angle, w0 = std::cos(angle / 2);
    const Vec3<double> h = w * s, v{e[1], e[2], e[3]}, product = h * e[0] + v * w0 + cross(v, h);
    e[0] = e[0] * w0 - dot(v, h);
    e[1] = product.x, e[2] = product.y, e[3] = product.z;
  }
  normalise(model, result.data());
  return result;
}

/// 1 for angles and Euler parameters, the model's length for lengths.
inline std::vector<double> position_scale(const Model& model) {
  std::vector<double> scale;
  for (const Link& link : model.links())
    for (int k = 0; k < link.nq; ++k) scale.push_back(link.kind.traits().q_units[k] == "m" ? model.length() : 1.0);
  return scale;
}

inline std::vector<double> velocity_scale(const Model& model) {
  std::vector<double> scale(model.nv(), 1.0);
  for (int k = 0; k < model.nv(); ++k)
    if (model.column_kind(k) == ColumnKind::translation) scale[k] = model.length();
  return scale;
}

}  // namespace lanc
