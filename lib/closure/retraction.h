// Small moves of a mechanism: positions changed by velocities.
#pragma once

#include <cmath>
#include <vector>

#include "lib/model/model.h"

namespace lanc {

/// q + H(q) η·1s (eq. 1), Euler parameters normalised (eq. 2). To first order in η the motion with these velocities, so
/// that Newton's method keeps its order. Velocities in SI units.
template <class S>
std::vector<S> moved(const Model& model, const std::vector<S>& q, const std::vector<S>& v) {
  std::vector<S> result = q;
  for (const Link& link : model.links()) {
    if (link.nq == 0) continue;
    S rate[7];
    coordinate_rate(link.kind, q.data() + link.q, v.data() + link.v, rate);
    for (int k = 0; k < link.nq; ++k) result[link.q + k] += rate[k];
    if (const int w = link.kind.traits().quaternion; w >= 0) {
      S* e = result.data() + link.q + w;
      const S norm = std::sqrt(e[0] * e[0] + e[1] * e[1] + e[2] * e[2] + e[3] * e[3]);
      for (int k = 0; k < 4; ++k) e[k] /= norm;
    }
  }
  return result;
}

}  // namespace lanc
