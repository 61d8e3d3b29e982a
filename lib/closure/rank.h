// How many closure conditions there are, really: the one place where the rank of G is decided.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "lib/model/model.h"
#include "lib/system/system.h"

namespace lanc {

/// Singular values of the scaled G (lib/closure/scaling.h), relative to the larger of σ_1 and 1. Assembled states are
/// good to 1e-12 and rounding adds 1e-15, so a dependent row shows below 1e-10. Between the two numbers a state is so
/// near a singular one that neither rank gives a right answer: errors grow like ε/σ².
constexpr double zero_singular_value = 1e-10;
constexpr double clear_singular_value = 1e-7;
/// For motions that pass through singular configurations (RankPolicy::smallest): answers are as good as ε/σ², and what
/// is left free for a moment is free for some microseconds of a motion of some 1/s.
constexpr double passing_singular_value = 3e-6;
/// How far a state may violate g = 0 and Gη + γ̄ = 0 (scaled) before it is called inconsistent; redundancy shows on the
/// manifold only.
constexpr double largest_violation = 1e-6;
/// The part of γ̿ that no η̇ can balance, relative to what γ̿ is made of, from which conditions contradict one another.
constexpr double largest_contradiction = 1e-7;

/// Who decides the rank: the singular values of every state, or the caller, once, for states off the manifold as well
/// (inside a Runge-Kutta stage). A given rank switches off the checks of the state, too; redundant conditions may then
/// contradict one another as far as the state violates them.
struct RankPolicy {
  int rank = -1;        // −1: automatic
  double smallest = 0;  // singular values below (relative to the larger of σ_1 and 1) count as zero, for motions
                        // through singular configurations; 0: such a state is reported as near_singular
  /// With a given rank: a formulation that drops dependent rows by pivots of its own need not wait for singular values,
  /// where it drops as many (Formulation::dropped_rows). σ is not known then, and λ is of its choice.
  bool by_pivots = false;

  bool automatic() const { return rank < 0; }
};

/// Which closure conditions hold, at one state.
struct ClosureDecision {
  int rank = 0, redundant = 0;
  double sigma = 0, next_sigma = 0;  // σ_r and σ_{r+1} of the scaled G
  bool near_singular = false;        // the gap between them is not clear
  bool varying_rank = false;         // the rank is larger in some neighbouring state: a singular configuration
  double position_violation = 0, velocity_violation = 0;  // largest |g| and |Gη + γ̄|, scaled
  double contradiction = 0;                               // relative, see largest_contradiction
  double tolerated_contradiction = largest_contradiction;
  bool held = false;               // the rank was given
  bool dropped = false;            // and is lower here: weak conditions count as none
  bool by_pivots = false;          // and nobody looked at singular values: σ is NaN, `independent` all rows
  int worst_row = -1;              // that violates or contradicts most
  std::vector<char> independent;   // per row: one of a well-conditioned set of `rank` rows
  std::vector<double> correction;  // to be added to γ̿, which makes the conditions consistent (least squares)
};

/// Bound to a model. Rows that share no velocity are decided apart (lib/closure/row_space.h): cubic in the rows of
/// loops that hang together while they are few, sparse beyond. Tested by tests/lib/closure_test.cpp.
template <class S>
class ClosureRank {
 public:
  explicit ClosureRank(const Model& model);
  ~ClosureRank();

  const ClosureDecision& decide(const System<S>& system, RankPolicy policy = {});
  /// The given rank as it is, with what the state violates: linear in the rows. No make_consistent() or minimum_norm()
  /// after it.
  const ClosureDecision& hold(const System<S>& system, RankPolicy policy);
  const ClosureDecision& decision() const;
  /// Takes away the part of one number a row that no velocities can bring about (least squares).
  void make_consistent(std::vector<S>& rows) const;
  /// Replaces λ by the one of minimum norm in the scaled rows that does the same to the bodies.
  void minimum_norm(std::vector<S>& lambda) const;
  /// The largest of some value per row, scaled.
  double largest(const std::vector<S>& rows) const;

 private:
  void remove_outside(std::vector<S>& rows, const std::vector<double>& unit) const;
  struct Work;
  std::unique_ptr<Work> work_;
};

extern template class ClosureRank<double>;
extern template class ClosureRank<long double>;
extern template class ClosureRank<Count>;

}  // namespace lanc
