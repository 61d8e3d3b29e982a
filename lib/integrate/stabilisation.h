// How the closure conditions, of which eq. 14 knows the accelerations only, are kept at the level of positions.
#pragma once

#include <span>
#include <string_view>

namespace lanc {

/// A choice beside those of formulation and integrator.
enum class Stabilisation : unsigned char {
  none,        // they drift
  baumgarte,   // g̈ + 2α ġ + α² g = 0
  projection,  // after each step positions and velocities are moved to the nearest that satisfy them (mass metric)
  minimal      // dependent coordinates and velocities follow from independent ones at every evaluation (partitioning)
};

struct StabilisationInfo {
  std::string_view name, idea, source;
  Stabilisation value;
};
std::span<const StabilisationInfo> stabilisations();
/// Throws InputError with the list when there is none of that name.
Stabilisation find_stabilisation(std::string_view name);
std::string_view to_string(Stabilisation stabilisation);

}  // namespace lanc
