// Packs of numbers in SIMD lanes, and sines of many angles at once.
#include "lib/scalar/pack.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

namespace lanc::test {
namespace {

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
constexpr double infinite = std::numeric_limits<double>::infinity();

template <class P>
P lanes_of(double (*f)(int)) {
  P p;
  for (int k = 0; k < P::lanes; ++k) p.set(k, f(k));
  return p;
}

template <class P>
class PackOf : public testing::Test {};
// the last two are wider than any register
using Packs = testing::Types<Pack<double, 8>, Pack<double, 4>, Pack<double, 2>, Pack<float, 16>, Pack<float, 8>,
                             Pack<double, 16>, Pack<float, 32>>;
TYPED_TEST_SUITE(PackOf, Packs);

TYPED_TEST(PackOf, does_in_every_lane_what_its_numbers_do) {
  using P = TypeParam;
  using T = decltype(P()[0]);
  const P a = lanes_of<P>([](int k) { return 0.7 + k; }), b = lanes_of<P>([](int k) { return 3.0 - 0.5 * k; });
  P sum = a, difference = a, product = a, quotient = a;
  sum += b, difference -= b, product *= b, quotient /= b;
  for (int k = 0; k < P::lanes; ++k) {
    const T x = a[k], y = b[k];
    EXPECT_EQ((a + b)[k], x + y);
    EXPECT_EQ((a - b)[k], x - y);
    EXPECT_EQ((a * b)[k], x * y);
    EXPECT_EQ((a / b)[k], x / y);
    EXPECT_EQ(sum[k], x + y);
    EXPECT_EQ(difference[k], x - y);
    EXPECT_EQ(product[k], x * y);
    EXPECT_EQ(quotient[k], x / y);
    EXPECT_EQ((-a)[k], -x);
    EXPECT_EQ(sqrt(a)[k], std::sqrt(x));
    EXPECT_EQ(P(2.5)[k], T(2.5));
    EXPECT_EQ(magnitude(b)[k], std::abs(y));
    EXPECT_EQ(larger(a, b)[k], std::max(x, y));
    EXPECT_NEAR(sin(b)[k], std::sin(y), 2 * std::numeric_limits<T>::epsilon());
    EXPECT_NEAR(cos(b)[k], std::cos(y), 2 * std::numeric_limits<T>::epsilon());
  }
}

TYPED_TEST(PackOf, takes_a_number_into_one_lane_and_keeps_the_others) {
  using P = TypeParam;
  const P a = lanes_of<P>([](int k) { return 0.5 + k; });
  for (int lane = 0; lane < P::lanes; ++lane) {
    P set = a;
    set.set(lane, -3);
    const P replaced = a.with_lane(lane, -3);
    for (int k = 0; k < P::lanes; ++k) {
      EXPECT_EQ(set[k], k == lane ? -3 : a[k]) << lane;
      EXPECT_EQ(replaced[k], k == lane ? -3 : a[k]) << lane;
    }
  }
}

TYPED_TEST(PackOf, keeps_its_first_lanes_and_has_zeros_behind_them_whatever_stood_there) {
  using P = TypeParam;
  P a = lanes_of<P>([](int k) { return 0.5 + k; });
  a.set(P::lanes - 1, not_a_number);
  for (int count = 0; count < P::lanes; ++count) {
    const P first = first_lanes(a, count);
    for (int k = 0; k < P::lanes; ++k) EXPECT_EQ(first[k], k < count ? a[k] : 0) << count;
  }
}

TYPED_TEST(PackOf, vanishes_when_every_lane_is_zero) {
  using P = TypeParam;
  EXPECT_TRUE(vanishes(P(0)));
  EXPECT_TRUE(vanishes(-P(0)));
  for (int lane = 0; lane < P::lanes; ++lane) {
    EXPECT_FALSE(vanishes(P(0).with_lane(lane, std::numeric_limits<decltype(P()[0])>::denorm_min())));
    EXPECT_FALSE(vanishes(P(0).with_lane(lane, not_a_number)));
  }
}

TYPED_TEST(PackOf, is_loaded_from_and_stored_to_numbers_that_follow_one_another) {
  using P = TypeParam;
  using T = decltype(P()[0]);
  T from[P::lanes + 1], to[P::lanes + 2] = {};
  for (int k = 0; k <= P::lanes; ++k) from[k] = T(k);
  P::load(from + 1).store(to + 1);  // at any place
  for (int k = 1; k <= P::lanes; ++k) EXPECT_EQ(to[k], T(k));
  EXPECT_EQ(to[0], 0);
  EXPECT_EQ(to[P::lanes + 1], 0);
}

TEST(Pack, is_shuffled_out_of_two) {
  const Pack<double, 2> a(1.0, 2.0), b(3.0, 4.0), c = shuffled<3, 0>(a, b);
  EXPECT_EQ(c[0], 4.0);
  EXPECT_EQ(c[1], 1.0);
}

TYPED_TEST(PackOf, keeps_what_is_not_finite_in_its_lane) {
  using P = TypeParam;
  P a(1.0);
  a.set(1, not_a_number);
  a.set(0, infinite);
  const P results[] = {a + P(1.0), a - P(1.0), P(2.0) * a, P(1.0) / (a - a), sqrt(a), sin(a), cos(a), magnitude(a)};
  for (const P& r : results) {
    EXPECT_TRUE(std::isnan(r[1]));
    for (int k = 2; k < P::lanes; ++k) EXPECT_FALSE(std::isnan(r[k]));
  }
  EXPECT_TRUE(std::isnan(sin(a)[0]));
  EXPECT_EQ(magnitude(-a)[0], infinite);
}

TEST(Sines, of_many_angles_are_those_of_single_ones_to_a_unit_in_the_last_place) {
  for (int n = 0; n <= 40; ++n) {
    std::vector<double> angle(n), sine(n + 1, 7.0), cosine(n + 1, 7.0);
    for (int k = 0; k < n; ++k) angle[k] = std::pow(-1.7, k % 23) * (0.3 + k);
    sines_and_cosines(angle.data(), sine.data(), cosine.data(), n);
    for (int k = 0; k < n; ++k) {
      const long double s = std::sin(static_cast<long double>(angle[k])),
                        c = std::cos(static_cast<long double>(angle[k]));
      EXPECT_LE(std::abs(sine[k] - s), 1.01L * std::abs(s) * 0x1p-52L) << angle[k];
      EXPECT_LE(std::abs(cosine[k] - c), 1.01L * std::abs(c) * 0x1p-52L) << angle[k];
    }
    EXPECT_EQ(sine[n], 7.0) << "written beyond the end";
    EXPECT_EQ(cosine[n], 7.0) << "written beyond the end";
  }
}

/// |x − exact| in units in the last place of x.
double units(double x, long double exact) {
  return static_cast<double>(std::abs(x - exact) / (std::nextafter(std::abs(x), infinite) - std::abs(x)));
}

TEST(Sines, are_to_a_unit_in_the_last_place_in_many_turns_at_their_zeros_and_beyond_those_that_are_taken_at_once) {
  std::vector<double> angle;
  for (const double range : {0.8, 4.0, 1e3, 1.99e5, 1e8})
    for (int k = 1; k < 20'000; ++k) angle.push_back(range * std::sin(0.618 * k));
  for (int quarter = 1; quarter < 127'000; quarter += quarter < 1000 ? 1 : 131) {
    const double nearest = quarter * 1.57079632679489662;
    angle.insert(angle.end(), {nearest, std::nextafter(nearest, 0.0), std::nextafter(nearest, infinite)});
  }
  std::vector<double> sine(angle.size()), cosine(angle.size());
  sines_and_cosines(angle.data(), sine.data(), cosine.data(), static_cast<int>(angle.size()));
  for (std::size_t k = 0; k < angle.size(); ++k) {
    EXPECT_LE(units(sine[k], std::sin(static_cast<long double>(angle[k]))), 1) << angle[k];
    EXPECT_LE(units(cosine[k], std::cos(static_cast<long double>(angle[k]))), 1) << angle[k];
  }
}

TEST(Sines, do_not_depend_on_where_among_others_an_angle_stands) {
  std::vector<double> angle(29), sine(29), cosine(29);
  for (int k = 0; k < 29; ++k) angle[k] = 0.1 + 0.37 * k;
  sines_and_cosines(angle.data(), sine.data(), cosine.data(), 29);
  for (int k = 0; k < 29; ++k) {
    double s, c;
    sines_and_cosines(&angle[k], &s, &c, 1);
    EXPECT_EQ(s, sine[k]);
    EXPECT_EQ(c, cosine[k]);
  }
}

TEST(Sines, of_what_is_not_finite_are_not_numbers_and_disturb_no_others) {
  const double angle[] = {0.5, infinite, 0.5, not_a_number, 1e300, 0.5, -infinite, 0.5, 0.5};
  double sine[9], cosine[9];
  sines_and_cosines(angle, sine, cosine, 9);
  for (const int k : {1, 3, 6}) EXPECT_TRUE(std::isnan(sine[k]) && std::isnan(cosine[k])) << angle[k];
  for (const int k : {0, 2, 5, 7, 8}) EXPECT_NEAR(sine[k], std::sin(0.5), 1e-16);
  EXPECT_NEAR(sine[4], std::sin(1e300), 1e-15);
}

}  // namespace
}  // namespace lanc::test
