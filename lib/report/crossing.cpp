#include "lib/report/crossing.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace lanc {

CrossingPoint crossing(std::span<const double> x, std::span<const double> cost, std::span<const double> other) {
  CrossingPoint result;
  std::optional<std::size_t> later;  // the finite size after k
  std::optional<std::size_t> last_above;
  for (std::size_t k = x.size(); k-- > 0 && !last_above;) {
    const double difference = cost[k] - other[k];
    if (!std::isfinite(difference)) continue;
    if (difference < 0)
      later = k;
    else
      last_above = k;
  }
  if (!later) return result;
  result.first = *later;
  if (!last_above) {
    result.kind = CrossingPoint::Kind::always;
    result.at = x[*later];
    return result;
  }
  result.kind = CrossingPoint::Kind::crosses;
  const double before = cost[*last_above] - other[*last_above], after = cost[*later] - other[*later];
  result.at = x[*last_above] + (x[*later] - x[*last_above]) * before / (before - after);
  return result;
}

double quantile(std::vector<double> values, double p) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  std::sort(values.begin(), values.end());
  const double at = p * static_cast<double>(values.size() - 1);
  const auto low = static_cast<std::size_t>(at);
  const auto high = std::min(low + 1, values.size() - 1);
  if (values[low] == values[high]) return values[low];  // infinite ones, too
  return values[low] + (at - static_cast<double>(low)) * (values[high] - values[low]);
}

MeasuredCrossing measured_crossing(std::span<const double> x, std::span<const std::vector<double>> cost,
                                   std::span<const std::vector<double>> other, std::uint64_t seed, int resamples) {
  const auto crossing_of = [&](const auto& sample) {
    std::vector<double> a(x.size()), b(x.size());
    for (std::size_t k = 0; k < x.size(); ++k) a[k] = median(sample(k, cost[k])), b[k] = median(sample(k, other[k]));
    return crossing(x, a, b);
  };
  MeasuredCrossing result;
  result.of_medians = crossing_of([](std::size_t, const std::vector<double>& all) { return all; });

  std::mt19937_64 random(seed);
  std::vector<double> at;
  std::vector<std::vector<std::uint64_t>> drawn(x.size());
  for (int r = 0; r < resamples; ++r) {
    for (std::size_t k = 0; k < x.size(); ++k) {
      drawn[k].resize(std::max(cost[k].size(), other[k].size()));
      for (auto& d : drawn[k]) d = random();
    }
    const CrossingPoint point = crossing_of([&](std::size_t k, const std::vector<double>& all) {
      std::vector<double> sample(all.size());
      for (std::size_t i = 0; i < all.size(); ++i) sample[i] = all[drawn[k][i] % all.size()];
      return sample;
    });
    at.push_back(point.kind == CrossingPoint::Kind::never ? std::numeric_limits<double>::infinity() : point.at);
  }
  result.lower = quantile(at, 0.25);
  result.upper = quantile(at, 0.75);
  return result;
}

}  // namespace lanc
