// Small moves of a mechanism: positions changed by velocities.
#pragma once

#include <cmath>
#include <vector>

#include "lib/model/model.h"

namespace lanc {

/// q + H(q) η·1s (eq. 1), Euler parameters normalised (eq. 2). To first order in η the motion with these velocities, so
/// that Newton's method keeps its order. Velocities in SI units.
inline std::vector<double> moved(const Model& model, const std::vector<double>& q, const std::vector<double>& v) {
  std::vector<double> result = q;
  for (const Link& link : model.links()) {
    if (link.nq == 0) continue;
    double rate[7];
    coordinate_rate(link.kind, q.data() + link.q, v.data() + link.v, rate);
    for (int k = 0; k < link.nq; ++k) result[link.q + k] += rate[k];
    if (const int w = link.kind.traits().quaternion; w >= 0) {
      double* e = result.data() + link.q + w;
      const double norm = std::sqrt(e[0] * e[0] + e[1] * e[1] + e[2] * e[2] + e[3] * e[3]);
      for (int k = 0; k < 4; ++k) e[k] /= norm;
    }
  }
  return result;
}

}  // namespace lanc
