// Eq. 18 with closures: the inertia half of the block elimination of eq. 14 on the graph of bodies and closures.
#pragma once

#include <span>

#include "formulations/recursive-loops/elimination_plan.h"
#include "lib/system/system.h"

namespace lanc {

/// Calls f with the number of rows of all closures as a constant where it is a frequent one, else with 0: loops over
/// the rows are then unrolled, which makes of a ladder's factors a third of the time.
template <class F>
inline auto with_rows(int rows_each, F&& f) {
  switch (rows_each) {
    case 3: return f(std::integral_constant<int, 3>());
    case 6: return f(std::integral_constant<int, 6>());
    default: return f(std::integral_constant<int, 0>());
  }
}

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
template <class S>
class LoopFactors {
 public:
  LoopFactors(const Model& model, EliminationPlan plan);

  /// Of all rows, vanishing ones being dropped, or, where `counts` has an entry per row, of those that count. False
  /// when there is a pivot nobody can divide by.
  bool factorise(const System<S>& system, std::span<const char> counts = {});

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
  const Wrench<S>* columns(int at) const { return columns_.data() + at; }  // e; of an eliminated closure E
  const S* responses(const BodyStep& step, int freedom) const {            // u / N
    return responses_.data() + step.responses + freedom * step.columns;
  }
  const S* block(int at) const { return delassus_.data() + at; }  // T of eliminated closures
  const S* weights(const ClosureStep& step) const { return weights_.data() + step.weights; }  // W
  const S* inverse(const ClosureStep& step) const { return inverse_.data() + step.row; }      // D⁻¹

 private:
  void start(const System<S>& system);
  template <int fixed>
  bool eliminate(const System<S>& system, std::span<const char> counts);
  void eliminate_body(const System<S>& system, const BodyStep& step);
  template <int fixed>
  void eliminate_columns(const System<S>& system, const BodyStep& step);
  template <int fixed>
  void release_columns(const System<S>& system, const BodyStep& step);
  template <int fixed>
  void release_hinge(const System<S>& system, const BodyStep& step);
  template <int fixed>
  bool find_pivots(const ClosureStep& step, std::span<const char> counts);
  template <int fixed>
  void eliminate_closure(const ClosureStep& step);
  template <int fixed>
  void hand_to_body(const ClosureStep& step);

  Model model_;
  EliminationPlan plan_;
  std::vector<double> free_;                 // per row: about S_rr, were the bodies it acts on free
  std::vector<ArticulatedInertia<S>> star_;  // M*
  std::vector<Freedom> freedoms_;
  std::vector<ColumnKind> kinds_;
  std::vector<Wrench<S>> columns_;
  std::vector<S> responses_, scratch_;
  std::vector<S> delassus_;
  std::vector<S> weights_, inverse_;
  std::vector<S> taken_;  // what eliminated closures took off S_rr
  int dropped_ = 0;
};

extern template class LoopFactors<double>;
extern template class LoopFactors<long double>;
extern template class LoopFactors<Count>;

}  // namespace lanc
