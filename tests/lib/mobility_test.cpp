// Rank, redundancy, mobility and verdict of published linkages: problems of the literature, one file each in
// data/models/linkages, and the N-four-bar of the IFToMM library (A02).
#include "lib/closure/mobility.h"

#include <gtest/gtest.h>

#include "lib/io/mechanism.h"

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

TEST(Mobility, of_published_linkages_is_as_published) {
  for (const Expected& expected : table) {
    const Mechanism m = linkage(expected.model);
    const Mobility found = analyse_mobility(m.model, m.state);
    SCOPED_TRACE(expected.model);
    EXPECT_LT(found.position_violation, 1e-12);
    EXPECT_EQ(found.absolute_coordinates, expected.absolute_coordinates);
    EXPECT_EQ(found.absolute_rows, expected.absolute_rows);
    EXPECT_EQ(found.absolute_rank, expected.absolute_rank);
    EXPECT_EQ(found.redundant(), expected.absolute_rows - expected.absolute_rank);
    EXPECT_EQ(found.mobility, expected.mobility);
    EXPECT_EQ(found.finite_mobility, expected.finite_mobility);
    EXPECT_EQ(to_string(found.verdict), to_string(expected.verdict));
    EXPECT_EQ(found.removable_rows.size(), static_cast<std::size_t>(found.redundant()));
  }
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
