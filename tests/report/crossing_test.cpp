// Crossing points of synthetic costs, exact and measured.
#include "lib/report/crossing.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "lib/report/timing.h"

namespace lanc {
namespace {

using Kind = CrossingPoint::Kind;

std::vector<double> sizes(int n) {
  std::vector<double> x(n);
  for (int k = 0; k < n; ++k) x[k] = k + 1;
  return x;
}

template <class F>
std::vector<double> values(const std::vector<double>& x, F&& f) {
  std::vector<double> y;
  for (const double n : x) y.push_back(f(n));
  return y;
}

TEST(Crossing, of_a_line_and_a_parabola_is_where_they_meet) {
  const auto x = sizes(64);
  // 10 n + 6 < n² from n = 11 on; the chords between 10 and 11 meet at 10 + 6/11
  const auto point =
      crossing(x, values(x, [](double n) { return 10 * n + 6; }), values(x, [](double n) { return n * n; }));
  EXPECT_EQ(point.kind, Kind::crosses);
  EXPECT_EQ(x[point.first], 11);
  EXPECT_DOUBLE_EQ(point.at, 10 + 6.0 / 11);
}

TEST(Crossing, counts_from_the_last_size_that_is_not_below) {
  const std::vector<double> x = {1, 2, 3, 4}, other = {5, 5, 5, 5}, cost = {4, 6, 5, 4};
  const auto point = crossing(x, cost, other);
  EXPECT_EQ(point.first, 3U);
  EXPECT_DOUBLE_EQ(point.at, 3);
}

TEST(Crossing, tells_always_and_never) {
  const std::vector<double> x = {1, 2}, low = {1, 1}, high = {2, 2};
  EXPECT_EQ(crossing(x, low, high).kind, Kind::always);
  EXPECT_EQ(crossing(x, high, low).kind, Kind::never);
  EXPECT_EQ(crossing(x, low, low).kind, Kind::never);
  EXPECT_EQ(crossing({}, {}, {}).kind, Kind::never);
  EXPECT_EQ(best_crossing(x, low, high).kind, Kind::always);
  EXPECT_EQ(best_crossing(x, high, low).kind, Kind::never);
  EXPECT_EQ(best_crossing({}, {}, {}).kind, Kind::never);
}

TEST(Crossing, leaves_out_sizes_without_a_result) {
  const double none = std::numeric_limits<double>::quiet_NaN();
  const std::vector<double> x = {1, 2, 3, 4}, other = {5, none, 5, none}, cost = {6, 1, 4, none};
  const auto point = crossing(x, cost, other);
  EXPECT_EQ(point.kind, Kind::crosses);
  EXPECT_EQ(point.first, 2U);
  EXPECT_DOUBLE_EQ(point.at, 2);
}

TEST(Crossing, one_disturbed_size_does_not_move_the_best_crossing) {
  const auto x = sizes(30);
  auto cost = values(x, [](double n) { return 10.5 * n; });
  const auto other = values(x, [](double n) { return n * n; });
  cost[24] *= 3;
  EXPECT_EQ(x[crossing(x, cost, other).first], 26);
  EXPECT_EQ(x[best_crossing(x, cost, other).first], 11);
}

TEST(Crossing, measured_with_noise_is_between_its_quartiles_and_near_the_truth) {
  const auto x = sizes(40);
  std::mt19937_64 random(1);
  std::normal_distribution<double> noise(1, 0.05);
  std::vector<std::vector<double>> cost, other;
  for (const double n : x) {
    cost.emplace_back();
    other.emplace_back();
    for (int r = 0; r < 7; ++r) {
      cost.back().push_back(10.5 * n * noise(random));
      other.back().push_back(n * n * noise(random));
    }
  }
  const auto measured = measured_crossing(x, cost, other, 1);
  EXPECT_NEAR(measured.of_medians.at, 10.5, 0.7);
  EXPECT_LE(measured.lower, measured.upper);
  EXPECT_NEAR(measured.lower, 10.5, 1);
  EXPECT_NEAR(measured.upper, 10.5, 1);
  const auto again = measured_crossing(x, cost, other, 1);
  EXPECT_EQ(again.lower, measured.lower);
}

TEST(Quantile, interpolates_and_keeps_infinities) {
  EXPECT_DOUBLE_EQ(median({3, 1, 2}), 2);
  EXPECT_DOUBLE_EQ(median({4, 1, 2, 3}), 2.5);
  EXPECT_DOUBLE_EQ(quantile({1, 2, 3, 4, 5}, 0.25), 2);
  const double infinite = std::numeric_limits<double>::infinity();
  EXPECT_EQ(quantile({1, infinite, infinite}, 0.75), infinite);
  EXPECT_TRUE(std::isnan(median({})));
}

TEST(Timing, repeats_a_short_call_until_it_is_long_enough) {
  volatile double sum = 0;
  long calls = 0;
  Repeat repeat;
  const double seconds = repeat.seconds(
      [&] {
        ++calls;
        sum = sum + 1;
      },
      1e-3);
  EXPECT_GT(calls, 1000);
  EXPECT_LT(seconds, 1e-6);
  EXPECT_GT(seconds, 0);
}

}  // namespace
}  // namespace lanc
