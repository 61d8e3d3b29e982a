// Motions: orders of the integrators, laws of conservation, what stabilisation holds, and runs that are continued.
#include "lib/integrate/simulation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "lib/closure/assembly.h"
#include "lib/io/mechanism.h"
#include "lib/model/error.h"
#include "tests/support/effort.h"
#include "tests/support/random_model.h"
#include "tests/support/tolerance.h"

namespace lanc::test {
namespace {

SimulationOptions ways(const std::string& formulation, const std::string& integrator, const std::string& stabilisation,
                       double tolerance = 1e-10, double step = 1e-3) {
  SimulationOptions options;
  options.formulation = formulation, options.integrator = integrator, options.stabilisation = stabilisation;
  options.tolerance = tolerance, options.step = step;
  return options;
}

/// At `end`; fails the test where a status ends the run.
Instant at_end(const Mechanism& m, const SimulationOptions& options, double end) {
  Simulation simulation(m.model, options);
  Outcome outcome = simulation.begin(m.state);
  EXPECT_TRUE(outcome.usable()) << to_string(outcome.status) << ": " << outcome.message;
  while (outcome.usable() && simulation.t() < end) outcome = simulation.step(end);
  EXPECT_TRUE(outcome.usable()) << options.integrator << " " << options.stabilisation << ": " << outcome.message;
  return outcome.usable() ? simulation.instant() : Instant();
}

double distance(const State<double>& a, const State<double>& b) {
  double largest = 0;
  for (std::size_t k = 0; k < a.q.size(); ++k) largest = std::max(largest, std::abs(a.q[k] - b.q[k]));
  for (std::size_t k = 0; k < a.v.size(); ++k) largest = std::max(largest, std::abs(a.v[k] - b.v[k]));
  return largest;
}

bool with_sundials() {
  for (const IntegratorInfo& info : integrators())
    if (!info.fixed_step) return true;
  return false;
}

TEST(Integrators, with_fixed_steps_have_their_order) {
  // Euler parameters, a free body and a loop, so that every part of a step must have it
  for (const char* model : {"chain:3:joint=spherical", "chain:2:joint=free", "four-bar-ladder:1:angle=2.6:rate=0.5"}) {
    const Mechanism m = load_mechanism(model);
    const std::string stabilisation = m.model.has_closures() ? "projection" : "none";
    const State<double> exact = at_end(m, ways("recursive", "rk4", stabilisation, 0, 1.25e-4), 0.5).point.state;
    for (const auto& [integrator, order] : {std::pair{"rk4", 4.0}, {"generalized-alpha", 2.0}}) {
      const std::string own = find_integrator(integrator).holds_closures ? "none" : stabilisation;
      const double coarse = distance(at_end(m, ways("recursive", integrator, own, 0, 1e-2), 0.5).point.state, exact),
                   fine = distance(at_end(m, ways("recursive", integrator, own, 0, 5e-3), 0.5).point.state, exact);
      EXPECT_NEAR(std::log2(coarse / fine), order, 0.4) << model << " " << integrator << ": " << coarse << " " << fine;
    }
  }
}

TEST(Integrators, all_go_the_same_way) {
  for (const char* model :
       {"chain:3:joint=spherical", "random:6:seed=4:driven=no", "four-bar-ladder:2:angle=2.6:rate=0.5",
        LANC_SOURCE_DIR "/data/models/linkages/bricard.toml",
        LANC_SOURCE_DIR "/data/models/problems/slider-crank.toml"}) {
    const Mechanism m = load_mechanism(model);
    const bool loops = m.model.has_closures();
    const State<double> exact =
        at_end(m, ways("recursive", "rk4", loops ? "projection" : "none", 0, 2.5e-4), 0.5).point.state;
    for (const IntegratorInfo& info : integrators())
      for (const StabilisationInfo& stabilisation : stabilisations()) {
        if (objection(info, stabilisation.value) || (!loops && stabilisation.value != Stabilisation::none)) continue;
        if (info.fixed_step) continue;
        const Instant now =
            at_end(m, ways("recursive", std::string(info.name), std::string(stabilisation.name), 1e-9), 0.5);
        const double error = distance(now.point.state, exact);
        EXPECT_LT(error, info.name == "ida" ? 1e-4 : 3e-6) << model << " " << info.name << " " << stabilisation.name;
      }
  }
}

TEST(Integrators, that_are_implicit_make_no_differences) {
  if (!with_sundials()) GTEST_SKIP() << "built without SUNDIALS";
  const Mechanism m = load_mechanism("chain:20");
  for (const char* name : {"bdf", "dirk", "ida", "generalized-alpha"}) {
    Simulation simulation(m.model, ways("recursive", name, "none", 1e-6, 1e-2));
    ASSERT_TRUE(simulation.begin(m.state).usable());
    while (simulation.t() < 0.2) ASSERT_TRUE(simulation.step(0.2).usable()) << name;
    const MotionCounts counts = simulation.evaluations();
    EXPECT_GT(counts.jacobians, 0) << name;
    // 40 columns: 5 passes of eight lanes each, and nothing beside them and the evaluations
    EXPECT_EQ(counts.dual_kinematics, 5 * counts.jacobians) << name;
    EXPECT_LE(counts.kinematics, counts.rates + counts.dual_kinematics + 1) << name;
  }
}

/// Models of data/models, the linkages and problems among them.
std::vector<std::string> model_files() {
  std::vector<std::string> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(LANC_SOURCE_DIR "/data/models"))
    if (entry.path().extension() == ".toml" || entry.path().extension() == ".urdf") files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

bool something_works(const Model& model) {
  bool any = model.drives() > 0 || !model.wrenches().empty() || !model.closures().motions.empty();
  for (const PassiveCoordinate& p : model.passive())
    any = any || p.spec.damping != 0 || p.spec.torque != 0 || p.spec.friction_positive != 0;
  for (const PointSpring& s : model.springs()) any = any || s.damping != 0;
  return any;
}

TEST(Energy, is_balanced_by_work_on_every_model) {
  if (!with_sundials()) GTEST_SKIP() << "built without SUNDIALS";
  int working = 0, moved = 0, singular = 0;
  for (const std::string& file : model_files()) {
    Mechanism m = load_mechanism(file);
    if (m.model.has_closures()) {
      const AssemblyResult assembled = assemble(m.model, m.state);
      ASSERT_TRUE(assembled.assembled()) << file;
      m.state = consistent_velocities(m.model, assembled.state).state;
    }
    SimulationOptions options = ways("recursive", "erk8", "projection", 1e-11);
    // Four begin in a singular configuration. They are followed from there as far as their motion is determined.
    options.singular = SingularPolicy::pass;
    Simulation simulation(m.model, options);
    const Outcome begun = simulation.begin(m.state);
    ASSERT_TRUE(begun.usable()) << file << ": " << begun.message;
    const bool regular = Simulation(m.model, ways("recursive", "erk8", "projection", 1e-11)).begin(m.state).usable();
    singular += !regular;
    const double end = m.state.t + (m.model.name() == "andrews" ? 0.02 : build_info().sanitized ? 0.05 : 0.5);
    Outcome outcome;
    double largest = 0;
    while (outcome.usable() && simulation.t() < end) outcome = simulation.step(end);
    ASSERT_TRUE(outcome.usable() || !regular) << file << ": " << to_string(outcome.status) << " " << outcome.message;
    const Instant now = simulation.instant();
    largest = now.energy.kinetic + std::abs(now.energy.potential) + std::abs(now.point.work);
    EXPECT_LT(std::abs(now.energy_drift), 1e-8 * std::max(largest, 1e-3)) << file;
    moved += now.energy.kinetic > 0;
    if (something_works(m.model) && now.energy.kinetic > 0) {
      EXPECT_NE(now.point.work, 0) << file;
      ++working;
    }
  }
  EXPECT_GT(moved, 25);
  EXPECT_GT(working, 8);
  EXPECT_EQ(singular, 4);
}

TEST(Stabilisation, holds_what_it_promises) {
  const Mechanism m = load_mechanism(LANC_SOURCE_DIR "/data/models/linkages/bricard.toml");
  const auto violation = [&](const char* name) {
    return at_end(m, ways("recursive", "rk4", name, 0, 1e-2), 20).position_violation;
  };
  const double none = violation("none"), baumgarte = violation("baumgarte");
  EXPECT_GT(none, 1e-8);
  EXPECT_LT(baumgarte, none / 3);
  EXPECT_LT(violation("projection"), 1e-13);
  EXPECT_LT(violation("minimal"), 1e-11);
  EXPECT_LT(at_end(m, ways("recursive", "generalized-alpha", "none", 0, 1e-2), 3).position_violation, 1e-10);
}

TEST(Stabilisation, projects_with_every_formulation_to_the_same_motion) {
  const Mechanism m = load_mechanism("four-bar-ladder:2:angle=2.6:rate=0.5:cut=weld");
  const State<double> expected = at_end(m, ways("recursive", "rk4", "projection", 0, 2e-2), 1).point.state;
  for (const FormulationInfo& info : formulations()) {
    if (!info.create_double || info.objection(m.model)) continue;
    const Instant now = at_end(m, ways(std::string(info.name), "rk4", "projection", 0, 2e-2), 1);
    EXPECT_LT(distance(now.point.state, expected), 1e-9) << info.name;
    EXPECT_EQ(now.outcome.status, Status::redundant) << info.name;
  }
}

TEST(Minimal, changes_its_coordinates_on_the_way_and_says_so) {
  // the slider has dead centres, and the rod is in line with its path now and then: neither serves all the time
  const Mechanism m = load_mechanism(LANC_SOURCE_DIR "/data/models/problems/slider-crank.toml");
  const State<double> expected = at_end(m, ways("recursive", "rk4", "projection", 0, 1e-3), 10).point.state;
  SimulationOptions options = ways("partitioning", "rk4", "minimal", 0, 1e-3);
  const auto names = m.model.velocity_names();
  for (int k = 0; k < m.model.nv(); ++k)
    if (names[k] != "crank.angle_rate") options.candidates.push_back(k);
  Simulation simulation(m.model, options);
  ASSERT_TRUE(simulation.begin(m.state).usable());
  while (simulation.t() < 10) ASSERT_TRUE(simulation.step(10).usable());
  EXPECT_LT(distance(simulation.point().state, expected), 1e-8);
  ASSERT_GT(simulation.changes().size(), 0u);
  for (const IndependentChange& change : simulation.changes()) {
    EXPECT_NE(change.before, change.after);
    EXPECT_GT(change.condition_before, change.condition_after);
  }
}

TEST(Rank, of_the_bricard_linkage_is_held_where_stages_would_make_it_full) {
  const Mechanism m = load_mechanism(LANC_SOURCE_DIR "/data/models/linkages/bricard.toml");
  Simulation simulation(m.model, ways("recursive", "rk4", "none", 0, 1e-2));  // drifts by far more than 1e-10
  ASSERT_TRUE(simulation.begin(m.state).usable());
  EXPECT_EQ(simulation.held_rank(), 4);
  while (simulation.t() < 2) ASSERT_TRUE(simulation.step(2).usable());
  const Instant now = simulation.instant();
  EXPECT_GT(now.position_violation, 1e-10);
  EXPECT_EQ(now.outcome.rank, 4);
}

TEST(Singular, positions_stop_a_run_or_are_passed) {
  // N four-bars upright, B_0 with 1 m/s: horizontal after a quarter turn, where N more freedoms appear
  const Mechanism m = load_mechanism("four-bar-ladder:2:angle=0:rate=1");
  SimulationOptions options = ways("recursive", "rk4", "projection", 0, 1e-3);
  options.singular = SingularPolicy::pass;
  const Instant now = at_end(m, options, 4);
  EXPECT_LT(std::abs(now.energy_drift), 1e-6);
}

TEST(Singular, positions_are_left_on_the_branch_that_was_chosen) {
  // a parallelogram, flat on its way: it goes on as a parallelogram (straight), or as an antiparallelogram
  const Mechanism m = load_mechanism("four-bar-ladder:1:angle=2.6:rate=6");
  for (const int branch : {1, 2}) {
    SimulationOptions options = ways("recursive", "rk4", "minimal", 0, 1e-3);
    options.singular = SingularPolicy::branch;
    options.branch = branch;
    Simulation simulation(m.model, options);
    ASSERT_TRUE(simulation.begin(m.state).usable());
    while (simulation.branch_changes().empty()) ASSERT_TRUE(simulation.t() < 5 && simulation.step(5).usable());
    EXPECT_EQ(simulation.branch_changes()[0].branches, 2);
    const double end = simulation.t() + 0.05;
    while (simulation.t() < end) ASSERT_TRUE(simulation.step(end).usable());
    const Instant now = simulation.instant();
    const std::vector<double>& q = now.point.state.q;  // uprights u0 and u1, and the coupler between
    const double coupler = std::remainder(q[0] + q[1], 2 * M_PI);
    const double lost = simulation.branch_changes()[0].energy_change;
    if (branch == 1) {
      EXPECT_NEAR(coupler, 0, 1e-9);  // horizontal
      EXPECT_NEAR(lost, 0, 1e-9);
    } else {
      EXPECT_GT(std::abs(coupler), 0.01);
      EXPECT_LE(lost, 1e-12);
    }
    EXPECT_LT(std::abs(now.energy_drift), 1e-6);
    EXPECT_LT(now.position_violation, 1e-12);
  }
}

TEST(Checkpoints, lead_to_the_same_numbers_bit_by_bit) {
  for (const char* model : {"random:6:seed=4:driven=no", "four-bar-ladder:2:angle=2.6:rate=0.5"}) {
    const Mechanism m = load_mechanism(model);
    const std::string stabilisation = m.model.has_closures() ? "projection" : "none";
    for (const IntegratorInfo& info : integrators()) {
      if (m.model.has_closures() && objection(info, Stabilisation::projection)) continue;
      const SimulationOptions options = ways("partitioning", std::string(info.name), stabilisation, 1e-8, 1e-2);
      Simulation whole(m.model, options), second(m.model, options);
      ASSERT_TRUE(whole.begin(m.state).usable());
      while (whole.t() < 0.5) ASSERT_TRUE(whole.step(0.5).usable());
      const Checkpoint middle = whole.renew();
      while (whole.t() < 1) ASSERT_TRUE(whole.step(1).usable());
      ASSERT_TRUE(second.resume(middle).usable());
      while (second.t() < 1) ASSERT_TRUE(second.step(1).usable());
      EXPECT_EQ(whole.point().state.q, second.point().state.q) << model << " " << info.name;
      EXPECT_EQ(whole.point().state.v, second.point().state.v) << model << " " << info.name;
      EXPECT_EQ(whole.point().work, second.point().work) << model << " " << info.name;
      EXPECT_EQ(whole.steps().steps, second.steps().steps) << model << " " << info.name;
    }
  }
}

TEST(Options, that_do_not_go_together_are_refused_with_the_reason) {
  const Mechanism m = load_mechanism("four-bar-ladder:1:angle=2.6:rate=0.5");
  const auto refusal = [&](const SimulationOptions& options) -> std::string {
    try {
      Simulation simulation(m.model, options);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_NE(refusal(ways("recursive", "generalized-alpha", "baumgarte")).find("holds the closure conditions itself"),
            std::string::npos);
  EXPECT_NE(refusal(ways("recursive", "rk5", "none")).find("rk4"), std::string::npos);
  EXPECT_NE(refusal(ways("recursive", "rk4", "glue")).find("projection"), std::string::npos);
  EXPECT_NE(refusal(ways("recursve", "rk4", "none")).find("recursve"), std::string::npos);
}

}  // namespace
}  // namespace lanc::test
