// A formulation is one way to solve eq. 14. It gets the coefficients and returns η̇, â, f̂, λ; nothing else.
//
// A new one is a folder in formulations/ (or a file of your own program) that derives from Formulation<S>, and a
// Registration. Everything else (tests, experiments, command line) finds it in formulations().
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "lib/closure/rank.h"
#include "lib/formulation/outcome.h"
#include "lib/system/system.h"

namespace lanc {

/// What a library reports of its part of the last solve; formulations whose arithmetic is ours are counted on Count
/// instead. NaN where the library has no counter.
struct LibraryStatistics {
  std::int64_t unknowns = 0, matrix_nonzeros = 0;
  std::int64_t factor_nonzeros = 0;  // fill-in is what it exceeds matrix_nonzeros by
  std::int64_t bytes = 0;            // held by the library
  double factorise_flops = std::numeric_limits<double>::quiet_NaN();
  double solve_flops = std::numeric_limits<double>::quiet_NaN();
};

/// Solves eq. 14 on the scalar S. The object is its own workspace: it allocates when it is bound to a model, not in the
/// phases (a formulation that must says so in its README). One object per thread.
template <class S>
class Formulation {
 public:
  explicit Formulation(const Model& model);
  virtual ~Formulation();

  /// What comes first where loops are closed: which closure conditions hold, lib/closure/rank.h. The phases use it.
  void decide(const System<S>& system, RankPolicy policy = {});

  /// The three phases of a solve, to be called in this order. They exist apart so that each can be counted and timed
  /// from outside; substitute() may be called again with another right-hand side of the same coefficients. assemble:
  /// coefficients into the formulation's own matrices, if it has any.
  virtual void assemble(const System<S>& system) = 0;
  /// factorise: everything that does not depend on the right-hand side. A matrix the formulation can recognise as
  /// unusable is told here; the phases after it are then skipped.
  virtual Outcome factorise(const System<S>& system) = 0;
  /// substitute: η̇, â, f̂ and λ for one right-hand side. Where conditions are redundant, λ of the dependent rows may be
  /// left zero, and the conditions of these rows be ignored: solve() makes them consistent, and takes care of the norm.
  virtual void substitute(const System<S>& system, const RightHandSide<S>& rhs, Solution<S>& solution) = 0;

  /// All phases, the drive forces, and the judgement of the answer:
  ///   not_finite  the coefficients themselves are not finite, or overflow
  ///   inconsistent  the state violates the closure conditions, or they contradict one another (a driven loop that
  ///   cannot
  ///               follow): the answer is that of least squares in the scaled rows
  ///   objection   it is singular to this formulation only: M̄ is regular but, by an inertia that no body can have, not
  ///               positive definite (looked at up to 3000 velocities, O(n³))
  ///   singular    the answer is not finite, or does not stand the following test; or the rank of the closure
  ///   conditions
  ///               is larger in neighbouring states: what the conditions at this very state leave is returned
  ///   redundant   the right answer, in spite of redundant conditions, and λ of minimum norm in the scaled rows
  /// Where loops are closed, or a body's inertia is far below the largest (Model::has_singular_inertia), or eq. 12 is
  /// violated by more than rounding explains, up to three refinement steps must bring the correction below 1e-8 of the
  /// answer, and a known answer must come back. The size of the last correction is returned as forward_error. Allocates
  /// only where it finds eq. 12 violated in a model that gave no reason to expect it.
  Outcome solve(const System<S>& system, Solution<S>& solution, RankPolicy policy = {});

  /// For what is linear in eq. 14 beside its solution (projections, derivatives): decision, matrices and factors at a
  /// state, without an answer; then the answers to any right-hand sides there. Of redundant conditions that contradict
  /// one another the least-squares part of `rhs` is used, and left in it. λ has minimum norm, drive forces are not set.
  Outcome prepare(const System<S>& system, RankPolicy policy = {});
  void respond(const System<S>& system, RightHandSide<S>& rhs, Solution<S>& solution);

  /// One step of iterative refinement with the residual of eq. 14, using the present factors. Returns the size of the
  /// correction relative to the answer, of accelerations or wrenches the larger. Restores the accuracy long chains
  /// lose; never changes a right answer.
  double refine(const System<S>& system, Solution<S>& solution);

  /// Fill-in, memory and flops where a library does the work; nothing where this project does. May take O(factors).
  virtual std::optional<LibraryStatistics> statistics() const { return std::nullopt; }

  /// Closure rows the last factorise() dropped because its own pivots found them dependent; −1 where it takes the
  /// independent rows it is told. Asked where RankPolicy::by_pivots holds a rank: with as many rows dropped as it
  /// leaves, no singular values are needed; with another number they decide, and factorise() comes once more.
  virtual int dropped_rows() const { return -1; }

 protected:
  const Model& model() const { return model_; }
  /// Which closure conditions hold at the state of the present solve.
  const ClosureDecision& closures() const { return rank_->decision(); }

 private:
  struct Refinement;
  /// Decision, matrices and factors.
  Outcome factorised(const System<S>& system, RankPolicy policy);
  /// The right-hand side with consistent closure conditions.
  const RightHandSide<S>& consistent(const System<S>& system);
  /// λ of minimum norm, and the wrenches that go with it.
  void settle_reactions(const System<S>& system, const RightHandSide<S>& rhs, Solution<S>& solution);
  void judge_closures(Outcome& outcome) const;
  double open_closures(const System<S>& system, const Solution<S>& solution);
  Outcome verified(const System<S>& system, Solution<S>& solution);
  /// Relative error with which the present factors bring back an answer that is known.
  double probe_error(const System<S>& system);

  Model model_;
  std::unique_ptr<ClosureRank<S>> rank_;  // where loops are closed
  RightHandSide<S> consistent_;
  std::unique_ptr<Refinement> refinement_;  // at once for models that need it in solve(), else at the first refine()
};

extern template class Formulation<double>;
extern template class Formulation<long double>;
extern template class Formulation<Count>;

/// Makes a formulation bound to a model; null where it is not offered for the scalar.
template <class S>
using Factory = std::unique_ptr<Formulation<S>> (*)(const Model&);

/// Solves several states at once (lib/formulation/batch.h).
class BatchKernel;

/// The same formulation with other settings, for experiments that compare settings.
struct Variant {
  std::string_view parameters;  // key=value;key=value, as in the column `parameters` of CSV files
  Factory<double> create = nullptr;
};

/// What the register knows of a formulation.
struct FormulationInfo {
  std::string_view name;    // as on the command line and in CSV files
  std::string_view idea;    // one sentence
  std::string_view source;  // where it comes from
  bool recursive = false;   // of the recursive family; the crossover compares these with all others
  /// Why it cannot take a model, or nothing. Asked before anything is allocated.
  std::optional<std::string> (*objection)(const Model&) = [](const Model&) { return std::optional<std::string>(); };
  Factory<double> create_double = nullptr;
  Factory<long double> create_long_double = nullptr;
  Factory<Count> create_count = nullptr;
  std::unique_ptr<BatchKernel> (*create_kernel)(const Model&) = nullptr;  // many states at once, on packs
  std::span<const Variant> variants = {};  // the standard settings first; empty when there are no others

  template <class S>
  Factory<S> factory() const {
    if constexpr (std::is_same_v<S, double>)
      return create_double;
    else if constexpr (std::is_same_v<S, long double>)
      return create_long_double;
    else
      return create_count;
  }
};

/// A factory for `Kind<S>`, to be put into FormulationInfo.
template <class Concrete, class S>
std::unique_ptr<Formulation<S>> create(const Model& model) {
  return std::make_unique<Concrete>(model);
}

/// All registered formulations, sorted by name. Call after main() has begun.
std::span<const FormulationInfo> formulations();
/// Null when there is none of that name.
const FormulationInfo* find_formulation(std::string_view name);
/// What programs take when none is named: the first of the recursive family. Null when none is registered.
const FormulationInfo* default_formulation();

/// A namespace-scope object of this type puts a formulation into the register.
struct Registration {
  explicit Registration(const FormulationInfo& info);
};

}  // namespace lanc
