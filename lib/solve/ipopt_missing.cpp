// In place of ipopt.cpp where LANC_WITH_IPOPT is off.
#include <stdexcept>

#include "lib/solve/ipopt.h"

namespace lanc {

bool has_ipopt() { return false; }

LeastDistanceResult solve_least_distance(const LeastDistanceProblem&, const std::vector<double>&, int) {
  throw std::logic_error("built without Ipopt; configure with -DLANC_WITH_IPOPT=ON");
}

}  // namespace lanc
