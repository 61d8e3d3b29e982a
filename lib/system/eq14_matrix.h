// Eq. 14 as a sparse matrix: pattern once per model, values refilled at every state.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "lib/system/system.h"

namespace lanc {

/// Order of the bodies in the matrix. Leaf to root is the order of eq. 18: eliminating in it makes no fill outside the
/// blocks of a body and its parent.
enum class BodyOrder : unsigned char { leaf_to_root, root_to_leaf };

/// The three unknowns of a body, and the three rows that the symmetric eq. 14 pairs with them:
/// â with (3), f̂ with (8), η̇ with (12). And λ of a closure row, with that row.
enum class Block : unsigned char { acceleration, wrench, velocity, closure };
using BlockOrder = std::array<Block, 3>;  // of a body: all but `closure`

/// Where things stand in the matrix. With the same order in rows and columns it is symmetric.
struct Eq14Layout {
  BodyOrder bodies = BodyOrder::leaf_to_root;
  BlockOrder rows = {Block::acceleration, Block::wrench, Block::velocity};
  BlockOrder columns = {Block::acceleration, Block::wrench, Block::velocity};
  bool upper_triangle = false;  // keep only what stands on and above the diagonal; rows and columns must agree
};

/// Where a block of a body begins among the rows (order: layout.rows) or the columns (layout.columns) of a model
/// without closures. O(1).
int position(const Model& model, const Eq14Layout& layout, const BlockOrder& order, int body, Block block);

/// Eq. 14 in compressed columns (starts, rows ascending in each column, values), structural zeros left out: a rigid M_i
/// has 24 entries, B_ip 12, a rotation or translation column 3, the armature 1; 66 per revolute body, 39 in one
/// triangle.
///
/// A closure row stands after the last body of its loop to be eliminated (leaf to root, the lowest common ancestor is
/// no part of the loop), a coupler's after the last body it couples: what is left then moves the loop as a rigid body.
/// Leaf to root, its pivot is −G M̄⁻¹ Gᵀ of the bodies eliminated, and differs from zero if their M̄ is regular. It has 6
/// entries a body and triangle, or 3 where it only turns; the diagonal entry is 0 while the row counts, and 1 (without
/// couplings, λ = 0) while it depends on others, so that the pattern is that of the model. Allocates in the constructor
/// only. S: double, long double, Count. Tested by
/// tests/formulations/sparse_test.cpp.
template <class S>
class Eq14Matrix {
 public:
  /// Builds the pattern and fills in the values of a regular sample (unit inertias, bodies in one place, joint axes
  /// along unit vectors), so that a solver can prepare itself before the first state. O(n) time; while it runs it takes
  /// another 4 bytes an entry. Throws InputError where objection() has one.
  explicit Eq14Matrix(const Model& model, const Eq14Layout& layout = {});

  /// Says so when the matrix has more entries than 32-bit indices can tell apart.
  static std::optional<std::string> objection(const Model& model);

  /// The values at another state: 42 for a revolute body. `independent` tells which closure rows count
  /// (ClosureDecision); empty: all. O(n).
  void refill(const System<S>& system, std::span<const char> independent = {});
  /// Right-hand side of eq. 14 in the order of the rows; zero for closure rows that do not count.
  void scatter(const RightHandSide<S>& rhs, std::vector<S>& b) const;
  /// Solution from its values in the order of the columns. Drive forces are not part of eq. 14.
  void gather(const std::vector<S>& x, Solution<S>& solution) const;

  int size() const { return static_cast<int>(starts_.size()) - 1; }
  int nonzeros() const { return starts_.back(); }
  const std::vector<int>& starts() const { return starts_; }
  const std::vector<int>& rows() const { return rows_; }
  const std::vector<S>& values() const { return values_; }
  const Eq14Layout& layout() const { return layout_; }

  /// First row and first column of a block of a body, or of a closure row for Block::closure.
  int row(int owner, Block block) const {
    return block == Block::closure ? closure_place_[owner] : places_[owner].row[static_cast<int>(block)];
  }
  int column(int owner, Block block) const {
    return block == Block::closure ? closure_place_[owner] : places_[owner].column[static_cast<int>(block)];
  }
  /// Whose column it is: the closure row, or −1; and the body (of a closure row, the body it stands behind).
  int closure_of_column(int column) const;
  int body_of_column(int column) const;

 private:
  int start(int body) const;
  void place_closures();
  void build();

  struct Places {
    std::array<int, 3> row, column;  // where the blocks begin
  };

  Model model_;
  Eq14Layout layout_;
  std::vector<Places> places_;  // by body
  std::vector<int> starts_, rows_;
  std::vector<S> values_;
  std::vector<int> closures_before_;  // per body: the closure rows that stand before it; empty without closures
  std::vector<int> closure_place_;    // of every closure row
  std::vector<char> counts_;          // per closure row, at the last refill
  std::vector<int> slots_;            // where the entries that vary go, in the order in which refill() meets them
};

extern template class Eq14Matrix<double>;
extern template class Eq14Matrix<long double>;
extern template class Eq14Matrix<Count>;

}  // namespace lanc
