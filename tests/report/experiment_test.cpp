// The command line all experiments share, and what they measure.
#include "lib/report/experiment.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>

#include "lib/report/accuracy.h"
#include "lib/report/memory.h"
#include "lib/report/phases.h"

namespace lanc {
namespace {

class Run : public ::testing::Test {
 protected:
  ~Run() override {
    for (const char* ending : {".csv", ".json"}) std::filesystem::remove(stem_ + ending);
  }

  /// Exit code; what `body` saw is in `models` and `formulations`.
  int run(std::vector<std::string> options) {
    Experiment experiment({.name = "experiment", .question = "Well?", .models = [](bool quick) {
                             std::vector<std::string> all = {"chain:1", "chain:2", "star:3"};
                             if (quick) all.resize(1);
                             return all;
                           }});
    experiment.option("--depth", depth, "an option of its own");
    options.insert(options.begin(), {"experiment", "--quiet", "--out", stem_ + ".csv"});
    std::vector<const char*> argv;
    for (const auto& option : options) argv.push_back(option.c_str());
    return experiment.run(static_cast<int>(argv.size()), argv.data(), [&](Experiment& e) {
      models = e.models();
      formulations = e.formulations().size();
      for (const std::string& model : e.models()) {
        const Mechanism mechanism = e.load(model);
        const Cell cell = e.cell(model, mechanism.model);
        if (!e.report().has(cell))
          e.report().write(cell, std::vector<Measurement>{{"", "velocity", mechanism.state.v[0], "rad/s"}}), ++written;
        values.push_back(mechanism.state.v[0]);
      }
    });
  }

  std::vector<std::string> models;
  std::vector<double> values;
  std::size_t formulations = 0;
  int depth = 1, written = 0;

 private:
  std::string stem_ = std::filesystem::temp_directory_path() / ("lanc-experiment-" + std::to_string(::getpid()));
};

TEST_F(Run, takes_all_models_and_formulations_when_nothing_is_said) {
  EXPECT_EQ(run({}), 0);
  EXPECT_EQ(models.size(), 3U);
  EXPECT_EQ(formulations, lanc::formulations().size());
}

TEST_F(Run, globs_choose_and_other_models_are_taken_literally) {
  EXPECT_EQ(run({"--models", "chain:*", "--models", "tree:7", "--formulations", "recursiv?", "--depth", "3"}), 0);
  EXPECT_EQ(models, (std::vector<std::string>{"chain:1", "chain:2", "tree:7"}));
  EXPECT_EQ(formulations, 1U);
  EXPECT_EQ(depth, 3);
}

TEST_F(Run, bad_options_exit_2) {
  for (const std::vector<std::string>& options : {std::vector<std::string>{"--no-such-option"},
                                                  {"--repetitions", "0"},
                                                  {"--models", "nothing*"},
                                                  {"--formulations", "nothing"},
                                                  {"--models", "chain:none"},
                                                  {"--out", "no/such/folder/x.csv"}})
    EXPECT_EQ(run(options), 2) << options[0];
  EXPECT_EQ(run({"--help"}), 0);
}

TEST_F(Run, the_seed_decides_the_state) {
  EXPECT_EQ(run({}), 0);
  EXPECT_EQ(run({"--seed", "2"}), 0);
  EXPECT_EQ(run({"--seed", "2"}), 0);
  ASSERT_EQ(values.size(), 9U);
  EXPECT_NE(values[0], values[3]);
  EXPECT_EQ(values[3], values[6]);
}

TEST_F(Run, resuming_writes_what_is_missing_only) {
  EXPECT_EQ(run({}), 0);
  EXPECT_EQ(written, 3);
  EXPECT_EQ(run({"--resume"}), 0);
  EXPECT_EQ(written, 3);
  EXPECT_EQ(run({"--resume", "--depth", "2"}), 2);  // another option
}

TEST(Phases, of_every_formulation_are_counted_timed_and_right) {
  const Mechanism mechanism = load_mechanism("random:12:massless=no");
  const Reference reference(mechanism.model, mechanism.state);
  EXPECT_LT(reference.last_refinement(), 1e-15);
  for (const FormulationInfo& info : formulations()) {
    SCOPED_TRACE(info.name);
    if (info.objection(mechanism.model)) continue;
    PhaseTimer timer(info.create_double, mechanism.model, mechanism.state);
    ASSERT_TRUE(timer.outcome().usable()) << timer.outcome().message;
    const auto errors = reference.errors(timer.system(), timer.solution(), "solved");
    EXPECT_LT(errors[0].value, 1e-9);
    EXPECT_EQ(errors[0].metric, "error_vdot");
    const auto times = timer.repetition();
    ASSERT_EQ(times.size(), 5U);
    EXPECT_GT(times.back().value, 0);
    EXPECT_LT(times.back().value, 1);
    if (!info.create_count) continue;
    const auto rows = measurements(count_phases(info, mechanism.model, mechanism.state));
    double phases = 0, kinds = 0, total = 0;
    for (const auto& row : rows) {
      if (row.metric == "flops") (row.phase == "total" ? total : phases) += row.value;
      if (row.metric != "flops" && row.metric != "trig") kinds += row.value;
    }
    EXPECT_EQ(phases, total);
    EXPECT_EQ(kinds, total);
  }
}

TEST(Memory, counts_what_is_allocated_and_kept) {
  std::vector<double> kept;
  const auto bytes = heap_bytes_of([&] { kept.resize(1'000'000); });
  if (bytes != 0) {  // the address sanitizer's allocator tells nothing
    EXPECT_GE(bytes, 8'000'000);
    EXPECT_LT(bytes, 8'100'000);
  }
  EXPECT_THROW(heap_bytes_of([] { throw std::runtime_error("told"); }), std::runtime_error);
}

}  // namespace
}  // namespace lanc
