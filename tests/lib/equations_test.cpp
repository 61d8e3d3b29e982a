// Eq. 14 used row by row (lib/system/equations.h) against the naive dense one.
#include "lib/system/equations.h"

#include <gtest/gtest.h>

#include "lib/system/evaluator.h"
#include "tests/support/naive.h"
#include "tests/support/tolerance.h"

namespace lanc::test {
namespace {

class Equations : public ::testing::TestWithParam<int> {
 protected:
  Case c_ = random_case(2200 + GetParam(), 1 + GetParam());
  System<long double> system_ = system_in_long_double(c_);
  Solution<long double> reference_ = solve_eq14_naively(system_);
  Norms size_ = sizes(system_, reference_);

  void expect_near(const char* what, const Solution<long double>& a, const Solution<long double>& b) const {
    EXPECT_TRUE(within_relative(what, relative(difference(c_.model, a, b), size_).worst(), 1e-14, 1));
  }
};

TEST_P(Equations, accelerations_and_wrenches_follow_from_vdot) {
  Solution<long double> s(c_.model);
  s.vdot = reference_.vdot;
  accelerations(system_, system_.rhs, s);
  wrenches(system_, system_.rhs, s);
  drive_forces(system_, s);
  expect_near("all", s, reference_);
}

TEST_P(Equations, inverse_dynamics_of_the_answer_is_zero_and_linear_in_the_inertia) {
  Solution<long double> s(c_.model);
  s.vdot = reference_.vdot;
  std::vector<long double> tau, more;
  inverse_dynamics(system_, s, tau);
  for (const long double x : tau) EXPECT_TRUE(within_relative("tau", static_cast<double>(x), 1e-14, size_.wrench));
  // adding τ to the loads gives the η̇ it was computed for
  for (int k = 0; k < c_.model.nv(); ++k) s.vdot[k] += 0.1L * (k + 1);
  inverse_dynamics(system_, s, more);
  System<long double> loaded = system_;
  for (int k = 0; k < c_.model.nv(); ++k) loaded.rhs.tau[k] += more[k];
  const Solution<long double> again = solve_eq14_naively(loaded);
  const Norms size = sizes(loaded, again);
  EXPECT_TRUE(within_relative("vdot", relative(difference(c_.model, again, s), size).worst(), 1e-13, 1));
}

TEST_P(Equations, residual_vanishes_for_the_answer_and_shows_every_change_of_it) {
  RightHandSide<long double> r(c_.model);
  const auto largest = [&](const Solution<long double>& s) {
    residual(system_, system_.rhs, s, r);
    long double worst = 0;
    const auto grow = [&](const Vec3<long double>& a) {
      worst = std::max({worst, std::abs(a.x), std::abs(a.y), std::abs(a.z)});
    };
    for (int i = 0; i < c_.model.bodies(); ++i)
      grow(r.force[i].moment), grow(r.force[i].force), grow(r.bias[i].angular), grow(r.bias[i].linear);
    for (const long double x : r.tau) worst = std::max(worst, std::abs(x));
    return static_cast<double>(worst);
  };
  const double scale = 1 + size_.wrench + size_.acceleration;
  EXPECT_TRUE(within_relative("residual", largest(reference_), 1e-15, scale));
  for (int i = 0; i < c_.model.bodies(); ++i) {
    Solution<long double> s = reference_;
    s.acceleration[i].linear.y += 1e-3;
    EXPECT_GT(largest(s), 1e-6) << "acceleration of body " << i;
    s = reference_;
    s.wrench[i].moment.z += 1e-3;
    EXPECT_GT(largest(s), 1e-6) << "wrench of body " << i;
  }
  for (int k = 0; k < c_.model.nv(); ++k) {
    Solution<long double> s = reference_;
    s.vdot[k] += 1e-3;
    EXPECT_GT(largest(s), 1e-6) << "velocity " << k;
  }
}

TEST_P(Equations, backward_error_is_at_rounding_for_the_answer_and_sees_a_wrong_one) {
  EXPECT_LT(backward_error(system_, reference_).normwise, 1e-17);
  if (c_.model.nv() == 0) return;
  Solution<long double> s = reference_;
  s.vdot[0] += 1;
  EXPECT_GT(backward_error(system_, s).normwise, 1e-6);
  EXPECT_GT(backward_error(system_, s).componentwise, 1e-6);
  s.vdot[0] = std::numeric_limits<long double>::quiet_NaN();
  EXPECT_TRUE(std::isnan(backward_error(system_, s).normwise));
}

INSTANTIATE_TEST_SUITE_P(random_trees, Equations, ::testing::Range(0, 12));

}  // namespace
}  // namespace lanc::test
