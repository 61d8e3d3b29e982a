#include "experiments/crossover/curves.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace lanc {

std::string family_of(const std::string& model) {
  const std::size_t begin = model.find(':');
  if (begin == std::string::npos) return model;
  const std::size_t end = std::min(model.find(':', begin + 1), model.size());
  return model.substr(0, begin + 1) + "N" + model.substr(end);
}

std::map<std::string, Family> families_of(const std::vector<Row>& rows) {
  std::map<std::string, Family> families;
  for (const auto& [cell, m] : rows) {
    if (m.phase != "total" || !std::isfinite(m.value) || (m.metric != "flops" && m.metric != "time")) continue;
    Family& family = families[family_of(cell.model)];
    family.velocities[cell.bodies] = cell.velocities;
    Curve& curve = family.curves[cell.formulation];
    if (m.metric == "flops")
      curve.flops[cell.bodies] = m.value;
    else
      curve.seconds[cell.bodies].push_back(m.value);
  }
  return families;
}

namespace {

/// The sizes both have, and the values of both there.
template <class T>
struct Common {
  std::vector<double> x;
  std::vector<T> a, b;

  Common(const std::map<int, T>& first, const std::map<int, T>& second) {
    for (const auto& [n, value] : first) {
      const auto other = second.find(n);
      if (other == second.end()) continue;
      x.push_back(n);
      a.push_back(value);
      b.push_back(other->second);
    }
  }
};

PairCrossing pair_crossing(const std::vector<double>& x, const CrossingPoint& point) {
  PairCrossing pair;
  if (x.empty()) return pair;
  pair.last = static_cast<int>(x.back());
  pair.first = static_cast<int>(x[point.first]);
  pair.kind = point.kind;
  pair.at = pair.lower = pair.upper = point.at;
  return pair;
}

}  // namespace

PairCrossing flops_crossing(const Curve& a, const Curve& b) {
  const Common common(a.flops, b.flops);
  return pair_crossing(common.x, crossing(common.x, common.a, common.b));
}

PairCrossing time_crossing(const Curve& a, const Curve& b, std::uint64_t seed) {
  const Common common(a.seconds, b.seconds);
  if (common.x.empty()) return {};
  const MeasuredCrossing measured = measured_crossing(common.x, common.a, common.b, seed);
  PairCrossing pair = pair_crossing(common.x, measured.of_medians);
  pair.lower = measured.lower;
  pair.upper = measured.upper;
  return pair;
}

double in_velocities(const Family& family, double bodies) {
  const auto above = family.velocities.lower_bound(static_cast<int>(std::ceil(bodies)));
  if (above == family.velocities.end() || !std::isfinite(bodies)) return std::nan("");
  if (above == family.velocities.begin()) return above->second;
  const auto below = std::prev(above);
  return below->second + (bodies - below->first) * (above->second - below->second) / (above->first - below->first);
}

}  // namespace lanc
