// Closed mechanisms of every kind that may come, bad ones included, and a judge of what formulations say of them.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "tests/support/random_model.h"

namespace lanc::test {

/// A mechanism from a seed: random loops, linkages of data/models, tangles that were assembled or could not be, driven,
/// geared; then damaged in some of these ways: bodies made light or massless, a closure doubled and moved by up to
/// 1e-3, a state moved off the manifold by up to 1e-3, a driven closure contradicted, brought to zero coordinates.
/// Throws InputError when the damage is one that a model refuses.
Case fuzzed_loops(std::uint64_t seed);

/// What formulations said of a number of mechanisms.
struct FuzzTally {
  int mechanisms = 0, refused = 0;  // refused: not a model
  double worst = 0;                 // relative error of an answer with status solved or redundant
  std::map<std::string, int> statuses;
  std::vector<std::string> wrong;  // one line each, with the seed
};

/// Draws, solves by every formulation, and judges by singular values in long double (tests/support/closed_reference.h):
/// every answer with status `solved` or `redundant` must be right to 1e-6, or, where rounding
/// its data already changes it by more, to that and 1e-4; such a status where the state violates
/// conditions, conditions contradict one another, or the answer is not unique is wrong, too.
void judge_fuzzed_loops(std::uint64_t seed, FuzzTally& tally);

}  // namespace lanc::test
