// One small mechanism of every kind that formulations might treat differently.
#pragma once

#include <functional>
#include <vector>

#include "tests/support/random_model.h"

namespace lanc::test {

/// A kind of model by name; built when asked for, since some are large.
struct Kind {
  std::string name;
  std::function<Case()> make;
  double condition = 1;  // factor of the tolerance where masses differ by decades
  bool solvable = true;  // has a solution, so that only the formulation can be the reason not to find it
};

/// Every joint kind, rheonomic joints, singular inertias, springs, sizes 0, 1 and 2000, stars, and so on; and
/// mechanisms that have no solution. Names are those of objections.csv.
std::vector<Kind> zoo();

/// Solvable and well-conditioned ones of at most `bodies` bodies, built.
std::vector<Case> small_zoo(int bodies = 64);

}  // namespace lanc::test
