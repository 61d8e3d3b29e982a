#include "lib/io/mechanism.h"

#include <fmt/format.h>

#include "lib/io/generators.h"

namespace lanc {
namespace {

std::string lower_case(std::string text) {
  for (char& c : text)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return text;
}

}  // namespace

Mechanism load_mechanism(const std::string& argument) {
  if (auto generated = generate(argument)) return *std::move(generated);
  const std::string text = lower_case(argument);
  if (text.ends_with(".toml")) return load_toml(argument);
  if (text.ends_with(".urdf") || text.ends_with(".xml")) return load_urdf(argument);
  std::string names;
  for (const GeneratorInfo& info : generators()) names += fmt::format("\n  {}", info.usage);
  throw InputError(fmt::format("'{}' is neither a model file (*.toml, *.urdf) nor a generator:{}", argument, names));
}

}  // namespace lanc
