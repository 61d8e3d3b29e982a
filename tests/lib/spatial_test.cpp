// The block algebra of lib/spatial against dense 6×6 matrices.
#include "lib/spatial/spatial.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "lib/spatial/block.h"
#include "lib/spatial/eigen.h"
#include "lib/spatial/wide.h"
#include "tests/support/random_model.h"
#include "tests/support/tolerance.h"

namespace lanc::test {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

Eigen::Matrix3d tilde(const Vec3<double>& a) {
  Eigen::Matrix3d m;
  m << 0, -a.z, a.y, a.z, 0, -a.x, -a.y, a.x, 0;
  return m;
}
Eigen::Matrix3d dense(const Sym3<double>& m) {
  Eigen::Matrix3d d;
  d << m.xx, m.xy, m.xz, m.xy, m.yy, m.yz, m.xz, m.yz, m.zz;
  return d;
}
Matrix6 dense(const ArticulatedInertia<double>& I) {
  Matrix6 m;
  m << dense(I.J), to_eigen(I.H), to_eigen(I.H).transpose(), dense(I.M);
  return m;
}
Matrix6 dense(const RigidInertia<double>& M) {
  Matrix6 m;
  m << dense(M.J), tilde(M.h), tilde(M.h).transpose(), Eigen::Matrix3d::Identity() * M.mass;
  return m;
}
Vector6 dense(const Motion<double>& a) {
  Vector6 v;
  v << to_eigen(a.angular), to_eigen(a.linear);
  return v;
}
Vector6 dense(const Wrench<double>& f) {
  Vector6 v;
  v << to_eigen(f.moment), to_eigen(f.force);
  return v;
}
Matrix6 transport(const Vec3<double>& r) {
  Matrix6 B = Matrix6::Identity();
  B.bottomLeftCorner<3, 3>() = -tilde(r);
  return B;
}

template <class A, class B>
void expect_equal(const char* what, const A& a, const B& b) {
  EXPECT_TRUE(within(what, (a - b).cwiseAbs().maxCoeff(), 6, 1 + b.cwiseAbs().maxCoeff()));
}

class Spatial : public ::testing::Test {
 protected:
  Vec3<double> vector() { return from_eigen(random_.vector(2)); }
  Motion<double> motion() { return {vector(), vector()}; }
  Wrench<double> wrench() { return {vector(), vector()}; }
  Sym3<double> symmetric() { return {number(), number(), number(), number(), number(), number()}; }
  Mat3<double> matrix() { return {vector(), vector(), vector()}; }
  ArticulatedInertia<double> articulated() { return {symmetric(), matrix(), symmetric()}; }
  RigidInertia<double> rigid() { return {number(), vector(), symmetric()}; }
  double number() { return random_.uniform(-2, 2); }
  Random random_{42};
};

TEST_F(Spatial, vectors_and_matrices_are_those_of_linear_algebra) {
  const Vec3<double> a = vector(), b = vector();
  const Mat3<double> m = matrix(), n = matrix();
  expect_equal("cross", to_eigen(cross(a, b)), Eigen::Vector3d(to_eigen(a).cross(to_eigen(b))));
  expect_equal("m a", to_eigen(m * a), to_eigen(m) * to_eigen(a));
  expect_equal("m n", to_eigen(m * n), to_eigen(m) * to_eigen(n));
  expect_equal("transpose", to_eigen(transposed(m)), to_eigen(m).transpose());
  expect_equal("transpose times", to_eigen(transpose_times(m, a)), to_eigen(m).transpose() * to_eigen(a));
  const Sym3<double> s = symmetric();
  expect_equal("symmetric", to_eigen(s * a), dense(s) * to_eigen(a));
  const Eigen::Vector3d c = to_eigen(b);
  expect_equal("c + a x d", to_eigen(plus_cross(b, a, m.x)), c + to_eigen(a).cross(to_eigen(m.x)));
  expect_equal("c + m a", to_eigen(plus_product(b, m, a)), c + to_eigen(m) * to_eigen(a));
  expect_equal("c + transpose a", to_eigen(plus_transpose_product(b, m, a)), c + to_eigen(m).transpose() * to_eigen(a));
  expect_equal("c + symmetric a", to_eigen(plus_product(b, s, a)), c + dense(s) * to_eigen(a));
}

TEST_F(Spatial, tensors_in_principal_form_turn_as_r_m_rt_whatever_their_principal_values) {
  const Sym3<double> tensors[] = {symmetric(),         {0, 0, 0, 0, 0, 0},    {2, 2, 2, 0, 0, 0},
                                  {1, 0, 1, 0, 0, 0},  {1e-9, 1, 1, 0, 0, 0}, {3, 3, 3, -1, -1, -1},
                                  {-1, 2, 0, 0, 0, 0}, {1, 2, 3, 0, 0, 0}};
  const Eigen::Matrix3d turn = Eigen::Quaterniond(0.5, 0.1, -0.7, 0.3).normalized().toRotationMatrix();
  for (const Sym3<double>& m : tensors) {
    const PrincipalTensor<double> form = principal_tensor(m);
    expect_equal("itself", dense(rotated(identity3<double>(), form)), dense(m));
    expect_equal("turned", dense(rotated(from_eigen(turn), form)), turn * dense(m) * turn.transpose());
  }
  // A massless body and a rod have none about their axis, exactly: what is singular must show.
  EXPECT_EQ(rotated(identity3<double>(), principal_tensor({1, 0, 1, 0, 0, 0})).yy, 0);
}

/// Out of one register, if this processor has such.
Vec3<double> stored(const Vec3<Widest<double>>& a) {
  Vec3<double> result;
  store(a, result);
  return result;
}

TEST_F(Spatial, vectors_in_one_register_are_those_of_three_numbers) {
  using W = Widest<double>;
  const Vec3<double> a = vector(), b = vector();
  const Mat3<double> m = matrix(), n = matrix();
  const Vec3<W> p = widened<W>(a), q = widened<W>(b);
  expect_equal("sum", to_eigen(stored(p + q)), to_eigen(a + b));
  expect_equal("difference", to_eigen(stored(p - q)), to_eigen(a - b));
  expect_equal("multiple", to_eigen(stored(p * 0.3)), to_eigen(a * 0.3));
  expect_equal("cross", to_eigen(stored(cross(p, q))), to_eigen(cross(a, b)));
  expect_equal("m a", to_eigen(stored(widened<W>(m) * a)), to_eigen(m * a));
  const Mat3<W> product = widened<W>(m) * n;
  expect_equal("m n, y", to_eigen(stored(product.y)), to_eigen((m * n).y));
  std::array<double, 4> place{};
  store(p, place);
  expect_equal("stored and loaded", to_eigen(stored(load<W>(place))), to_eigen(a));
}

TEST_F(Spatial, blocks_are_transposed) {
  constexpr int n = PackedScalar<double>::lanes;
  std::array<Packed<double>, n> rows;
  for (int i = 0; i < n; ++i)
    for (int k = 0; k < n; ++k) rows[i].set(k, 10 * i + k);
  transpose(rows);
  for (int i = 0; i < n; ++i)
    for (int k = 0; k < n; ++k) EXPECT_EQ(rows[i][k], 10 * k + i);
}

TEST_F(Spatial, a_wrench_joins_a_block_in_any_lane) {
  const Wrench<double> one = wrench();
  for (int lane = 0; lane < PackedScalar<double>::lanes; ++lane) {
    const Packed<double> five(5.0);
    const auto block = with_lane<double>(Wrench<Packed<double>>{{five, five, five}, {five, five, five}}, lane, one);
    for (int k = 0; k < PackedScalar<double>::lanes; ++k) {
      EXPECT_EQ(block.moment.x[k], k == lane ? one.moment.x : 5.0);
      EXPECT_EQ(block.moment.z[k], k == lane ? one.moment.z : 5.0);
      EXPECT_EQ(block.force.y[k], k == lane ? one.force.y : 5.0);
    }
  }
}

TEST_F(Spatial, transport_is_b_and_its_transpose) {
  const Vec3<double> r = vector();
  const Motion<double> a = motion();
  const Wrench<double> f = wrench();
  expect_equal("outward", dense(moved_outward(r, a)), transport(r) * dense(a));
  expect_equal("inward", dense(moved_inward(r, f)), transport(r).transpose() * dense(f));
  EXPECT_NEAR(dot(moved_outward(r, a), f), dot(a, moved_inward(r, f)), 1e-13);
}

TEST_F(Spatial, inertias_are_symmetric_6_by_6_matrices) {
  const RigidInertia<double> R = rigid();
  const ArticulatedInertia<double> I = articulated();
  const Motion<double> a = motion();
  expect_equal("M a", dense(R * a), dense(R) * dense(a));
  expect_equal("M* a", dense(I * a), dense(I) * dense(a));
  const Wrench<double> f{vector(), vector()};
  expect_equal("f + M a", dense(plus_product(f, R, a)), dense(f) + dense(R) * dense(a));
  expect_equal("f + M* a", dense(plus_product(f, I, a)), dense(f) + dense(I) * dense(a));
  expect_equal("expanded", dense(expanded(R)), dense(R));
  ArticulatedInertia<double> sum = I;
  add(sum, R);
  expect_equal("M* + M", dense(sum), dense(I) + dense(R));
  const ArticulatedInertia<double> K = articulated();
  sum = I;
  add(sum, K);
  expect_equal("M* + M*", dense(sum), dense(I) + dense(K));
}

TEST_F(Spatial, moving_an_inertia_inward_is_b_transposed_m_b) {
  for (int k = 0; k < 10; ++k) {
    const Vec3<double> r = vector();
    const ArticulatedInertia<double> I = articulated();
    expect_equal("moved inward", dense(moved_inward(r, I)), transport(r).transpose() * dense(I) * transport(r));
  }
}

TEST_F(Spatial, releasing_a_freedom_is_a_rank_one_update) {
  ArticulatedInertia<double> I = articulated();
  const Matrix6 before = dense(I);
  const Wrench<double> U = wrench(), D = U * 0.3;
  subtract_outer(I, D, U);
  expect_equal("outer", dense(I), before - dense(D) * dense(U).transpose());
}

TEST_F(Spatial, structured_columns_are_used_as_if_they_were_full) {
  for (const ColumnKind kind : {ColumnKind::rotation, ColumnKind::translation, ColumnKind::screw}) {
    Motion<double> column = motion();
    if (kind == ColumnKind::rotation) column.linear = {};
    if (kind == ColumnKind::translation) column.angular = {};
    const Wrench<double> f = wrench();
    const ArticulatedInertia<double> I = articulated();
    EXPECT_NEAR(project(kind, column, f), dense(column).dot(dense(f)), 1e-13);
    expect_equal("M* C", dense(times_column(I, kind, column)), dense(I) * dense(column));
    Motion<double> a = motion();
    const Vector6 expected = dense(a) + 0.7 * dense(column);
    add_along(kind, column, 0.7, a);
    expect_equal("a + C s", dense(a), expected);
  }
}

}  // namespace
}  // namespace lanc::test
