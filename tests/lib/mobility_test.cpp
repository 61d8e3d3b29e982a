// Rank, redundancy, mobility and verdict of published linkages: problems of the literature, one file each in
// data/models/linkages, and the N-four-bar of the IFToMM library (A02).
#include "lib/closure/mobility.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "lib/io/joint_graph.h"
#include "lib/io/mechanism.h"
#include "lib/spatial/eigen.h"
#include "lib/system/evaluator.h"
#include "tests/support/effort.h"
#include "tests/support/random_model.h"

namespace lanc::test {
namespace {

struct Expected {
  const char* model;
  int absolute_coordinates, absolute_rows, absolute_rank;  // all joints' rows, six coordinates a body
  int mobility, finite_mobility;
  Verdict verdict;
  bool some_unique;  // some reaction component that ideal hinges do not fix is unique
};

const std::string linkages = std::string(LANC_SOURCE_DIR) + "/data/models/linkages/";

Mechanism linkage(const std::string& name) {
  return name.find(':') == std::string::npos ? load_mechanism(linkages + name + ".toml") : load_mechanism(name);
}

// Ranks of the literature: García de Jalón & Bayo; Wojtyra 2005; González et al. 2006; computed on exact geometry.
const Expected table[] = {
    {"planar-four-bar", 18, 20, 17, 1, 1, Verdict::overconstrained},
    {"spherical-four-bar", 18, 20, 17, 1, 1, Verdict::overconstrained},
    {"bennett", 18, 20, 17, 1, 1, Verdict::overconstrained},
    {"bricard", 30, 30, 29, 1, 1, Verdict::overconstrained},
    {"sarrus", 30, 30, 29, 1, 1, Verdict::overconstrained},
    {"seven-hinges", 36, 35, 35, 1, 1, Verdict::regular},
    {"five-bar", 24, 25, 22, 2, 2, Verdict::overconstrained},
    {"parallel-bars-2", 18, 20, 17, 1, 1, Verdict::overconstrained},
    {"parallel-bars-3", 24, 30, 23, 1, 1, Verdict::overconstrained},
    {"parallel-bars-4", 30, 40, 29, 1, 1, Verdict::overconstrained},
    {"parallel-bars-5", 36, 50, 35, 1, 1, Verdict::overconstrained},
    {"flat-parallelogram", 18, 20, 16, 2, 1, Verdict::singular},
    {"three-collinear-bars", 12, 15, 11, 1, 0, Verdict::shaky},
    {"slider-crank", 18, 20, 17, 1, 1, Verdict::overconstrained},
    {"spatial-slider-crank", 18, 17, 17, 1, 1, Verdict::regular},
    {"stewart-gough", 78, 72, 72, 6, 6, Verdict::regular},
    {"stewart-gough-locked", 6, 6, 6, 0, 0, Verdict::regular},
    {"planar-3rrr", 42, 45, 39, 3, 3, Verdict::overconstrained},
    {"andrews", 42, 50, 41, 1, 1, Verdict::overconstrained},
    {"four-bar-ladder:1:cut=hinge", 18, 20, 17, 1, 1, Verdict::overconstrained},
    {"four-bar-ladder:2:cut=hinge", 30, 35, 29, 1, 1, Verdict::overconstrained},
    {"four-bar-ladder:5:cut=hinge", 66, 80, 65, 1, 1, Verdict::overconstrained},
    {"four-bar-ladder:10:cut=hinge", 126, 155, 125, 1, 1, Verdict::overconstrained},
    {"four-bar-ladder:1:cut=hinge:angle=1.5707963267948966", 18, 20, 16, 2, 1, Verdict::singular},
    {"four-bar-ladder:2:cut=hinge:angle=1.5707963267948966", 30, 35, 27, 3, 1, Verdict::singular},
    {"four-bar-ladder:5:cut=hinge:angle=1.5707963267948966", 66, 80, 60, 6, 1, Verdict::singular},
    {"four-bar-ladder:10:cut=hinge:angle=1.5707963267948966", 126, 155, 115, 11, 1, Verdict::singular},
};

void expect_as_published(const Expected& expected, const Mechanism& m, double open = 1e-12) {
  const Mobility found = analyse_mobility(m.model, m.state);
  SCOPED_TRACE(expected.model);
  EXPECT_LT(found.position_violation, open);
  EXPECT_EQ(found.absolute_coordinates, expected.absolute_coordinates);
  EXPECT_EQ(found.absolute_rows, expected.absolute_rows);
  EXPECT_EQ(found.absolute_rank, expected.absolute_rank);
  EXPECT_EQ(found.redundant(), expected.absolute_rows - expected.absolute_rank);
  EXPECT_EQ(found.mobility, expected.mobility);
  EXPECT_EQ(found.finite_mobility, expected.finite_mobility);
  EXPECT_EQ(to_string(found.verdict), to_string(expected.verdict));
  EXPECT_EQ(found.removable_rows.size(), static_cast<std::size_t>(found.redundant()));
}

TEST(Mobility, of_published_linkages_is_as_published) {
  for (const Expected& expected : table) expect_as_published(expected, linkage(expected.model));
}

/// Every dimension times `size`, then every frame and coordinate wrong by up to `noise`, relative.
Mechanism changed(const Mechanism& m, double size, double noise) {
  Random random(7);
  ModelSpec spec = m.model.spec();
  const auto place = [&](Placement& p) {
    p.position = size * (p.position + random.vector(noise * m.model.length()));
    const Eigen::Vector3d turn = random.vector(noise);
    p.rotation = (Eigen::AngleAxisd(turn.norm(), turn.stableNormalized()) * p.rotation).eval();
  };
  if (spec.length) *spec.length *= size;
  for (BodySpec& body : spec.bodies) body.com *= size, body.inertia *= size * size;
  for (JointSpec& joint : spec.joints) place(joint.frame), joint.pitch *= size;
  for (ClosureSpec& c : spec.closures) place(c.frame_a), place(c.frame_b), c.pitch *= size, c.length *= size;
  State<double> state = m.state;
  for (const Link& link : m.model.links()) {
    const int w = link.kind.traits().quaternion;
    for (int k = 0; k < link.nq; ++k) {
      double& q = state.q[link.q + k];
      q += noise * random.uniform(-1, 1);
      const bool length = w < 0 ? m.model.column_kind(link.v + k) == ColumnKind::translation : k < w;
      if (length) q *= size;
    }
  }
  state = checked_state(m.model, std::move(state));  // Euler parameters normalised
  return {Model::build(std::move(spec)), std::move(state)};
}

TEST(Mobility, does_not_depend_on_the_size_of_a_linkage_nor_on_noise_in_its_dimensions) {
  for (const Expected& expected : table) {
    const Mechanism m = linkage(expected.model);
    std::vector<double> sizes = {1, 1e-3, 1e3};
    sizes.resize(cases(static_cast<int>(sizes.size())));
    for (const double size : sizes) {
      SCOPED_TRACE(size);
      expect_as_published(expected, changed(m, size, 1e-12), 1e-10);
    }
  }
}

/// The same linkage as a graph of joints whose coordinates are zero where it now stands; nothing for closures that are
/// no joints.
std::optional<GraphSpec> graph(const Mechanism& m) {
  Evaluator<double> evaluator(m.model);
  evaluator.system(m.state);
  const auto pose = [&](const std::string& body) -> Placement {
    if (body.empty()) return {};
    const int i = *m.model.find_body(body);
    return {to_eigen(evaluator.body_rotation(i)), to_eigen(evaluator.positions()[i])};
  };
  GraphSpec result;
  result.model = m.model.spec();
  const auto add = [&](JointSpec joint, const Placement& frame_b) {
    const Placement a = pose(joint.parent), b = pose(joint.body);
    joint.frame.rotation = a.rotation.transpose() * b.rotation * frame_b.rotation;
    joint.frame.position = a.rotation.transpose() * (b.position + b.rotation * frame_b.position - a.position);
    result.joints.push_back({std::move(joint), frame_b, std::nullopt});
  };
  for (const JointSpec& joint : result.model.joints) add(joint, {});
  for (const ClosureSpec& c : result.model.closures) {
    if (!c.kind.traits().joint || c.motion) return std::nullopt;
    JointSpec joint;
    joint.name = c.name, joint.kind = *c.kind.traits().joint, joint.parent = c.body_a, joint.body = c.body_b;
    joint.axis = c.axis, joint.axis2 = c.axis2, joint.pitch = c.pitch;
    add(std::move(joint), c.frame_b);
  }
  result.model.joints.clear(), result.model.closures.clear();
  return result;
}

TEST(Mobility, is_the_same_for_any_choice_of_the_joints_that_are_cut) {
  int linkages_cut = 0, cuts = 0;
  for (const Expected& expected : table) {
    const std::optional<GraphSpec> whole = graph(linkage(expected.model));
    if (!whole) continue;
    ++linkages_cut;
    for (std::size_t j = 0; j < whole->joints.size(); ++j) {
      GraphSpec one = *whole;
      one.joints[j].cut = true;
      CutGraph tree;
      try {
        tree = cut_loops(std::move(one));
      } catch (const InputError&) {
        continue;  // a joint in no loop
      }
      ++cuts;
      SCOPED_TRACE("cut at " + whole->joints[j].joint.name);
      const Model model = Model::build(tree.model);
      expect_as_published(expected, {model, neutral_state(model)}, 1e-11);
    }
  }
  EXPECT_GE(linkages_cut, 20);
  EXPECT_GE(cuts, 150);
}

TEST(Mobility, of_the_locked_stewart_gough_platform_in_its_singular_poses) {
  EXPECT_EQ(analyse_mobility(linkage("stewart-gough-fichter").model, linkage("stewart-gough-fichter").state).rank, 5);
  EXPECT_EQ(analyse_mobility(linkage("stewart-gough-similar").model, linkage("stewart-gough-similar").state).rank, 5);
  EXPECT_EQ(analyse_mobility(linkage("stewart-gough-flat").model, linkage("stewart-gough-flat").state).rank, 3);
}

TEST(Mobility, no_reaction_of_these_linkages_is_unique_as_a_whole) {
  for (const char* name : {"planar-four-bar", "bricard", "sarrus", "parallel-bars-3", "parallel-bars-4"}) {
    const Mechanism m = linkage(name);
    const Mobility found = analyse_mobility(m.model, m.state);
    for (int i = 0; i < m.model.bodies(); ++i)
      EXPECT_FALSE(std::all_of(found.unique[i].begin(), found.unique[i].end(), [](bool u) { return u; }))
          << name << " joint " << i;
  }
}

TEST(Mobility, the_reactions_in_the_plane_of_a_planar_four_bar_are_unique) {
  const Mechanism m = linkage("planar-four-bar");
  const Mobility found = analyse_mobility(m.model, m.state);
  for (int i = 0; i < m.model.bodies(); ++i) {
    EXPECT_TRUE(found.unique[i][3] && found.unique[i][4]) << "force in the plane";
    EXPECT_FALSE(found.unique[i][5]) << "force across it";
  }
}

}  // namespace
}  // namespace lanc::test
