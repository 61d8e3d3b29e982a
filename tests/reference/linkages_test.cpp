// Numbers of overconstrained and singular linkages beyond the ranks of tests/lib/mobility_test.cpp: closed loops from
// their Denavit-Hartenberg parameters, and how near parallel robots are to their singular poses.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <numbers>

#include "lib/closure/assembly.h"
#include "lib/closure/mobility.h"
#include "lib/io/mechanism.h"
#include "lib/spatial/eigen.h"
#include "lib/system/closure_jacobian.h"
#include "lib/system/evaluator.h"
#include "tests/support/tolerance.h"

namespace lanc::test {
namespace {

constexpr double pi = std::numbers::pi, degree = pi / 180;

struct Link {
  double length, twist;
};

/// A loop of hinges by standard Denavit-Hartenberg parameters without offsets: joint i turns about z by θ_i, its link
/// leads `length` along x and turns by `twist` about it; the end of the last link is welded to where the first began.
Model loop(const std::vector<Link>& links) {
  ModelSpec spec;
  spec.length = 1;
  Placement next;
  for (std::size_t i = 0; i < links.size(); ++i) {
    BodySpec body;
    body.name = "link" + std::to_string(i + 1);
    body.mass = 1;
    body.inertia.setIdentity();
    JointSpec joint;
    joint.name = "theta" + std::to_string(i + 1);
    joint.kind = *find_joint_kind("revolute");
    if (i > 0) joint.parent = spec.bodies.back().name;
    joint.body = body.name;
    joint.frame = next;
    next.position = {links[i].length, 0, 0};
    next.rotation = Eigen::AngleAxisd(links[i].twist, Eigen::Vector3d::UnitX()).toRotationMatrix();
    spec.bodies.push_back(body);
    spec.joints.push_back(joint);
  }
  ClosureSpec weld;
  weld.name = "weld";
  weld.kind = *find_closure_kind("fixed");
  weld.body_a = spec.bodies.back().name;
  weld.frame_a = next;
  spec.closures.push_back(weld);
  return Model::build(spec);
}

State<double> turned(const Model& model, std::vector<double> angles) {
  State<double> state = neutral_state(model);
  state.q = std::move(angles);
  return state;
}

void expect_movable(const char* name, const std::vector<Link>& links, std::vector<double> angles, int redundant) {
  const Model model = loop(links);
  const Mobility found = analyse_mobility(model, turned(model, std::move(angles)));
  EXPECT_TRUE(within(name, found.position_violation, 1, 1));
  EXPECT_EQ(found.redundant(), redundant) << name;
  EXPECT_EQ(found.finite_mobility, 1) << name;
  EXPECT_EQ(to_string(found.verdict), to_string(Verdict::overconstrained)) << name;
}

/// a / sin α = b / sin β.
std::vector<Link> bennett(double b) {
  const double beta = 48.590377890729 * degree;
  return {{1, 30 * degree}, {b, beta}, {1, 30 * degree}, {b, beta}};
}

TEST(Linkages, spherical_four_bar_closes_and_moves) {
  expect_movable("spherical", {{0, 0.9}, {0, 0.6}, {0, 1.0}, {0, 0.8}},
                 {1.353277214544220, 1.297422526659288, 1.284628982574732, 1.599280815076939}, 3);
}

TEST(Linkages, bennett_closes_and_moves_and_does_not_with_another_length) {
  const double second = 2.385409655587862;
  const std::vector<double> angles = {2, second, 2 * pi - 2, 2 * pi - second};
  expect_movable("Bennett", bennett(1.5), angles, 3);
  const Model wrong = loop({bennett(1.5)[0], bennett(1.51)[1], bennett(1.5)[2], bennett(1.5)[3]});
  EXPECT_FALSE(assemble(wrong, turned(wrong, angles)).assembled());
}

TEST(Linkages, orthogonal_bricard_closes_and_moves_and_does_not_with_another_twist) {
  std::vector<Link> links;
  std::vector<double> angles;
  for (int i = 0; i < 3; ++i) {
    links.insert(links.end(), {{1, pi / 2}, {1, -pi / 2}});
    angles.insert(angles.end(), {1.310998159896913, -1.776629255516735});
  }
  expect_movable("Bricard", links, angles, 1);
  links[2].twist += 0.05;
  const Model wrong = loop(links);
  EXPECT_FALSE(assemble(wrong, turned(wrong, angles)).assembled());
}

TEST(Linkages, ladder_of_three_has_the_computed_ranks) {
  for (const bool level : {false, true}) {
    const Mechanism m =
        load_mechanism(std::string("four-bar-ladder:3:cut=hinge:angle=") + (level ? "1.5707963267948966" : "0"));
    const Mobility found = analyse_mobility(m.model, m.state);
    EXPECT_EQ(found.absolute_rows, 50);
    EXPECT_EQ(found.absolute_rank, level ? 38 : 41);
    EXPECT_EQ(found.mobility, level ? 4 : 1);
  }
}

const std::string linkages = std::string(LANC_SOURCE_DIR) + "/data/models/linkages/";

/// Rows of the legs' forces on the platform: unit vector along the leg, moment about the base's origin.
Eigen::MatrixXd leg_forces(const Mechanism& m, State<double> state) {
  Evaluator<double> evaluator(m.model);
  const System<double>& system = evaluator.system(checked_state(m.model, std::move(state)));
  ClosureJacobian<double> jacobian(m.model);
  jacobian.evaluate(system);
  const Eigen::Matrix3d R = to_eigen(evaluator.body_rotation(0));
  const Eigen::Vector3d centre = to_eigen(evaluator.positions()[0]);
  Eigen::MatrixXd rows(jacobian.rows(), 6);
  for (int k = 0; k < jacobian.rows(); ++k) {
    Eigen::Matrix<double, 6, 1> row = Eigen::Matrix<double, 6, 1>::Zero();
    for (int p = jacobian.starts()[k]; p < jacobian.starts()[k + 1]; ++p)
      row[jacobian.columns()[p]] = jacobian.values()[p];
    const Eigen::Vector3d force = R * row.tail<3>(), moment = R * row.head<3>() + centre.cross(force);
    rows.row(k) << force.transpose(), moment.transpose();
  }
  return rows;
}

TEST(Linkages, stewart_gough_platform_is_as_far_from_singular_as_computed) {
  const Mechanism m = load_mechanism(linkages + "stewart-gough-locked.toml");
  const Eigen::MatrixXd home = leg_forces(m, m.state);
  EXPECT_NEAR(home.jacobiSvd().singularValues()[5], 0.3847, 0.5e-4);
  EXPECT_NEAR(std::abs(home.determinant()), 0.5485846, 0.5e-7);
  State<double> state = m.state;
  state.q = {0, 0, 1, std::cos(44.5 * degree), 0, 0, std::sin(44.5 * degree)};
  EXPECT_NEAR(leg_forces(m, state).jacobiSvd().singularValues()[5], 8.58e-3, 0.5e-5);
}

/// G without the columns of joints whose names begin with `independent`: square when those are as many as the freedoms,
/// and singular where they fail as independent coordinates.
Eigen::MatrixXd dependent_columns(const Model& model, const State<double>& state, const std::string& independent) {
  Evaluator<double> evaluator(model);
  ClosureJacobian<double> jacobian(model);
  jacobian.evaluate(evaluator.system(state));
  const std::vector<std::string> names = model.velocity_names();
  std::vector<int> place(model.nv(), -1);
  int dependent = 0;
  for (int k = 0; k < model.nv(); ++k)
    if (names[k].rfind(independent, 0) != 0) place[k] = dependent++;
  Eigen::MatrixXd G = Eigen::MatrixXd::Zero(jacobian.rows(), dependent);
  for (int r = 0; r < jacobian.rows(); ++r)
    for (int p = jacobian.starts()[r]; p < jacobian.starts()[r + 1]; ++p)
      if (place[jacobian.columns()[p]] >= 0) G(r, place[jacobian.columns()[p]]) = jacobian.values()[p];
  return G;
}

/// The state of `m` in which the frame at `point` of the platform stands at `pose`.
State<double> held(const Mechanism& m, const Placement& pose, const Eigen::Vector3d& point) {
  ModelSpec spec = m.model.spec();
  ClosureSpec hold;
  hold.name = "hold";
  hold.kind = *find_closure_kind("fixed");
  hold.body_b = "platform";
  hold.frame_a = pose;
  hold.frame_b.position = point;
  spec.closures.push_back(hold);
  const AssemblyResult assembled = assemble(Model::build(spec), m.state);
  EXPECT_TRUE(assembled.assembled()) << assembled.message;
  return assembled.state;
}

Eigen::Matrix3d about_z(double angle) { return Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()).toRotationMatrix(); }

TEST(Linkages, leg_lengths_of_the_stewart_gough_platform_fail_as_coordinates_where_its_legs_are_singular) {
  const Mechanism m = load_mechanism(linkages + "stewart-gough.toml");
  const auto smallest = [&](double angle) {
    const State<double> state = held(m, {about_z(angle), {0, 0, 1}}, {0, 0, 0});
    const Eigen::MatrixXd G = dependent_columns(m.model, state, "slide");
    EXPECT_EQ(G.rows(), G.cols());
    EXPECT_EQ(analyse_mobility(m.model, state).mobility, 6);  // whatever the choice of coordinates
    return G.jacobiSvd().singularValues().minCoeff();
  };
  EXPECT_GT(smallest(0), 0.05);
  EXPECT_GT(smallest(89 * degree), 1e-3);
  EXPECT_LT(smallest(90 * degree), 1e-10);
}

struct Planar3rrr {
  Mechanism mechanism = load_mechanism(linkages + "planar-3rrr.toml");
  Eigen::Vector3d corners[3] = {{0, 0, 0}, {std::sqrt(3) / 4, 0, 0}, {std::sqrt(3) / 8, 0.375, 0}};
  Eigen::Vector3d centre{std::sqrt(3) / 8, 0.125, 0};
  Eigen::Vector3d home{0, 0, 0};  // of the centre, in the world

  /// With the platform turned at its centre.
  State<double> at(double angle) const { return held(mechanism, {about_z(angle), home}, centre); }

  /// Rows of the distal links' forces on the platform: unit vector along the link, moment about the centre.
  Eigen::Matrix3d distal_forces(double angle) const {
    Evaluator<double> evaluator(mechanism.model);
    evaluator.system(at(angle));
    Eigen::Matrix3d rows;
    for (int leg = 0; leg < 3; ++leg) {
      const int distal = *mechanism.model.find_body("distal" + std::to_string(leg + 1));
      const Eigen::Vector3d arm = about_z(angle) * (corners[leg] - centre);
      const Eigen::Vector3d u = (home + arm - to_eigen(evaluator.positions()[distal])).normalized();
      rows.row(leg) << u.x(), u.y(), arm.cross(u).z();
    }
    return rows;
  }
};

TEST(Linkages, planar_3rrr_is_as_far_from_its_second_kind_of_singularity_as_computed) {
  const Planar3rrr robot;
  const Eigen::Vector3d level = robot.distal_forces(0).jacobiSvd().singularValues();
  EXPECT_NEAR(level[0], 1.2247, 0.5e-4);
  EXPECT_NEAR(level[1], 1.2247, 0.5e-4);
  EXPECT_NEAR(level[2], 0.38275, 0.5e-5);
  EXPECT_NEAR(robot.distal_forces(-0.5).jacobiSvd().singularValues()[2], 0.0767, 0.5e-4);
}

TEST(Linkages, shoulder_angles_of_the_3rrr_fail_as_coordinates_where_its_distal_links_meet_in_a_point) {
  const Planar3rrr robot;
  double singular = -1, regular = -0.5;  // the determinant has another sign at either end
  ASSERT_LT(robot.distal_forces(singular).determinant() * robot.distal_forces(regular).determinant(), 0);
  const double sign = robot.distal_forces(regular).determinant();
  while (regular - singular > 1e-12) {
    const double middle = (singular + regular) / 2;
    (robot.distal_forces(middle).determinant() * sign > 0 ? regular : singular) = middle;
  }
  const auto smallest = [&](double angle) {  // wrists are hinges: three rows of five say nothing in the plane
    const Eigen::MatrixXd G = dependent_columns(robot.mechanism.model, robot.at(angle), "shoulder");
    return G.jacobiSvd().singularValues().minCoeff();
  };
  EXPECT_LT(smallest(regular), 1e-10);
  EXPECT_GT(smallest(-0.5), 1e-3);
  EXPECT_GT(smallest(0), 1e-2);
}

}  // namespace
}  // namespace lanc::test
