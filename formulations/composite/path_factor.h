// LᵀDL of a matrix with the sparsity of a tree: M̄ of velocity coordinates.
#pragma once

#include <algorithm>
#include <vector>

#include "lib/model/paths.h"
#include "lib/spatial/block.h"

namespace lanc {

/// Symmetric H, where H_kl ≠ 0 only if l lies on the path of k or k on that of l, factored from the leaves to the root:
/// H = LᵀDL, where L has the entries of H and no others (Featherstone 2005). Rows are kept as D L, in a preorder of the
/// coordinates and in whole blocks of SIMD lanes. O(n d²) for depth d, solve O(n d). Pivots may have either sign.
/// Tested by tests/formulations/path_factor_test.cpp.
template <class S>
class PathFactor {
 public:
  explicit PathFactor(const Model& model);

  int depth(int k) const { return depth_[place_[k]]; }
  /// Row k of H for the caller to write before each factorise(), from the root to k itself: depth(k) entries.
  S* begin_row(int k) { return row(place_[k]); }
  void factorise();
  /// x becomes H⁻¹ x.
  void solve(std::vector<S>& x);

 private:
  static constexpr int lanes = PackedScalar<S>::lanes;
  S* row(int place) { return reinterpret_cast<S*>(rows_.data() + start_[place]); }
  void hand_up(int p, const S& scaled, bool neighbour_knows);
  static S inner_product(const S* a, const S* b, int n);

  // By place in the preorder; a coordinate is followed by all it carries.
  std::vector<int> coordinate_, place_, depth_, carried_;  // place_ is by coordinate
  std::vector<std::size_t> start_;                         // of a row, in blocks
  std::vector<Packed<S>> rows_;
  std::vector<S> inverse_;  // of D
  std::vector<S> factors_;  // of the coordinates below the present one
  // By depth, along the path of the present coordinate: Lᵀ y of those below, zero when all is done; and the solution.
  std::vector<S> from_below_, on_path_;
};

template <class S>
PathFactor<S>::PathFactor(const Model& model) : place_(model.nv()), inverse_(model.nv()), factors_(model.nv()) {
  const VelocityPaths paths(model);
  coordinate_ = paths.preorder();
  carried_.assign(model.nv(), 0);
  std::size_t blocks = 0;
  int deepest = 0;
  for (int p = 0; p < model.nv(); ++p) {
    place_[coordinate_[p]] = p;
    depth_.push_back(paths.depth(coordinate_[p]));
    deepest = std::max(deepest, depth_.back());
    start_.push_back(blocks);
    blocks += blocks_of<S>(depth_.back());
  }
  for (int p = model.nv() - 1; p >= 0; --p)
    if (const int before = paths.before(coordinate_[p]); before >= 0) carried_[place_[before]] += 1 + carried_[p];
  rows_.assign(blocks, Packed<S>(0.0));
  for (std::vector<S>* array : {&from_below_, &on_path_})
    array->assign(static_cast<std::size_t>(lanes) * blocks_of<S>(deepest), S(0.0));
}

/// Row by row: what all coordinates below have to give, D_q L_qd L_q, kept in registers meanwhile. The pivot is
/// computed apart and first: each waits for the one before, and would wait for the way through memory, too.
template <class S>
void PathFactor<S>::factorise() {
  S* const factors = factors_.data();
  for (int p = static_cast<int>(depth_.size()) - 1; p >= 0; --p) {
    S* const H = row(p);
    const int own = depth_[p] - 1, below = carried_[p];
    S pivot = H[own];
    for (int q = below - 1; q >= 0; --q) {
      const S l = row(p + 1 + q)[own];
      factors[q] = l * inverse_[p + 1 + q];
      pivot -= l * factors[q];
    }
    inverse_[p] = S(1.0) / pivot;
    const auto given = [&](int q, int e) { return load_block<S>(row(p + 1 + q) + e) * Packed<S>(factors[q]); };
    for (int e = 0; e < own; e += lanes) {
      Packed<S> sum = load_block<S>(H + e);
      int q = below - 1;
      if constexpr (lanes > 1) {  // in two sums, since one would wait for each addition
        Packed<S> other(0.0);
        for (; q > 0; q -= 2) other -= given(q, e), sum -= given(q - 1, e);
        sum += other;
      }
      for (; q >= 0; --q) sum -= given(q, e);
      if constexpr (lanes > 1) sum = first_lanes(sum, own - e);  // rows end in zeros
      store_block<S>(sum, H + e);
    }
  }
}

/// Each coordinate waits for its neighbour on the path alone, number by number; what is further away comes in blocks,
/// one coordinate late. With the pivots apart this spares `composite` 8 % of its time on a chain of six.
template <class S>
void PathFactor<S>::solve(std::vector<S>& x) {
  S* const on_path = on_path_.data();
  const int n = static_cast<int>(depth_.size());
  S scaled(0.0);                      // D⁻¹ y of the coordinate before
  for (int p = n - 1; p >= 0; --p) {  // Lᵀ y = x
    const int own = depth_[p] - 1;
    const bool carries = carried_[p] > 0;  // the one before, among others
    S& y = x[coordinate_[p]];
    if (carries) y = y - from_below_[own] - row(p + 1)[own] * scaled;
    if (p + 1 < n) hand_up(p + 1, scaled, carries);
    scaled = y * inverse_[p];
  }
  if (n > 0) hand_up(0, scaled, false);
  for (int p = 0; p < n; ++p) {  // L z = D⁻¹ y
    const S* const L = row(p);
    const int own = depth_[p] - 1;
    S& z = x[coordinate_[p]];
    if (own > 0) {
      z -= inner_product(L, on_path, own - 1);
      z -= L[own - 1] * (carried_[p - 1] > 0 ? x[coordinate_[p - 1]] : on_path[own - 1]);
    }
    z = on_path[own] = z * inverse_[p];
  }
}

/// Adds L_p y_p / D_p to what waits for the coordinates above p, but for its neighbour if that knows already. Nothing
/// is left there of p and those below it.
template <class S>
void PathFactor<S>::hand_up(int p, const S& scaled, bool neighbour_knows) {
  S* const from_below = from_below_.data();
  const S* const L = row(p);
  const int own = depth_[p] - 1;
  int e = 0;
  if constexpr (lanes > 1) {
    const Packed<S> factor(scaled);
    for (; e + lanes <= own; e += lanes)
      store_block<S>(load_block<S>(from_below + e) + load_block<S>(L + e) * factor, from_below + e);
    store_block<S>(first_lanes(load_block<S>(from_below + e) + load_block<S>(L + e) * factor, own - e), from_below + e);
  } else {
    for (; e < own - (neighbour_knows ? 1 : 0); ++e) from_below[e] += L[e] * scaled;
    from_below[own] = S(0.0);
  }
}

/// Σ a_e b_e. The last entries one by one and in two sums: what has just been written number by number is late for a
/// block, and one sum would wait for each addition.
template <class S>
S PathFactor<S>::inner_product(const S* a, const S* b, int n) {
  S even(0.0), odd(0.0);
  int e = 0;
  if constexpr (lanes > 1) {
    Packed<S> sums(0.0);
    for (; e + 2 * lanes < n; e += lanes) sums += load_block<S>(a + e) * load_block<S>(b + e);
    if (e > 0)
      for (int lane = 0; lane < lanes; ++lane) even += sums[lane];
  }
  for (; e + 1 < n; e += 2) even += a[e] * b[e], odd += a[e + 1] * b[e + 1];
  if (e < n) even += a[e] * b[e];
  return even + odd;
}

}  // namespace lanc
