#include "formulations/composite/composite.h"

#include <fmt/format.h>

namespace lanc {

template class Composite<double>;
template class Composite<long double>;
template class Composite<Count>;

namespace {

std::optional<std::string> objection(const Model& model) {
  constexpr std::int64_t most = std::int64_t{1} << 28;  // entries of M̄: 2 GiB of doubles
  const std::int64_t entries = VelocityPaths::entries(model);
  if (entries <= most) return std::nullopt;
  return fmt::format(
      "M̄ has {:.2g} entries along the tree, {:.2g} GB; the mechanism is too deep for a method that stores it",
      double(entries), 8e-9 * double(entries));
}

const Registration registration({.name = "composite",
                                 .idea = "M̄ from composite rigid bodies, factored LᵀDL along the tree without fill",
                                 .source = "Walker & Orin 1982; Featherstone 2005",
                                 .objection = objection,
                                 .create_double = create<Composite<double>, double>,
                                 .create_long_double = create<Composite<long double>, long double>,
                                 .create_count = create<Composite<Count>, Count>});

}  // namespace
}  // namespace lanc
