// What is told of an instant: names, and points traced.
#include "lib/integrate/quantities.h"

#include <gtest/gtest.h>

#include "lib/io/mechanism.h"
#include "lib/model/error.h"

namespace lanc::test {
namespace {

std::string refusal(const Model& model, const std::string& text) {
  try {
    (void)read_point(model, text);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(Quantities, points_are_read_or_refused_with_the_mend) {
  const Model model = load_mechanism("chain:2").model;
  const TracedPoint point = read_point(model, " tip = b2 : 0.1, -2e-1 ,3 ");
  EXPECT_EQ(point.name, "tip");
  EXPECT_EQ(point.body, 1);
  EXPECT_EQ(point.offset.y, -0.2);
  EXPECT_EQ(read_point(model, "O=ground:0,0,0").body, ground);
  for (const char* text : {"b2:0,0,0", "P=b2", "=b2:0,0,0", "P=b2:0,0", "P=b2:0,0,0,0", "P=b2:0,x,0", "P=b2:0,inf,0"})
    EXPECT_NE(refusal(model, text).find("NAME=BODY:x,y,z"), std::string::npos) << text;
  EXPECT_NE(refusal(model, "P=b3:0,0,0").find("no body 'b3'"), std::string::npos);
}

/// Difference quotients along the motion itself.
TEST(Quantities, velocities_and_accelerations_of_points_are_derivatives_of_their_positions) {
  const Mechanism m = load_mechanism("random:5:seed=11:driven=no:massless=no");
  SimulationOptions options;
  options.formulation = "recursive", options.integrator = "rk4", options.stabilisation = "none", options.step = 1e-4;
  Simulation simulation(m.model, options);
  ASSERT_TRUE(simulation.begin(m.state).usable());
  Quantities quantities(m.model, {.points = {read_point(m.model, "P=b5:0.3,-0.2,0.1")}, .accelerations = true});
  std::vector<std::vector<Quantity>> at;
  for (int k = 0; k < 3; ++k) {
    at.push_back(quantities.at(simulation.instant()));
    ASSERT_TRUE(simulation.step(1).usable());
  }
  for (const char* axis : {"x", "y", "z"}) {
    const auto quotient = [&](const std::string& name) {
      return (value_of(at[2], name) - value_of(at[0], name)) / 2e-4;
    };
    const std::string a(axis);
    const double v = value_of(at[1], "P.v" + a), acceleration = value_of(at[1], "P.a" + a);
    EXPECT_NEAR(quotient("P." + a), v, 1e-5 * (1 + std::abs(acceleration)));
    EXPECT_NEAR(quotient("P.v" + a), acceleration, 1e-4 * (1 + std::abs(acceleration)));
  }
}

TEST(Quantities, that_are_not_there_are_an_error_that_names_others) {
  const std::vector<Quantity> list = {{"q.j1", 1, "rad"}, {"q.j2", 2, "rad"}, {"energy", 3, "J"}};
  EXPECT_EQ(value_of(list, "q.j2"), 2);
  EXPECT_THROW((void)value_of(list, "q.j3"), InputError);
}

}  // namespace
}  // namespace lanc::test
