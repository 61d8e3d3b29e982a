// Whether two solved the same problem. Without that their times cannot be compared.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace lanc::peers {

constexpr double same_answer = 1e-8;   // of the largest value: far above rounding, far below another model
constexpr double same_if_soft = 1e-2;  // where closure conditions are penalties

/// Largest difference, relative to the largest expected value; infinite where sizes differ or something is not finite.
/// Tested by tests/peers/peers_test.cpp.
inline double difference(const std::vector<double>& found, const std::vector<double>& expected) {
  constexpr double none = std::numeric_limits<double>::infinity();
  if (found.size() != expected.size()) return none;
  double worst = 0, size = 0;
  for (std::size_t k = 0; k < found.size(); ++k) {
    if (!std::isfinite(found[k]) || !std::isfinite(expected[k])) return none;
    worst = std::max(worst, std::abs(found[k] - expected[k]));
    size = std::max(size, std::abs(expected[k]));
  }
  return worst == 0 ? 0 : worst / size;
}

inline bool same(double difference, bool soft) { return difference < (soft ? same_if_soft : same_answer); }

}  // namespace lanc::peers
