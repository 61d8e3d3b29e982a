// The experiments as a shell sees them: what they print, and options they must refuse.
#include <gtest/gtest.h>

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
  const Finished r =
      run("work-precision", {"--quiet", "--out", "-", "--problems", "x"});  // seen by the experiment itself
  EXPECT_EQ(r.exit_code, 2) << r.error;
  EXPECT_NE(r.error.find("--problems 'x' matches nothing"), std::string::npos) << r.error;
}

/// Machines differ, so that its work is bounded and not its time: small systems, and a forecast for each that is left
/// out instead of measured.
TEST(Scaling, QuickRunIsSmall) {
  const Finished r = run("scaling", {"--quick", "--list-models"});
  ASSERT_EQ(r.exit_code, 0) << r.error;
  EXPECT_NE(r.out.find("chain:3000"), std::string::npos) << r.out;
  EXPECT_EQ(r.out.find("0000"), std::string::npos) << "10 000 bodies or more:\n" << r.out;
}

TEST(Scaling, WritesEveryCell) {
  const Finished r = run("scaling", {"--quick", "--quiet", "--out", "-", "--repetitions", "1", "--formulations",
                                     "recursive*", "--models", "chain:10", "--models", "four-bar-ladder:5"});
  ASSERT_EQ(r.exit_code, 0) << r.error;
  for (const char* cell : {"chain:10,10,10,0,recursive,", "chain:10,10,10,0,recursive-loops,",
                           "four-bar-ladder:5,11,11,15,recursive,", "four-bar-ladder:5,11,11,15,recursive-loops,"})
    EXPECT_NE(r.out.find(cell), std::string::npos) << cell << " is missing in\n" << r.out;
}

}  // namespace
