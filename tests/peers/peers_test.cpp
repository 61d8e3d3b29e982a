// The comparison with other libraries: who is compared, who is refused, what stands in the CSV. With peers of this
// test's own, and with those that the program was built with.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>

#include "experiments/peers/contest.h"
#include "experiments/peers/peer.h"
#include "experiments/peers/plan.h"
#include "experiments/peers/verdict.h"
#include "lib/model/error.h"
#include "lib/report/csv.h"
#include "lib/report/experiment.h"
#include "lib/report/timing.h"
#include "lib/system/evaluator.h"
#include "tests/support/programs.h"

namespace lanc::peers {
namespace {

/// Our own solver under another gravity.
class Imitation : public PeerModel {
 public:
  Imitation(const Mechanism& mechanism, double gravity)
      : model_(scaled(mechanism.model, gravity)),
        state_(mechanism.state),
        evaluator_(model_),
        solution_(model_),
        formulation_(find_formulation("recursive")->create_double(model_)) {}
  void call() override { (void)formulation_->solve(evaluator_.system(state_), solution_); }
  std::vector<double> answer() override {
    call();
    return solution_.vdot;
  }

 private:
  static Model scaled(const Model& model, double gravity) {
    ModelSpec spec = model.spec();
    spec.gravity *= gravity;
    return Model::build(spec);
  }
  Model model_;
  State<double> state_;
  Evaluator<double> evaluator_;
  Solution<double> solution_;
  std::unique_ptr<Formulation<double>> formulation_;
};

/// Takes longer than what is timed in every repetition, on four bodies.
class Thorough : public Imitation {
 public:
  explicit Thorough(const Mechanism& mechanism) : Imitation(mechanism, 1), slow_(mechanism.model.bodies() == 4) {}
  void call() override {
    const double begin = thread_seconds();
    do Imitation::call();
    while (slow_ && thread_seconds() - begin < 0.06);
  }

 private:
  bool slow_;
};

using Values = std::vector<double>;
std::unique_ptr<PeerModel> thorough(const Mechanism& m, const Values&) { return std::make_unique<Thorough>(m); }
std::unique_ptr<PeerModel> faithful(const Mechanism& m, const Values&) { return std::make_unique<Imitation>(m, 1); }
std::unique_ptr<PeerModel> heavier(const Mechanism& m, const Values&) { return std::make_unique<Imitation>(m, 1.001); }
std::unique_ptr<PeerModel> refusing(const Mechanism&, const Values&) { throw InputError("too large for me"); }

const PeerRegistration registrations[] = {
    PeerRegistration({.name = "faithful", .version = "1", .computes = "the same", .build = faithful}),
    PeerRegistration({.name = "thorough", .version = "1", .computes = "the same", .build = thorough}),
    PeerRegistration({.name = "heavier", .version = "1", .computes = "another gravity", .build = heavier}),
    PeerRegistration({.name = "soft", .version = "1", .computes = "nearly", .build = heavier, .soft_loops = true}),
    PeerRegistration({.name = "refusing", .version = "1", .computes = "nothing", .build = refusing})};

class Peers : public ::testing::Test {
 protected:
  ~Peers() override {
    for (const char* ending : {".csv", ".json"}) std::filesystem::remove(stem_ + ending);
  }
  /// Into `rows`.
  void compare(const std::vector<std::string>& models, std::vector<std::string> options = {}) {
    Experiment experiment({.name = "peers",
                           .question = "Well?",
                           .repetitions = 2,
                           .models = [&](bool) { return models; },
                           .formulations = [](const FormulationInfo& info) { return info.recursive; }});
    options.insert(options.begin(), {"peers", "--quiet", "--out", stem_ + ".csv"});
    std::vector<const char*> argv;
    for (const auto& option : options) argv.push_back(option.c_str());
    ASSERT_EQ(experiment.run(static_cast<int>(argv.size()), argv.data(),
                             [&](Experiment& e) {
                               contest(e, models);
                               rows = e.report().rows();
                             }),
              0);
  }
  std::vector<Measurement> of(const std::string& who, const std::string& metric) const {
    std::vector<Measurement> found;
    for (const Row& row : rows)
      if (row.cell.formulation == who && row.measurement.phase == "total" && row.measurement.metric == metric)
        found.push_back(row.measurement);
    return found;
  }

  /// As a run leaves the CSV that is interrupted after its last repetition.
  void lose_summary() const {
    std::ifstream before(stem_ + ".csv");
    std::string kept;
    for (std::string line; std::getline(before, line);)
      if (line.find(",difference,") == std::string::npos) kept += line + "\n";
    std::ofstream(stem_ + ".csv") << kept;
  }

  std::vector<Row> rows;

 private:
  std::string stem_ = std::filesystem::temp_directory_path() / ("lanc-peers-" + std::to_string(::getpid()));
};

TEST_F(Peers, that_solve_the_same_model_are_timed) {
  compare({"chain:3"});
  EXPECT_EQ(of("faithful", "time").size(), 2U);
  ASSERT_EQ(of("faithful", "difference").size(), 1U);
  EXPECT_EQ(of("faithful", "difference")[0].status, "solved");
  EXPECT_LT(of("faithful", "difference")[0].value, 1e-12);
  EXPECT_EQ(of("recursive", "time").size(), 2U);
  EXPECT_EQ(of(std::string(our_inverse), "time").size(), 2U);
}

TEST_F(Peers, that_solve_another_model_are_refused) {
  compare({"chain:3"});
  for (const char* name : {"heavier", "soft"}) {  // on an open chain nobody is soft
    EXPECT_TRUE(of(name, "time").empty()) << name;
    ASSERT_EQ(of(name, "difference").size(), 1U) << name;
    EXPECT_EQ(of(name, "difference")[0].status, different) << name;
    EXPECT_GT(of(name, "difference")[0].value, 1e-5) << name;
  }
}

TEST_F(Peers, with_soft_closures_are_timed_beside_their_error) {
  compare({"four-bar-ladder:2"});
  EXPECT_EQ(of("soft", "time").size(), 2U);
  ASSERT_EQ(of("soft", "error").size(), 1U);
  EXPECT_NEAR(of("soft", "error")[0].value, 1e-3, 1e-9);
  ASSERT_EQ(of("recursive", "error").size(), 1U);
  EXPECT_LT(of("recursive", "error")[0].value, 1e-12);
  EXPECT_TRUE(of("heavier", "time").empty());
}

TEST_F(Peers, that_object_or_are_not_there_have_a_row) {
  compare({"chain:2"});
  ASSERT_EQ(of("refusing", "difference").size(), 1U);
  EXPECT_EQ(of("refusing", "difference")[0].status, "objection");
  for (const MandatoryPeer& peer : mandatory_peers()) {
    const std::string name(peer.name);
    ASSERT_FALSE(of(name, "difference").empty()) << name;
    for (const Measurement& row : of(name, "difference")) EXPECT_EQ(row.status, missing) << name;
  }
}

TEST_F(Peers, are_not_measured_again_when_a_run_is_continued) {
  compare({"chain:2"});
  const std::size_t before = rows.size();
  compare({"chain:2"}, {"--resume"});
  EXPECT_EQ(rows.size(), before);
}

TEST_F(Peers, that_are_slow_are_timed_three_times_also_when_a_run_is_continued) {
  compare({"chain:4"}, {"--repetitions", "5"});
  EXPECT_EQ(of("faithful", "time").size(), 5U);
  EXPECT_EQ(of("thorough", "time").size(), 3U);
  lose_summary();
  compare({"chain:4"}, {"--repetitions", "5", "--resume"});
  EXPECT_EQ(of("faithful", "time").size(), 5U);
  EXPECT_EQ(of("thorough", "time").size(), 3U);
  EXPECT_EQ(of("thorough", "difference").size(), 1U);
}

/// Bounds compare sides on different models, too.
TEST_F(Peers, are_timed_on_all_models_before_any_is_timed_again) {
  compare({"chain:2", "chain:3"});
  std::vector<std::pair<std::string, int>> order;  // model, repetition
  for (const Row& row : rows)
    if (row.cell.formulation == "faithful" && row.measurement.metric == "time")
      order.emplace_back(row.cell.model, *row.cell.repetition);
  EXPECT_EQ(order,
            (std::vector<std::pair<std::string, int>>{{"chain:2", 0}, {"chain:3", 0}, {"chain:2", 1}, {"chain:3", 1}}));
}

TEST_F(Peers, are_given_models_without_what_they_model_in_their_own_way) {
  compare({LANC_SOURCE_DIR "/data/models/two-link-arm.urdf"});  // has damping and friction
  EXPECT_EQ(of("faithful", "time").size(), 2U);
}

TEST(Verdict, takes_what_is_not_finite_or_not_there_for_another_answer) {
  EXPECT_LT(difference({1, 2 + 1e-9}, {1, 2}), same_answer);
  EXPECT_GT(difference({1, 2 + 1e-7}, {1, 2}), same_answer);
  EXPECT_FALSE(same(difference({1, std::nan("")}, {1, 2}), true));
  EXPECT_FALSE(same(difference({1}, {1, 2}), true));
  EXPECT_EQ(difference({0, 0}, {0, 0}), 0);
}

/// Whatever peers there are in the program: all of them agree with us, on all kinds of joints they take.
TEST(PeersProgram, has_a_row_for_every_pair_and_finds_no_peer_that_disagrees) {
  const std::string humanoid = LANC_SOURCE_DIR "/data/models/robots/humanoid.toml";
  const test::Words models = {
      "chain:2", "chain:3:joint=prismatic", "chain:3:joint=spherical",   "chain:1:joint=free", "chain:100",
      humanoid,  "four-bar-ladder:2",       "four-bar-ladder:2:cut=weld"};
  test::Words arguments = {"--quick", "--quiet", "--repetitions", "1", "--out", "-"};
  for (const std::string& model : models) arguments.insert(arguments.end(), {"--models", model});
  const test::Finished r = test::run("peers", arguments);
  ASSERT_EQ(r.exit_code, 0) << r.error;
  std::vector<Row> rows;
  const std::vector<CsvRecord> records = read_csv(r.out);
  for (std::size_t i = 1; i < records.size(); ++i) rows.push_back(csv_row(records[i].fields));
  for (const Row& row : rows) {
    EXPECT_NE(row.measurement.status, different) << row.cell.model << " " << row.cell.formulation;
    if (row.measurement.metric == "error" && row.measurement.status == "redundant") {
      EXPECT_LT(row.measurement.value, 1e-12) << row.cell.model << " " << row.cell.formulation;
    }
  }
  for (const std::string& model : models)
    for (const MandatoryPeer& peer : mandatory_peers())
      EXPECT_TRUE(std::any_of(rows.begin(), rows.end(),
                              [&](const Row& row) {
                                return row.cell.model == short_name(model) && row.cell.formulation == peer.name &&
                                       row.cell.parameters == "task=" + std::string(to_string(peer.task));
                              }))
          << model << " " << peer.name;
}

}  // namespace
}  // namespace lanc::peers
