// Model generators: mechanisms of any size from a name, a number and options.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "lib/io/mechanism.h"

namespace lanc {

/// What the table of generators says of one of them.
struct GeneratorInfo {
  std::string_view name;         // "chain"
  std::string_view usage;        // "chain:N[:joint=KIND][:seed=S]"
  std::string_view description;  // bodies, gravity, state it comes with
};

/// All generators, in the order in which they are documented (data/models/README.md).
std::span<const GeneratorInfo> generators();

/// "name:size:key=value:…"; nothing when `argument` does not begin with the name of a generator. Throws InputError when
/// it does and cannot be understood. Numbers are made of integers and + − × ÷ sqrt, equal on every machine.
std::optional<Mechanism> generate(std::string_view argument);

}  // namespace lanc
