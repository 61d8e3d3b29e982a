// Random closed models, whole and damaged: scripts/fuzz runs a hundred times as many.
#include <gtest/gtest.h>

#include "tests/support/effort.h"
#include "tests/support/fuzzed_loops.h"

namespace lanc::test {
namespace {

TEST(FuzzClosedModels, no_answer_to_a_thousand_is_wrong) {
  const int models = cases(1000);
  FuzzTally tally;
  for (std::uint64_t seed = 1; seed <= static_cast<std::uint64_t>(models); ++seed) judge_fuzzed_loops(seed, tally);
  for (const std::string& line : tally.wrong) ADD_FAILURE() << line;
  for (const auto& [what, times] : tally.statuses) std::printf("%6d  %s\n", times, what.c_str());
  std::printf("%d of %d refused as models; worst error of an answer %.1e\n", tally.refused, models, tally.worst);
  EXPECT_LT(tally.refused, models / 10);
  EXPECT_GT(tally.statuses["dense solved"] + tally.statuses["dense redundant"], models / 3);
}

/// 71094: light bodies; a pseudo-inverse truncated in the metric of M̄ lost reactions.
TEST(FuzzClosedModels, answers_that_were_wrong_are_right) {
  FuzzTally tally;
  for (const std::uint64_t seed : {71094}) judge_fuzzed_loops(seed, tally);
  for (const std::string& line : tally.wrong) ADD_FAILURE() << line;
}

}  // namespace
}  // namespace lanc::test
