// Eq. 18 with closures: right-hand sides through LoopFactors.
#pragma once

#include "formulations/recursive-loops/loop_factors.h"

namespace lanc {

/// The load half of the elimination and the way back. With γ what is known of the closures' accelerations and f* of the
/// bodies' loads, a body hands on
///
///   t = τ + Cᵀ f*,  f*_p += B_ipᵀ (f* − U N⁻¹ t),  γ += uᵀ N⁻¹ t,       later η̇ = N⁻¹ (t − Uᵀ B_ip â_p + u λ)
///
/// and a closure, with g = D⁻¹ W γ_c,
///
///   f*_p −= Eᵀ g,  γ_d −= T_dᵀ g,       later λ_c = −Wᵀ (g + D⁻¹ (E â_p + Σ T_d λ_d))
///
/// Where loops are closed, one step of refinement follows, since closures in series lose digits: the same once more for
/// the residual of eq. 14 at η̇, λ, the â that follow by (8), and f̂ = 0, which is f̂^tc − M â + G_sᵀ λ of the bodies,
/// τ − A η̇ + G_ηᵀ λ of the joints and G_s â + G_η η̇ + γ̿ of the closures. It returns corrections, and f̂ itself.
/// ā^rel is taken off f* where it arises, as in `recursive`.
template <class S, int width>
class LoopSubstitution {
 public:
  using Rows = Strip<S, width>;

  explicit LoopSubstitution(const Model& model);

  /// λ of dropped rows is zero, their conditions are not looked at.
  void solve(const LoopFactors<S, width>& factors, const System<S>& system, const RightHandSide<S>& rhs,
             Solution<S>& solution);

 private:
  enum class Pass : unsigned char { only, first, correction };
  struct Task;  // what the steps of one solve share

  // One copy of each sweep for all passes, with what it does to a body of one freedom inside: about 3 % of all that a
  // single four-bar takes.
  [[gnu::noinline]] void forward(const Task& task, Pass pass);
  [[gnu::noinline]] void backward(const Task& task, Pass pass);
  void residual_of_closures(const Task& task);
  /// `freedoms`: as in LoopFactors.
  template <int freedoms>
  [[gnu::always_inline]] inline void forward_body(const Task& task, const BodyStep& step, Pass pass);
  template <int freedoms>
  [[gnu::always_inline]] inline void backward_body(const Task& task, const BodyStep& step, Pass pass,
                                                   const Motion<S>* a);
  [[gnu::noinline]] void forward_joint(const Task& task, const BodyStep& step, Pass pass);
  [[gnu::noinline]] void backward_joint(const Task& task, const BodyStep& step, Pass pass, const Motion<S>* a);
  [[gnu::noinline]] void forward_closure(const LoopFactors<S, width>& factors, const ClosureStep& step);
  [[gnu::always_inline]] inline void backward_closure(const LoopFactors<S, width>& factors, const ClosureStep& step,
                                                      const Motion<S>* a);

  std::vector<Wrench<S>> load_;   // f*, then f* − M* ā^rel
  std::vector<S> start_;          // t / N
  std::vector<Rows> gamma_;       // γ, then g
  std::vector<Rows> lambda_;      // of the present pass
  std::vector<Motion<S>> delta_;  // corrections of â
};

extern template class LoopSubstitution<double, 1>;
extern template class LoopSubstitution<double, 3>;
extern template class LoopSubstitution<double, 6>;
extern template class LoopSubstitution<long double, 1>;
extern template class LoopSubstitution<Count, 1>;

}  // namespace lanc
