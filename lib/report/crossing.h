// Where one cost curve falls below another, and how sure that is.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace lanc {

/// Costs against sizes. `x` rises strictly.
struct CrossingPoint {
  enum class Kind {
    always,   // below from the first size on: no crossing among these sizes
    crosses,  // not below at some size, below at all later ones
    never     // not below at the last size
  };
  Kind kind = Kind::never;
  std::size_t first = 0;  // index of the first size from which on it is below at every later one (unless never)
  double at = 0;          // crosses: where the straight lines between the neighbouring sizes meet; x[0] when always
};

/// From where on `cost` stays below `other`. Sizes at which either is not finite are left out. Exact for exact costs,
/// and for every integer size when x holds all integers. Tested by tests/report/crossing_test.cpp.
CrossingPoint crossing(std::span<const double> x, std::span<const double> cost, std::span<const double> other);

/// The same for costs that are measured: the size that parts best the sizes where `cost` is above from those where it
/// is below, in the sum of log(cost/other). Where the curves run close together, a single disturbed size does not
/// decide.
CrossingPoint best_crossing(std::span<const double> x, std::span<const double> cost, std::span<const double> other);

/// p-quantile (0..1) with linear interpolation; NaN when empty.
double quantile(std::vector<double> values, double p);
inline double median(std::vector<double> values) { return quantile(std::move(values), 0.5); }

/// Crossing of measured costs. cost[k] and other[k] are the repetitions at size x[k].
struct MeasuredCrossing {
  CrossingPoint of_medians;
  double lower = 0, upper = 0;  // quartiles of the crossing over resamples; ∞ where it is beyond the last size
};

/// The best crossing of the medians, and its quartiles over `resamples` bootstrap samples of the repetitions (each size
/// resampled with the same repetitions for both: they were interleaved, so a disturbance hit both).
MeasuredCrossing measured_crossing(std::span<const double> x, std::span<const std::vector<double>> cost,
                                   std::span<const std::vector<double>> other, std::uint64_t seed, int resamples = 200);

}  // namespace lanc
