// Dense algebra against its definitions, written as loops, for every scalar.
#include "lib/solve/dense_algebra.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "lib/scalar/scalar.h"

namespace lanc::test {
namespace {

template <class S>
class DenseAlgebra : public testing::Test {
 protected:
  DenseMatrix<S> random(int rows, int columns) {
    DenseMatrix<S> A(rows, columns);
    for (int c = 0; c < columns; ++c)
      for (int r = 0; r < rows; ++r) A(r, c) = S(distribution_(engine_));
    return A;
  }
  DenseVector<S> random(int size) {
    DenseVector<S> x(size);
    for (int k = 0; k < size; ++k) x[k] = S(distribution_(engine_));
    return x;
  }

  static DenseMatrix<S> transposed(const DenseMatrix<S>& A) {
    DenseMatrix<S> result(A.cols(), A.rows());
    for (int c = 0; c < A.cols(); ++c)
      for (int r = 0; r < A.rows(); ++r) result(c, r) = A(r, c);
    return result;
  }
  /// A B entry by entry; a vector is a matrix of one column.
  static DenseMatrix<S> times(const DenseMatrix<S>& A, const DenseMatrix<S>& B) {
    DenseMatrix<S> result(A.rows(), B.cols());
    for (int c = 0; c < B.cols(); ++c)
      for (int r = 0; r < A.rows(); ++r) {
        S sum(0.0);
        for (int k = 0; k < A.cols(); ++k) sum += A(r, k) * B(k, c);
        result(r, c) = sum;
      }
    return result;
  }
  static DenseMatrix<S> positive_definite(const DenseMatrix<S>& A) {
    DenseMatrix<S> result = times(A, transposed(A));
    for (int k = 0; k < result.rows(); ++k) result(k, k) += S(1.0);
    return result;
  }

  /// Entries of random matrices are of size 1, so that rounding errors grow with the size and the condition alone.
  static void expect_equal(const DenseMatrix<S>& A, const DenseMatrix<S>& B, double condition = 1) {
    ASSERT_EQ(A.rows(), B.rows());
    ASSERT_EQ(A.cols(), B.cols());
    const double rounding = to_double(Eigen::NumTraits<S>::epsilon());
    for (int c = 0; c < A.cols(); ++c)
      for (int r = 0; r < A.rows(); ++r)
        EXPECT_NEAR(to_double(A(r, c) - B(r, c)), 0, 1e3 * rounding * condition * static_cast<double>(A.rows()));
  }

 private:
  std::mt19937_64 engine_{1};
  std::uniform_real_distribution<double> distribution_{-1, 1};
};

using Scalars = testing::Types<double, long double, Count>;
TYPED_TEST_SUITE(DenseAlgebra, Scalars);

// below, at and above the sizes where Eigen changes from loops to blocks
constexpr int orders[] = {1, 2, 5, 20, 70};

TYPED_TEST(DenseAlgebra, ProductsAreSumsOfProducts) {
  for (const int n : orders) {
    const int m = n / 2 + 1;
    const auto A = this->random(m, n), B = this->random(n, 3), C = this->random(m, 4), M = this->random(n, n);
    const auto x = this->random(n), y = this->random(m);
    this->expect_equal(product(A, B), this->times(A, B));
    this->expect_equal(product(A, x), this->times(A, x));
    this->expect_equal(transposed_product(A, C), this->times(this->transposed(A), C));
    this->expect_equal(transposed_product(A, y), this->times(this->transposed(A), y));
    this->expect_equal(projected(M, B), this->times(this->transposed(B), this->times(M, B)), n);
    auto sum = y, back = x;
    add_product(A, x, sum);
    this->expect_equal(sum, y + this->times(A, x));
    subtract_product(A, x, sum);
    this->expect_equal(sum, y);
    add_transposed_product(A, y, back);
    this->expect_equal(back, x + this->times(this->transposed(A), y));
    subtract_transposed_product(A, y, back);
    this->expect_equal(back, x);
  }
}

TYPED_TEST(DenseAlgebra, TriangularSolutionsReadOneTriangle) {
  for (const int n : orders) {
    auto L = this->random(n, n);
    for (int k = 0; k < n; ++k) L(k, k) = TypeParam(n);
    auto lower = L, upper = L;
    for (int c = 0; c < n; ++c)
      for (int r = 0; r < n; ++r)
        if (r < c)
          lower(r, c) = TypeParam(0.0);
        else if (r > c)
          upper(r, c) = TypeParam(0.0);
    const auto B = this->random(n, 3);
    const auto b = this->random(n);
    this->expect_equal(this->times(lower, solve_lower(L, B)), B);
    this->expect_equal(this->times(lower, solve_lower(L, b)), b);
    this->expect_equal(this->times(this->transposed(lower), solve_lower_transposed(L, b)), b);
    this->expect_equal(this->times(upper, solve_upper(L, b)), b);
    this->expect_equal(this->times(this->transposed(upper), solve_upper_transposed(L, b)), b);
  }
}

TYPED_TEST(DenseAlgebra, FactorsSolve) {
  for (const int n : orders) {
    const auto A = this->random(n, n);
    const auto M = this->positive_definite(A);
    const auto b = this->random(n);
    Cholesky<TypeParam> cholesky;
    ASSERT_TRUE(cholesky.compute(M));
    this->expect_equal(this->times(M, cholesky.solve(b)), b, n);
    EXPECT_FALSE(cholesky.compute(-M));
    Lu<TypeParam> lu;
    lu.compute(M);
    const auto B = this->random(n, 2);
    this->expect_equal(this->times(M, lu.solve(B)), B, n);
    this->expect_equal(this->times(M, lu.solve(b)), b, n);
    auto unsymmetric = M;
    for (int k = 1; k < n; ++k) unsymmetric(0, k) += TypeParam(1.0);
    lu.compute(unsymmetric);
    this->expect_equal(this->times(this->transposed(unsymmetric), lu.solve_transposed(b)), b, n);
  }
}

TYPED_TEST(DenseAlgebra, QrIsOrthogonalTimesTriangular) {
  for (const int n : orders) {
    const int r = n / 2 + 1;
    const auto A = this->random(n, r);
    const auto x = this->random(n);
    Qr<TypeParam> qr;
    qr.compute(A);
    const DenseMatrix<TypeParam> Q = qr.Q(), first = Q.leftCols(r);
    this->expect_equal(this->times(Q, this->transposed(Q)), DenseMatrix<TypeParam>::Identity(n, n));
    this->expect_equal(this->times(first, qr.R(r)), A);
    this->expect_equal(qr.Q(r), first);
    this->expect_equal(qr.times_Q(x), this->times(Q, x));

    const auto B = this->transposed(A);  // more columns than rows: only the first r count
    PivotedQr<TypeParam> pivoted;
    pivoted.compute(B);
    const auto range = pivoted.Q(r);
    this->expect_equal(this->times(range, this->times(this->transposed(range), B)), B);
  }
}

TYPED_TEST(DenseAlgebra, ChosenPartsAndScales) {
  const auto A = this->random(4, 5);
  auto x = this->random(4);
  const std::vector<int> which{3, 1};
  for (int k = 0; k < 2; ++k) {
    EXPECT_EQ(chosen(x, which)[k], x[which[k]]);
    for (int r = 0; r < 4; ++r) EXPECT_EQ(chosen_columns(A, which)(r, k), A(r, which[k]));
    for (int c = 0; c < 5; ++c) EXPECT_EQ(chosen_rows(A, which)(k, c), A(which[k], c));
  }
  const auto before = x, two = this->random(2);
  put(two, which, x);
  EXPECT_TRUE(x[3] == two[0] && x[1] == two[1] && x[0] == before[0] && x[2] == before[2]);
  auto M = this->random(4, 4);
  const auto unscaled = M;
  scale_both_sides(before, M);
  for (int c = 0; c < 4; ++c)
    for (int r = 0; r < 4; ++r) EXPECT_EQ(M(r, c), before[r] * unscaled(r, c) * before[c]);
}

}  // namespace
}  // namespace lanc::test
