// Every model of data/models, solved, against values derived by hand or by an independent computation with Newton's and
// Euler's equations of a single body; the equation stands in the file.
#include <gtest/gtest.h>

#include <filesystem>
#include <set>

#include "lib/formulation/formulation.h"
#include "lib/io/mechanism.h"
#include "lib/system/evaluator.h"
#include "tests/support/tolerance.h"

namespace lanc {
namespace {

const std::string folder = LANC_SOURCE_DIR "/data/models/";

struct Golden {
  const char* file;
  std::vector<std::string> velocities;
  int nq;
  double mass;                      // total
  std::vector<double> vdot;         // η̇
  std::vector<double> drive_force;  // of prescribed freedoms
};

const Golden golden[] = {
    {"joint-fixed.toml", {}, 0, 2, {}, {}},
    {"joint-revolute.toml", {"hinge.angle_rate"}, 1, 2, {-8.338607556178719}, {}},
    {"joint-prismatic.toml", {"slope.travel_rate"}, 1, 4, {-11.155}, {}},
    {"joint-helical.toml", {"screw.angle_rate"}, 1, 0.5, {-196.2}, {}},
    {"joint-cylindrical.toml", {"post.angle_rate", "post.travel_rate"}, 2, 1.5, {-10, 2.19}, {}},
    {"joint-universal.toml", {"cardan.first_angle_rate", "cardan.second_angle_rate"}, 2, 3, {0.5, -1.5}, {}},
    {"joint-planar.toml",
     {"table.x_rate", "table.y_rate", "table.angle_rate"},
     3,
     0.8,
     {3.1456765908834785, 0.82557671754859951, 0},
     {}},
    {"joint-spherical.toml", {"tip.wx", "tip.wy", "tip.wz"}, 4, 0.6, {43.28830188679247, -65.02754716981131, 0}, {}},
    {"joint-free.toml",
     {"flight.wx", "flight.wy", "flight.wz", "flight.vx", "flight.vy", "flight.vz"},
     7,
     10,
     {-0.2943529010820482, -0.753238476612422, 0.06646502513419099, -7.157675555934223, 0.26948291727017115,
      -1.2650414927153446},
     {}},
    {"motion-constant-speed.toml", {"hinge.angle_rate"}, 1, 3, {14.393197168017377}, {1.5353450542717518}},
    {"motion-polynomial.toml", {}, 0, 100, {}, {1101}},
    {"motion-sine.toml", {}, 0, 100, {}, {801.0767514525292}},
    {"motion-spline.toml", {}, 0, 100, {}, {1281}},
    {"motion-expression.toml", {}, 0, 100, {}, {896.2880257215018}},
    {"springs.toml", {"left_rail.travel_rate", "right_rail.travel_rate"}, 2, 3, {4, -4.700194267150883}, {}},
    {"closure-revolute.toml",
     {"left_pivot.angle_rate", "left_pin.angle_rate", "right_pivot.angle_rate"},
     3,
     4.4,
     {-6.748935653750288, 6.748935653750288, -6.748935653750288},
     {}},
    {"closure-prismatic.toml",
     {"shaft.angle_rate", "crankpin.angle_rate", "wristpin.angle_rate"},
     3,
     7.5,
     {61.0 / 30, -11.0 / 30, -5.0 / 3},
     {}},
    {"closure-distance.toml", {"hinge.angle_rate"}, 1, 100, {0.09}, {}},
    {"coupler-gear.toml",
     {"drive_shaft.angle_rate", "wheel_shaft.angle_rate"},
     2,
     9,
     {11.707317073170731, -2.9268292682926829},
     {}},
    {"gripper.urdf",
     {"left_finger.travel_rate", "right_finger.travel_rate"},
     2,
     0.5,
     {-1.4014285714285717, -2.8028571428571434},
     {}},
    {"two-link-arm.urdf",
     {"shoulder.angle_rate", "elbow.angle_rate"},
     2,
     8,
     {25.803801818669875, -36.043040766312615},
     {}},
};

Solution<double> solve(const Mechanism& m) {
  Evaluator<double> evaluator(m.model);
  const auto formulation = find_formulation("recursive")->create_double(m.model);
  Solution<double> solution(m.model);
  const Outcome outcome = formulation->solve(evaluator.system(m.state), solution);
  EXPECT_TRUE(outcome.usable()) << m.model.name() << ": " << to_string(outcome.status) << " " << outcome.message;
  EXPECT_EQ(outcome.status == Status::redundant,
            m.model.name() == "closure-revolute" || m.model.name() == "closure-prismatic");
  return solution;
}

void expect_near(const std::vector<double>& actual, const std::vector<double>& expected, const std::string& what) {
  ASSERT_EQ(actual.size(), expected.size()) << what;
  double norm = 0;
  for (const double x : expected) norm = std::max(norm, std::abs(x));
  for (std::size_t k = 0; k < expected.size(); ++k)
    EXPECT_TRUE(test::within(what, actual[k] - expected[k], 1, norm)) << k;
}

TEST(GoldenModels, load_with_their_names_sizes_and_masses) {
  for (const Golden& g : golden) {
    const Mechanism m = load_mechanism(folder + g.file);
    EXPECT_EQ(m.model.velocity_names(), g.velocities) << g.file;
    EXPECT_EQ(m.model.nq(), g.nq) << g.file;
    EXPECT_EQ(m.model.drives(), static_cast<int>(g.drive_force.size())) << g.file;
    EXPECT_EQ(m.model.name(), std::filesystem::path(g.file).stem()) << g.file;
    double mass = 0;
    for (const BodySpec& body : m.model.spec().bodies) mass += body.mass;
    EXPECT_DOUBLE_EQ(mass, g.mass) << g.file;
  }
}

TEST(GoldenModels, accelerate_as_derived_by_hand) {
  for (const Golden& g : golden) {
    const Mechanism m = load_mechanism(folder + g.file);
    const Solution<double> solution = solve(m);
    expect_near(solution.vdot, g.vdot, std::string(g.file) + " vdot");
    if (!g.drive_force.empty()) expect_near(solution.drive_force, g.drive_force, std::string(g.file) + " drive force");
  }
}

TEST(GoldenModels, the_weld_carries_weight_and_moment) {
  const Wrench<double> f = solve(load_mechanism(folder + "joint-fixed.toml")).wrench[0];
  expect_near({f.moment.x, f.moment.y, f.moment.z, f.force.x, f.force.y, f.force.z}, {5.886, 0, 0, 0, 0, 19.62},
              "wrench of the weld");
}

TEST(GoldenModels, the_cardan_joint_carries_the_gyroscopic_moment) {
  // I q̇1 q̇2 = 0.2 · 2 · 3 along y of the cross piece, which is y turned by 0.4 about z
  const Solution<double> solution = solve(load_mechanism(folder + "joint-universal.toml"));
  const Vec3<double> y = {-std::sin(0.4), std::cos(0.4), 0}, moment = solution.wrench[0].moment;
  EXPECT_TRUE(test::within("moment", dot(moment, y) - 1.2, 1, 1.2));
}

TEST(GoldenModels, the_hydraulic_cylinder_carries_the_boom) {
  const Solution<double> solution = solve(load_mechanism(folder + "closure-distance.toml"));
  expect_near(solution.lambda, {(305 * 0.09 + 100 * 9.81 * 1.5) * std::sqrt(2.0)}, "force of the cylinder");
}

TEST(GoldenModels, a_finger_that_mimics_starts_where_it_must) {
  const Mechanism m = load_mechanism(folder + "gripper.urdf");
  expect_near(m.state.q, {0, 0.01}, "positions");
}

TEST(GoldenModels, the_root_link_with_mass_weighs_on_its_weld) {
  const Mechanism m = load_mechanism(folder + "two-link-arm.urdf");
  ASSERT_EQ(m.model.spec().joints[0].name, "base_to_ground");
  const Solution<double> solution = solve(m);
  // At rest the whole arm would press with 8 g; what falls freely presses less.
  EXPECT_GT(solution.wrench[0].force.z, 5 * 9.81);
  EXPECT_LT(solution.wrench[0].force.z, 8 * 9.81);
}

TEST(GoldenModels, cover_every_file_joint_kind_and_motion) {
  std::set<std::string> files;
  for (const Golden& g : golden) files.insert(g.file);
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    if (entry.is_regular_file() && entry.path().extension() != ".md") {
      EXPECT_TRUE(files.count(entry.path().filename().string())) << entry.path() << " has no golden values";
    }
  for (unsigned char k = 0; k < joint_kinds; ++k) {
    const std::string kind(JointKind{k}.traits().name);
    ASSERT_TRUE(files.count("joint-" + kind + ".toml")) << "no golden model of a " << kind << " joint";
    const Mechanism m = load_mechanism(folder + "joint-" + kind + ".toml");
    EXPECT_EQ(m.model.link(0).kind, JointKind{k});
  }
  std::set<std::size_t> motions;
  for (const Golden& g : golden) {
    const Mechanism m = load_mechanism(folder + g.file);
    for (const JointSpec& joint : m.model.spec().joints)
      if (joint.motion) motions.insert(joint.motion->index());
  }
  EXPECT_EQ(motions.size(), std::variant_size_v<MotionSpec>);
}

}  // namespace
}  // namespace lanc
