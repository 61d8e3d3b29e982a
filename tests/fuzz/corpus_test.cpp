// Replays the kept corpus of the fuzzers with any compiler: findings of the past stay mended.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "tests/fuzz/loaders.h"

namespace lanc {
namespace {

struct Replayed {
  int inputs = 0, models = 0;
};

Replayed replay(const std::string& kind, fuzz::Loader load) {
  Replayed result;
  for (const auto& entry : std::filesystem::directory_iterator(LANC_SOURCE_DIR "/tests/fuzz/corpus/" + kind)) {
    SCOPED_TRACE(entry.path().filename());
    std::ifstream file(entry.path(), std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    bool is_model = false;
    EXPECT_NO_THROW(is_model = fuzz::try_input(load, text));
    ++result.inputs, result.models += is_model;
  }
  std::printf("%s: %d inputs, %d of them models\n", kind.c_str(), result.inputs, result.models);
  return result;
}

TEST(FuzzCorpus, is_read_or_refused_without_another_exception) {
  const Replayed toml = replay("toml", load_toml_text), urdf = replay("urdf", load_urdf_text);
  EXPECT_GT(toml.models, 0);
  EXPECT_GT(toml.inputs, toml.models);
  EXPECT_GT(urdf.models, 0);
  EXPECT_GT(urdf.inputs, urdf.models);
}

}  // namespace
}  // namespace lanc
