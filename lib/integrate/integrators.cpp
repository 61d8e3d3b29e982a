#include <fmt/format.h>

#include <algorithm>

#include "lib/integrate/generalized_alpha.h"
#include "lib/integrate/rk4.h"
#include "lib/integrate/sundials_integrators.h"
#include "lib/model/error.h"

namespace lanc {

std::span<const IntegratorInfo> integrators() {
  static const std::vector<IntegratorInfo> list = [] {
    std::vector<IntegratorInfo> all = sundials_integrators();
    all.push_back({.name = "rk4",
                   .idea = "classical Runge-Kutta, fixed steps",
                   .source = "Kutta 1901",
                   .fixed_step = true,
                   .create = &create_rk4});
    all.push_back({.name = "generalized-alpha",
                   .idea = "second order, index-3 equations, fixed steps, damps high frequencies",
                   .source = "Arnold & Bruels 2007, Multibody Syst. Dyn. 18, 185-202",
                   .fixed_step = true,
                   .implicit = true,
                   .holds_closures = true,
                   .create = &create_generalized_alpha});
    std::sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.name < b.name; });
    return all;
  }();
  return list;
}

const IntegratorInfo& find_integrator(std::string_view name) {
  std::string names;
  for (const IntegratorInfo& info : integrators()) {
    if (info.name == name) return info;
    names += fmt::format("{}{}", names.empty() ? "" : ", ", info.name);
  }
  throw InputError(
      fmt::format("there is no integrator '{}'; choose from {} (those of SUNDIALS are there where "
                  "lanc was built with it)",
                  name, names));
}

}  // namespace lanc
