// The experiments as a shell sees them: what they print, and options they must refuse.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include "lib/report/sidecar.h"
#include "tests/support/programs.h"

namespace {

using lanc::test::Finished, lanc::test::run, lanc::test::Words;

TEST(Crossover, TellsUpToHowManyBodiesItCompared) {
  const Finished r = run("crossover", {"--quiet", "--out", "-", "--repetitions", "1", "--models", "star:2", "--models",
                                       "star:5", "--formulations", "recursive", "--formulations", "composite"});
  ASSERT_EQ(r.exit_code, 0) << r.error;
  EXPECT_NE(r.error.find("fewer operations; never: not up to 5 bodies"), std::string::npos) << r.error;
  EXPECT_EQ(r.error.find("64"), std::string::npos) << r.error;
}

TEST(Experiments, RefuseValuesThatMeanNothing) {
  struct Case {
    Words arguments;
    const char* message;
  };
  for (const auto& [arguments, message] :
       std::vector<Case>{{{"--seed", "-1"}, "--seed: '-1' is no seed; give a whole number"},
                         {{"--seed", "99999999999999999999"}, "--seed: '99999999999999999999' is no seed"},
                         {{"--seed", "1.5"}, "--seed: '1.5' is no seed"},
                         {{"--repetitions", "0"}, "--repetitions: '0' is not a number from 1 to 1000000"},
                         {{"--time-limit", "nan"}, "--time-limit: 'nan' is not a number from 0 to inf"},
                         {{"--time-limit", "-1"}, "--time-limit: '-1' is not a number from 0"},
                         {{"--memory-share", "7"}, "--memory-share: '7' is not a number from 0 to 1"},
                         {{"--memory-share", "a"}, "--memory-share: 'a' is not a number from 0 to 1"},
                         {{"--out", ""}, "--out: nothing is given"}}) {
    Words all = {"--list-models"};  // else it would measure for minutes where it does not refuse
    all.insert(all.end(), arguments.begin(), arguments.end());
    const Finished r = run("scaling", all);
    EXPECT_EQ(r.exit_code, 2) << message;
    EXPECT_NE(r.error.find(message), std::string::npos) << "expected: " << message << "\ngot: " << r.error;
  }
  EXPECT_EQ(run("scaling", {"--list-models", "--seed", "18446744073709551615"}).exit_code, 0);
}

/// A quarter of what the contract allows, in processor time: machines differ, and do something else besides.
TEST(Scaling, QuickRunIsQuick) {
  if (lanc::build_warning(lanc::build_info())) GTEST_SKIP() << "times of this build mean nothing";
  rusage used{};
  const Finished r = run("scaling", {"--quick", "--quiet", "--out", "-"});
  getrusage(RUSAGE_CHILDREN, &used);  // of all programs run so far; the others are done in no time
  EXPECT_EQ(r.exit_code, 0) << r.error;
  EXPECT_LT(used.ru_utime.tv_sec, 5);
}

}  // namespace
