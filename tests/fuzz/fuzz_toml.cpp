// libFuzzer target: the TOML loader (scripts/fuzz-loaders).
#include <cstddef>
#include <cstdint>

#include "tests/fuzz/loaders.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  (void)lanc::fuzz::try_input(lanc::load_toml_text, {reinterpret_cast<const char*>(data), size});
  return 0;
}
