#include "lib/integrate/stabilisation.h"

#include <fmt/format.h>

#include "lib/model/error.h"

namespace lanc {

std::span<const StabilisationInfo> stabilisations() {
  static constexpr StabilisationInfo list[] = {
      {"none", "accelerations only: closure conditions drift", "", Stabilisation::none},
      {"baumgarte", "g'' + 2 a g' + a^2 g = 0, critically damped", "Baumgarte 1972, CMAME 1, 1-16",
       Stabilisation::baumgarte},
      {"projection", "after each step positions and velocities are projected in the mass metric",
       "Lubich 1991; Eich 1993, SIAM J. Numer. Anal. 30, 1467-1482", Stabilisation::projection},
      {"minimal", "independent coordinates are integrated, the others follow from the conditions",
       "Wehage & Haug 1982, J. Mech. Design 104, 247-255", Stabilisation::minimal},
  };
  return list;
}

Stabilisation find_stabilisation(std::string_view name) {
  std::string names;
  for (const StabilisationInfo& info : stabilisations()) {
    if (info.name == name) return info.value;
    names += fmt::format("{}{}", names.empty() ? "" : ", ", info.name);
  }
  throw InputError(fmt::format("there is no stabilisation '{}'; choose from {}", name, names));
}

std::string_view to_string(Stabilisation stabilisation) {
  for (const StabilisationInfo& info : stabilisations())
    if (info.value == stabilisation) return info.name;
  return "?";
}

}  // namespace lanc
