// fuzz_closed FIRST COUNT: random closed models, each answer judged by singular values in long double. Exit code 1 when
// one is wrong. scripts/fuzz runs it on all cores.
#include <cstdio>
#include <cstdlib>

#include "lib/report/progress.h"
#include "tests/support/fuzzed_loops.h"

int main(int argc, char** argv) {
  if (argc != 3) return std::fprintf(stderr, "usage: %s FIRST_SEED COUNT\n", argv[0]), 2;
  const std::uint64_t first = std::strtoull(argv[1], nullptr, 10), count = std::strtoull(argv[2], nullptr, 10);
  lanc::test::FuzzTally tally;
  lanc::Progress progress("fuzz_closed", false);
  progress.start(static_cast<std::int64_t>(count));
  std::size_t told = 0;
  for (std::uint64_t k = 0; k < count; ++k) {
    lanc::test::judge_fuzzed_loops(first + k, tally);
    progress.advance(1, "after seed " + std::to_string(first + k));
    for (; told < tally.wrong.size(); ++told) progress.say("wrong: " + tally.wrong[told]);
  }
  progress.clear();
  for (const auto& [what, times] : tally.statuses) std::printf("%8d  %s\n", times, what.c_str());
  std::printf("seeds %llu to %llu: %d mechanisms, %d refused as models; worst error of an answer %.1e; %zu wrong\n",
              static_cast<unsigned long long>(first), static_cast<unsigned long long>(first + count - 1),
              tally.mechanisms, tally.refused, tally.worst, tally.wrong.size());
  return tally.wrong.empty() ? 0 : 1;
}
