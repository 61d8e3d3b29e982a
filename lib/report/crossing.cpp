#include "lib/report/crossing.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace lanc {

namespace {

/// The crossing between two neighbouring sizes; x[below] the first below.
CrossingPoint between(std::span<const double> x, std::span<const double> cost, std::span<const double> other,
                      std::size_t above, std::size_t below) {
  const double before = cost[above] - other[above], after = cost[below] - other[below];
  return {CrossingPoint::Kind::crosses, below, x[above] + (x[below] - x[above]) * before / (before - after)};
}

}  // namespace

CrossingPoint crossing(std::span<const double> x, std::span<const double> cost, std::span<const double> other) {
  std::optional<std::size_t> first;
  for (std::size_t k = x.size(); k-- > 0;) {
    const double difference = cost[k] - other[k];
    if (!std::isfinite(difference)) continue;
    if (difference < 0)
      first = k;
    else
      return first ? between(x, cost, other, k, *first) : CrossingPoint{};
  }
  return first ? CrossingPoint{CrossingPoint::Kind::always, *first, x[*first]} : CrossingPoint{};
}

CrossingPoint best_crossing(std::span<const double> x, std::span<const double> cost, std::span<const double> other) {
  std::vector<std::size_t> sizes;
  for (std::size_t k = 0; k < x.size(); ++k)
    if (std::isfinite(cost[k] - other[k]) && cost[k] > 0 && other[k] > 0) sizes.push_back(k);
  // The sum over the sizes before the crossing is largest there: what comes before is above, what comes after below.
  double sum = 0, largest = 0;
  std::size_t best = 0;
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    sum += std::log(cost[sizes[i]] / other[sizes[i]]);
    if (sum >= largest) largest = sum, best = i + 1;
  }
  if (best == sizes.size()) return {};
  if (best == 0) return {CrossingPoint::Kind::always, sizes[0], x[sizes[0]]};
  return between(x, cost, other, sizes[best - 1], sizes[best]);
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
    return best_crossing(x, a, b);
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
