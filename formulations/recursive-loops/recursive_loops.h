// Eq. 18 with closures: block elimination of eq. 14 on the graph of bodies and closures.
#pragma once

#include <span>

#include "formulations/recursive-loops/elimination_plan.h"
#include "lib/formulation/formulation.h"

namespace lanc {

/// Eliminates eq. 14 with its border (theory, section 4) in the order of an EliminationPlan.
///
/// A body i goes as in eq. 18, its joint's freedoms released column by column, and takes along the columns e of unit
/// multipliers of the closures it meets: with U = M* C, N = Cᵀ U + A, u = Cᵀ e + G_η,
///
///   M*_p += B_ipᵀ (M* − U N⁻¹ Uᵀ) B_ip,  e_p += B_ipᵀ (e − U N⁻¹ u),  S += u N⁻¹ uᵀ
///
/// S being what multipliers do to closure accelerations by way of what is eliminated (Delassus matrix). A closure goes
/// row by row, the row r with the largest pivot first: what is left of S_rr, with s its row of S and e_r its column on
/// the one body left,
///
///   M*_p += e_r S_rr⁻¹ e_rᵀ,  e_p −= e_r S_rr⁻¹ sᵀ,  S −= s S_rr⁻¹ sᵀ
///
/// and is dropped, λ_r = 0, when nothing is left of its pivot. Loads go the same way; one step of refinement with the
/// residual of eq. 14 follows. Without closures it is eq. 18. O(plan), no allocation after the constructor.
/// Tested by tests/formulations/recursive_loops_test.cpp.
template <class S>
class RecursiveLoops final : public Formulation<S> {
 public:
  explicit RecursiveLoops(const Model& model);
  void assemble(const System<S>&) override {}
  Outcome factorise(const System<S>& system) override;
  void substitute(const System<S>& system, const RightHandSide<S>& rhs, Solution<S>& solution) override;

  const EliminationPlan& plan() const { return plan_; }
  /// Rows dropped by the last factorisation.
  int dropped() const { return dropped_; }

 private:
  struct Freedom {
    Wrench<S> D;  // M* C / N
    S inverse;    // 1 / N
    S start;      // N⁻¹ times its load
  };
  enum class Pass : unsigned char { first, correction };

  /// Of all rows, with vanishing ones dropped, or of those that count. False when a pivot is no pivot.
  bool eliminate(const System<S>& system, std::span<const char> counts);
  void eliminate_body(const System<S>& system, const BodyStep& step);
  bool eliminate_closure(const ClosureStep& step, std::span<const char> counts);
  void release_row(const ClosureStep& step, int done, int left);

  void residual(const System<S>& system, const RightHandSide<S>& rhs, const Solution<S>& solution);
  template <Pass pass>
  void forward_body(const System<S>& system, const RightHandSide<S>& rhs, const Solution<S>& solution,
                    const BodyStep& step);
  void forward_closure(const ClosureStep& step);
  template <Pass pass>
  void backward_body(const System<S>& system, const RightHandSide<S>& rhs, Solution<S>& solution, const BodyStep& step);
  template <Pass pass>
  void backward_closure(const Solution<S>& solution, const ClosureStep& step);
  template <Pass pass>
  void sweep(const System<S>& system, const RightHandSide<S>& rhs, Solution<S>& solution);

  EliminationPlan plan_;
  std::vector<double> free_;                 // per row: about S_rr, were the bodies it acts on free
  std::vector<ArticulatedInertia<S>> star_;  // M*
  std::vector<Wrench<S>> columns_;           // e of all bodies
  std::vector<Freedom> freedoms_;
  std::vector<S> responses_;  // u / N
  std::vector<S> panel_;      // S, row r of a closure becoming s / S_rr
  std::vector<S> inverse_;    // 1 / S_rr per row
  std::vector<S> taken_;      // what eliminated closures took off S_rr
  std::vector<int> pivots_;   // rows of a closure in the order of elimination, from its first row on
  std::vector<int> kept_;     // per closure step, how many were not dropped
  int dropped_ = 0;
  std::vector<S> scratch_;
  std::vector<Wrench<S>> load_;   // f*, then f* − M* ā^rel
  std::vector<S> gamma_;          // closure accelerations, then times S_rr⁻¹
  std::vector<S> lambda_;         // of the present pass
  std::vector<Motion<S>> delta_;  // corrections of â
};

extern template class RecursiveLoops<double>;
extern template class RecursiveLoops<long double>;
extern template class RecursiveLoops<Count>;

}  // namespace lanc
