// Eq. 18 with closures: the inertia half of the block elimination of eq. 14 on the graph of bodies and closures.
#pragma once

#include <span>

#include "formulations/recursive-loops/elimination_plan.h"
#include "formulations/recursive-loops/strip.h"
#include "lib/system/system.h"

namespace lanc {

/// The factors of eq. 14 with its border (theory, section 4), in the order of an EliminationPlan.
///
/// A body i goes as in eq. 18, its joint's freedoms released column by column, and takes along the columns e of unit
/// multipliers of the closures it meets: with U = M* C, N = Cᵀ U + A, u = Cᵀ e + G_η,
///
///   M*_p += B_ipᵀ (M* − U N⁻¹ Uᵀ) B_ip,  e_p += B_ipᵀ (e − U N⁻¹ u),  S += uᵀ N⁻¹ u
///
/// S being what multipliers do to closure accelerations by way of what is eliminated (Delassus matrix). A closure c
/// goes with W, D of its own block, W S_cc Wᵀ = D diagonal, the largest pivot first, and D⁻¹ being zero where nothing
/// is left of a pivot: that row is dropped. With T_d = W S_cd for the closures d it meets and E = W e on the one body
/// left,
///
///   M*_p += Eᵀ D⁻¹ E,  e_pd −= Eᵀ D⁻¹ T_d,  S_dd' −= T_dᵀ D⁻¹ T_d'
///
/// O(plan), no allocation after the constructor. Source of the pivoting: Higham, Accuracy and Stability of Numerical
/// Algorithms, section 10.3. Tested by tests/formulations/recursive_loops_test.cpp.
template <class S, int width>
class LoopFactors {
 public:
  using Rows = Strip<S, width>;

  LoopFactors(const Model& model, EliminationPlan plan);

  /// Of all rows, vanishing ones being dropped, or, where `counts` has an entry per row, of those that count. False
  /// when there is a pivot nobody can divide by.
  bool factorise(const System<S>& system, std::span<const char> counts);

  struct Freedom {
    Wrench<S> D;  // M* C / N
    S inverse;    // 1 / N
  };
  const Model& model() const { return model_; }
  const EliminationPlan& plan() const { return plan_; }
  /// Rows without a multiplier in the last factorisation.
  int dropped() const { return dropped_; }
  ColumnKind kind(int k) const { return kinds_[k]; }
  const ArticulatedInertia<S>& star(int body) const { return star_[body]; }
  const Freedom& freedom(int k) const { return freedoms_[k]; }
  const Wrench<Rows>* columns(int at) const { return columns_.data() + at; }  // e; of an eliminated closure E
  const Rows* responses(const BodyStep& step, int freedom) const {            // u / N
    return responses_.data() + step.responses + freedom * step.columns;
  }
  const Rows* block(int at) const { return delassus_.data() + at; }                              // T, row by row
  const Rows* weights(const ClosureStep& step) const { return weights_.data() + step.weights; }  // W, row by row
  const Rows* weight_columns(const ClosureStep& step) const { return weight_columns_.data() + step.weights; }
  const Rows* inverse(const ClosureStep& step) const { return inverse_.data() + step.strip; }  // D⁻¹
  /// The rows of G_a and G_b of a strip.
  const Wrench<Rows>& row_a(int strip) const { return rows_[2 * strip]; }
  const Wrench<Rows>& row_b(int strip) const { return rows_[2 * strip + 1]; }

 private:
  void start(const System<S>& system);
  [[gnu::flatten]] bool eliminate(const System<S>& system, std::span<const char> counts);
  /// `freedoms` of the joint: one, of which no loop is made, or `any`, out of line: a fiftieth of the factors of one
  /// loop.
  template <int freedoms>
  void eliminate_body(const System<S>& system, const BodyStep& step);
  [[gnu::noinline, gnu::flatten]] void eliminate_joint(const System<S>& system, const BodyStep& step);
  template <int freedoms>
  void meet(const BodyStep& step);
  [[gnu::noinline]] void release_columns(const System<S>& system, const BodyStep& step);
  void release_hinge(const System<S>& system, const BodyStep& step);
  void hand_on(const Attachment& to, int strip, const Wrench<Rows>& e);
  bool find_pivots(const ClosureStep& step, std::span<const char> counts);
  void eliminate_closure(const ClosureStep& step);
  void hand_to_body(const ClosureStep& step);

  Model model_;
  EliminationPlan plan_;
  std::vector<double> free_;                 // per row: about S_rr, were the bodies it acts on free
  std::vector<ArticulatedInertia<S>> star_;  // M*
  std::vector<Freedom> freedoms_;
  std::vector<ColumnKind> kinds_;
  std::vector<Wrench<Rows>> rows_;  // of G_a and G_b, by turns
  std::vector<Wrench<Rows>> columns_;
  std::vector<Rows> responses_, scratch_;
  std::vector<Rows> delassus_;
  std::vector<Rows> weights_, weight_columns_, inverse_;
  std::vector<Rows> taken_;  // what eliminated closures took off S_rr
  int dropped_ = 0;
};

extern template class LoopFactors<double, 1>;
extern template class LoopFactors<double, 3>;
extern template class LoopFactors<double, 6>;
extern template class LoopFactors<long double, 1>;
extern template class LoopFactors<Count, 1>;

}  // namespace lanc
