#include <gtest/gtest.h>

#include "lib/scalar/count_eigen.h"
#include "lib/scalar/scalar.h"

namespace lanc::test {
namespace {

/// What `work` does.
template <class Work>
Tally counted(Work work) {
  const Tally before = Count::tally();
  work();
  return Count::tally() - before;
}

void expect_tally(const Tally& t, std::array<std::int64_t, 6> expected) {
  EXPECT_EQ((std::array<std::int64_t, 6>{t.add, t.sub, t.mul, t.div, t.sqrt, t.trig}), expected);
}

TEST(Count, counts_every_operation_in_its_own_counter) {
  Count a = 3.0, b = 2.0, c;
  expect_tally(counted([&] { c = a + b; }), {1, 0, 0, 0, 0, 0});
  expect_tally(counted([&] { c = a - b; }), {0, 1, 0, 0, 0, 0});
  expect_tally(counted([&] { c = a * b; }), {0, 0, 1, 0, 0, 0});
  expect_tally(counted([&] { c = a / b; }), {0, 0, 0, 1, 0, 0});
  expect_tally(counted([&] { c = sqrt(a); }), {0, 0, 0, 0, 1, 0});
  expect_tally(counted([&] { c = sin(a); }), {0, 0, 0, 0, 0, 1});
  expect_tally(counted([&] { c = cos(a); }), {0, 0, 0, 0, 0, 1});
  expect_tally(counted([&] { c += b; }), {1, 0, 0, 0, 0, 0});
  expect_tally(counted([&] { c -= b; }), {0, 1, 0, 0, 0, 0});
  expect_tally(counted([&] { c *= b; }), {0, 0, 1, 0, 0, 0});
  expect_tally(counted([&] { c /= b; }), {0, 0, 0, 1, 0, 0});
}

TEST(Count, does_not_count_signs_comparisons_and_conversions) {
  Count a = 3.0, b = 2.0;
  expect_tally(counted([&] {
                 EXPECT_TRUE(a > b && a >= b && b < a && b <= a && a != b && !(a == b));
                 EXPECT_EQ((-a).value(), -3);
                 EXPECT_EQ(double(abs(-a)), 3);
                 EXPECT_EQ(to_double(a), 3);
               }),
               {0, 0, 0, 0, 0, 0});
}

TEST(Count, computes_what_double_computes) {
  const Count a = 3.7, b = -2.1;
  EXPECT_EQ((a + b).value(), 3.7 + -2.1);
  EXPECT_EQ((a - b).value(), 3.7 - -2.1);
  EXPECT_EQ((a * b).value(), 3.7 * -2.1);
  EXPECT_EQ((a / b).value(), 3.7 / -2.1);
  EXPECT_EQ(sqrt(a).value(), std::sqrt(3.7));
  EXPECT_EQ(sin(b).value(), std::sin(-2.1));
  EXPECT_EQ(cos(b).value(), std::cos(-2.1));
}

TEST(Count, flops_are_all_but_trigonometric_functions) {
  EXPECT_EQ((Tally{.add = 1, .sub = 2, .mul = 4, .div = 8, .sqrt = 16, .trig = 32}).flops(), 31);
}

TEST(Count, runs_in_the_matrices_of_eigen) {
  using Matrix = Eigen::Matrix<Count, 4, 4>;
  const Matrix A = Matrix::Constant(2.0), B = Matrix::Constant(0.5);
  Matrix C;
  const Tally t = counted([&] { C = A.lazyProduct(B); });
  EXPECT_EQ(C(1, 2).value(), 4);
  EXPECT_EQ(t.mul, 64);
  EXPECT_EQ(t.add, 48);
}

}  // namespace
}  // namespace lanc::test
