// What a closed mechanism can do: rank, redundancy, mobility, and which reactions are unique. Dense: for mechanisms up
// to some hundred closure conditions.
#pragma once

#include <array>
#include <string_view>
#include <vector>

#include "lib/model/model.h"

namespace lanc {

enum class Verdict : unsigned char {
  regular,          // all closure conditions are independent
  overconstrained,  // some are redundant in every configuration of the branch
  singular,         // more are dependent here than in neighbouring configurations
  shaky             // moves to first order, and nowhere
};
constexpr std::string_view to_string(Verdict verdict) {
  constexpr std::string_view names[] = {"regular", "overconstrained", "singular", "shaky"};
  return names[static_cast<int>(verdict)];
}

struct Mobility {
  int velocities = 0, closure_rows = 0;
  int grubler = 0;       // f^O − b^s, the Grübler-Kutzbach count Σ f_i − 6 n_L where loops are closed by joints
  int rank = 0;          // of G here
  int generic_rank = 0;  // of G on the branch: the largest that walks along the motion met
  int mobility = 0;      // f^O − rank, to first order, here
  int finite_mobility = 0;  // freedoms of real motions
  Verdict verdict = Verdict::regular;
  double sigma = 0, next_sigma = 0;         // σ_r and σ_{r+1} of the scaled G
  std::vector<int> redundant_rows;          // in the support of the left null space
  std::vector<int> removable_rows;          // one set of `redundant` rows without which the rest is independent
  std::vector<std::array<bool, 6>> unique;  // per tree joint: components of its wrench f̂, world axes
  std::vector<bool> unique_row;             // per closure row: its multiplier
  int walks = 0;                            // that moved
  double position_violation = 0;            // largest scaled |g| of the state

  int redundant() const { return closure_rows - rank; }
  // The same in absolute coordinates, six a body, with the conditions of all joints: those of the tree are independent.
  int absolute_coordinates = 0, absolute_rows = 0, absolute_rank = 0;
};

/// At an assembled state; what is redundant shows on the manifold only. A joint's reaction is unique where no wrench of
/// self-stress acts in it (the same as Wojtyra 2005, Multibody Syst. Dyn. 14, 23-46: rank without the joint's rows plus
/// rank of its rows equals the whole). O(rows · nv · min) and d²/2 evaluations for a mobility d. Throws InputError for
/// more than 2000 rows or velocities where loops are closed. Tested by tests/lib/mobility_test.cpp.
Mobility analyse_mobility(const Model& model, const State<double>& state);

}  // namespace lanc
