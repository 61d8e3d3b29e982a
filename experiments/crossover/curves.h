// From rows to curves over n, and to where they cross.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "lib/report/crossing.h"
#include "lib/report/report.h"

namespace lanc {

/// "chain:8:joint=free" -> "chain:N:joint=free"; an argument without a size stays as it is.
std::string family_of(const std::string& model);

/// One formulation on one family of models.
struct Curve {
  std::map<int, double> flops;                 // by bodies; exact
  std::map<int, std::vector<double>> seconds;  // by bodies; the repetitions
};

struct Family {
  std::map<int, int> velocities;        // by bodies
  std::map<std::string, Curve> curves;  // by formulation
};

/// Total flops and times of all families.
std::map<std::string, Family> families_of(const std::vector<Row>& rows);

/// Where `a` begins to stay below `b`; x in bodies, over the sizes both have.
struct PairCrossing {
  int last = 0;   // the largest size compared, 0 when there is none
  int first = 0;  // the first size from which on it is below at all sizes
  CrossingPoint::Kind kind = CrossingPoint::Kind::never;
  double at = 0, lower = 0, upper = 0;  // in bodies; quartiles for measured ones
};
PairCrossing flops_crossing(const Curve& a, const Curve& b);
PairCrossing time_crossing(const Curve& a, const Curve& b, std::uint64_t seed);

/// A (fractional) number of bodies in velocities.
double in_velocities(const Family& family, double bodies);

}  // namespace lanc
