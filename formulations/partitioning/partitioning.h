#pragma once

#include "lib/closure/explicit.h"
#include "lib/formulation/reduced_formulation.h"
#include "lib/solve/dense_algebra.h"

namespace lanc {

/// The lecture's explicit closure conditions: velocities split into independent ones s and dependent ones,
/// η̇ = J* ṡ + η̿ with J* = [1; −(G^d)⁻¹ Gⁱ], and J*ᵀ M̄ J* ṡ = J*ᵀ (b − M̄ η̿). The choice of s is made by
/// ExplicitClosures (in double), kept from call to call while it is good, and every change is logged. The one
/// formulation with a memory: of the choice, on which answers depend by rounding errors only.
template <class S>
class Partitioning final : public ReducedFormulation<S> {
 public:
  explicit Partitioning(const Model& model, ExplicitOptions options = {});

  /// The velocities that are s, ascending, and σ_max / σ_min of their G^d. Of the last solve where conditions hold.
  const std::vector<int>& independent() const { return independent_; }
  double condition() const { return choice_.condition(); }
  /// Every change of s, oldest first.
  const std::vector<IndependentChange>& changes() const { return choice_.changes(); }
  /// The user's s, kept while its condition allows.
  void choose(std::vector<int> independent) { choice_.choose(std::move(independent)); }
  /// As when it was made: no choice, no log.
  void reset() { choice_ = ExplicitClosures(this->model(), options_); }

 private:
  using typename ReducedFormulation<S>::Matrix;
  using typename ReducedFormulation<S>::Vector;

  Outcome factorise_closed(const System<S>& system) override;
  void substitute_closed(const Vector& b, const Vector& gamma, Vector& vdot, Vector& lambda) override;

  ExplicitOptions options_;
  ExplicitClosures choice_;
  std::vector<int> independent_, dependent_;
  Lu<S> Gd_;
  Matrix J_;              // J*
  Cholesky<S> cholesky_;  // of J*ᵀM̄J*
};

extern template class Partitioning<double>;
extern template class Partitioning<long double>;
extern template class Partitioning<Count>;

}  // namespace lanc
