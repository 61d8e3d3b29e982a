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

}  // namespace
