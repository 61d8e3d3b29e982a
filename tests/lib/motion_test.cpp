// Prescribed motions: derivatives against finite differences, values against their formulas, and formulas that are not.
#include "lib/model/motion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "lib/model/error.h"
#include "lib/model/expression.h"

namespace lanc::test {
namespace {

void expect_derivatives(const PrescribedMotion& motion, double t, const std::string& what) {
  const double h = 1e-3;
  const auto x = [&](double s) { return motion.at(t + s).position; };
  const double first = (8 * (x(h) - x(-h)) - (x(2 * h) - x(-2 * h))) / (12 * h);
  const double second = (16 * (x(h) + x(-h)) - (x(2 * h) + x(-2 * h)) - 30 * x(0)) / (12 * h * h);
  const MotionSample s = motion.at(t);
  EXPECT_NEAR(s.velocity, first, 1e-9 * (1 + std::abs(first))) << what << " at " << t;
  EXPECT_NEAR(s.acceleration, second, 1e-7 * (1 + std::abs(second))) << what << " at " << t;
}

TEST(Motion, of_every_kind_has_the_derivatives_of_its_position) {
  const std::pair<const char*, MotionSpec> motions[] = {
      {"constant speed", ConstantSpeed{1, -2}},   {"polynomial", Polynomial{{1, -2, 0.5, 3, -1}}},
      {"sine", Sine{0.3, 2, 1.7, 0.4}},           {"spline", SplineTable{{-1, 0, 0.5, 2, 3}, {1, -1, 2, 0, 1}}},
      {"formula", Formula{"0.3*sin(2*t) + t^2"}},
  };
  for (const auto& entry : motions)
    for (const double t : {-0.31, 0.17, 1.13, 2.47})
      expect_derivatives(*PrescribedMotion::create(entry.second), t, entry.first);
}

TEST(Motion, positions_are_what_their_names_say) {
  const double t = 0.7;
  EXPECT_DOUBLE_EQ(PrescribedMotion::create(ConstantSpeed{1, -2})->at(t).position, 1 - 2 * t);
  EXPECT_NEAR(PrescribedMotion::create(Polynomial{{1, -2, 0.5}})->at(t).position, 1 - 2 * t + 0.5 * t * t, 1e-15);
  EXPECT_DOUBLE_EQ(PrescribedMotion::create(Sine{0.3, 2, 1.7, 0.4})->at(t).position, 0.3 + 2 * std::sin(1.7 * t + 0.4));
}

TEST(Motion, a_spline_goes_through_its_table_and_is_smooth_at_its_knots) {
  const SplineTable table{{-1, 0, 0.5, 2, 3, 3.5}, {1, -1, 2, 0, 1, 1}};
  const auto motion = PrescribedMotion::create(table);
  for (std::size_t k = 0; k < table.times.size(); ++k)
    EXPECT_NEAR(motion->at(table.times[k]).position, table.values[k], 1e-12);
  for (std::size_t k = 1; k + 1 < table.times.size(); ++k) {
    const double t = table.times[k], h = 1e-9;
    EXPECT_NEAR(motion->at(t - h).velocity, motion->at(t + h).velocity, 1e-6);
    EXPECT_NEAR(motion->at(t - h).acceleration, motion->at(t + h).acceleration, 1e-5);
  }
}

TEST(Motion, outside_its_table_is_not_a_number) {
  const auto motion = PrescribedMotion::create(SplineTable{{0, 1, 2, 3}, {0, 1, 0, 1}});
  EXPECT_TRUE(std::isnan(motion->at(-0.001).position));
  EXPECT_TRUE(std::isnan(motion->at(3.001).acceleration));
  EXPECT_FALSE(std::isnan(motion->at(0).position));
  EXPECT_FALSE(std::isnan(motion->at(3).acceleration));
}

TEST(Motion, specifications_that_cannot_be_used_say_why) {
  const auto message = [](const MotionSpec& spec) {
    try {
      PrescribedMotion::create(spec);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(message(Polynomial{}).find("at least one coefficient"), std::string::npos);
  EXPECT_NE(message(ConstantSpeed{nan, 0}).find("not finite"), std::string::npos);
  EXPECT_NE(message(Sine{0, nan, 0, 0}).find("not finite"), std::string::npos);
  EXPECT_NE(message(SplineTable{{0, 1, 2}, {0, 1, 2}}).find("at least four"), std::string::npos);
  EXPECT_NE(message(SplineTable{{0, 1, 2, 3}, {0, 1, 2}}).find("4 times and 3 values"), std::string::npos);
  EXPECT_NE(message(SplineTable{{0, 1, 1, 3}, {0, 1, 2, 3}}).find("entry 3"), std::string::npos);
  EXPECT_NE(message(SplineTable{{0, 1, 2, 3}, {0, 1, 2, nan}}).find("not finite"), std::string::npos);
}

TEST(Expression, knows_precedence_functions_and_constants) {
  const double t = 0.7;
  const std::pair<const char*, double> formulas[] = {
      {"1+2*3", 7},
      {"(1+2)*3", 9},
      {"2^3^2", 512},
      {"-t^2", -t * t},
      {"2^-1", 0.5},
      {"8/4/2", 1},
      {"5-3-1", 1},
      {"--t", t},
      {"1.5e2", 150},
      {".5", 0.5},
      {"pi", std::numbers::pi},
      {"sin(t)+cos(t)*tan(t)", 2 * std::sin(t)},
      {"exp(log(t))", t},
      {"sqrt(t*t)", t},
      {"abs(-t)", t},
      {"tanh(t)", std::tanh(t)},
      {"asin(sin(t))", t},
      {"acos(cos(t))", t},
      {"atan(tan(t))", t},
      {"asin(t)+acos(t)", std::numbers::pi / 2},
      {" 1 +\t2 ", 3},
  };
  for (const auto& entry : formulas)
    EXPECT_NEAR(Expression(entry.first).at(t).position, entry.second, 1e-14) << entry.first;
}

TEST(Expression, has_the_exact_derivatives_of_every_function) {
  for (const char* text :
       {"sin(2*t)", "cos(t^2)", "tan(t/3)", "exp(-t)", "log(1+t)", "sqrt(1+t^2)", "abs(t-5)", "tanh(3*t)", "asin(t/2)",
        "acos(t/2)", "atan(3*t)", "t/(1+t)", "t^2.5", "(1+t)^-3", "2*t-t*t", "sin(t)*exp(t)/t", "t^0", "t^1"})
    for (const double t : {0.3, 1.1}) expect_derivatives(*PrescribedMotion::create(Formula{text}), t, text);
}

TEST(Expression, has_derivatives_at_zero_of_whole_powers) {
  const MotionSample square = Expression("t^2").at(0);
  EXPECT_EQ(square.velocity, 0);
  EXPECT_EQ(square.acceleration, 2);
  EXPECT_EQ(Expression("t^3").at(0).acceleration, 0);
}

TEST(Expression, that_is_malformed_is_refused_with_the_place_of_the_fault) {
  const std::pair<const char*, const char*> formulas[] = {
      {"", "character 1"},
      {"1+", "character 3"},
      {"(1+2", "closing parenthesis"},
      {"1+2)", "unexpected ')'"},
      {"sin", "parentheses"},
      {"sin 3", "parentheses"},
      {"foo(3)", "unknown name 'foo'"},
      {"2 3", "unexpected '3'"},
      {"t^t", "exponent"},
      {"1e999", "double"},
      {"#", "unexpected '#'"},
      {"x", "unknown name 'x'"},
      {"1..2", "unexpected '.'"},
      {"*3", "unexpected '*'"},
  };
  for (const auto& entry : formulas) {
    try {
      Expression expression{entry.first};
      ADD_FAILURE() << "accepted: " << entry.first;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(entry.second), std::string::npos) << entry.first << ": " << error.what();
    }
  }
}

TEST(Expression, cannot_be_made_to_overflow_the_stack_or_hang) {
  EXPECT_THROW(Expression(std::string(100'000, '(')), InputError);
  EXPECT_THROW(Expression(std::string(4'000, '(')), InputError);
  EXPECT_THROW(Expression(std::string(4'000, '-') + "t"), InputError);
  EXPECT_NO_THROW(Expression("9^9^9^9").at(1));
}

TEST(Expression, is_not_finite_at_poles_and_outside_of_domains) {
  EXPECT_FALSE(std::isfinite(Expression("1/t").at(0).position));
  EXPECT_FALSE(std::isfinite(Expression("log(t)").at(-1).position));
  EXPECT_FALSE(std::isfinite(Expression("sqrt(t)").at(-1).position));
  EXPECT_FALSE(std::isfinite(Expression("abs(t)").at(0).velocity));
  EXPECT_FALSE(std::isfinite(Expression("asin(t)").at(1.5).position));
  EXPECT_FALSE(std::isfinite(Expression("acos(t)").at(1).velocity));
}

}  // namespace
}  // namespace lanc::test
