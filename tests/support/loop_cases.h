// Mechanisms with closed loops for the tests, assembled and moving consistently.
#pragma once

#include <vector>

#include "tests/support/random_model.h"

namespace lanc::test {

/// Ladders and chains of four-bars with both cuts, single loops of several joints, gears, driven closures, loops that
/// share bodies, duplicated rows; all with one answer.
std::vector<Case> closed_loops();

/// A tree of all joint kinds with closures of random kinds between any of its bodies, and gears, at a state that
/// satisfies none: for a given rank only (RankPolicy).
Case tangle(std::uint64_t seed, int closures);

/// Mechanisms of which the tree has no inertia in some freedom, though their loops determine it.
std::vector<Case> held_by_loops();

/// A ladder of n four-bars whose couplers are one chain: uprights hang on it, and each is tied to the ground. At rest.
/// Leaf first, each body meets the closures of all bodies it carries.
Case long_chain_tied_to_ground(int n, double angle = 0.7);

/// Two chains side by side with n rungs between them, the lowest rods at an angle, at rest. Fills like the former.
Case chains_with_rungs(int n, double angle = 0.7);

/// Those positions, nothing moves; and for models with as many positions as velocities.
State<double> at_rest(const Model& model, std::vector<double> q);
State<double> at_rest(std::vector<double> q);

/// The largest |g| of a closure's row.
double largest_violation_of(const Model& model, const State<double>& state);

}  // namespace lanc::test
