// Factors and substitution of one plan, whatever the width of its strips.
// Private to formulations/recursive-loops.
#pragma once

#include <memory>

#include "formulations/recursive-loops/loop_substitution.h"

namespace lanc {

template <class S>
class LoopElimination {
 public:
  virtual ~LoopElimination() = default;
  /// LoopFactors::factorise().
  virtual bool factorise(const System<S>& system, std::span<const char> counts = {}) = 0;
  virtual int dropped() const = 0;
  /// LoopSubstitution::solve().
  virtual void solve(const System<S>& system, const RightHandSide<S>& rhs, Solution<S>& solution) = 0;
};

/// A plan in strips of the width that suits the scalar.
template <class S>
EliminationPlan plan_for(const Model& model, EliminationRule rule = EliminationRule::path,
                         double most_operations = std::numeric_limits<double>::infinity()) {
  return EliminationPlan(model, strip_width<S>(rows_each(model)), rule, most_operations);
}

namespace detail {

template <class S, int width>
class Elimination final : public LoopElimination<S> {
 public:
  Elimination(const Model& model, EliminationPlan plan) : factors_(model, std::move(plan)), substitution_(model) {}

  bool factorise(const System<S>& system, std::span<const char> counts) override {
    return factors_.factorise(system, counts);
  }
  int dropped() const override { return factors_.dropped(); }
  void solve(const System<S>& system, const RightHandSide<S>& rhs, Solution<S>& solution) override {
    substitution_.solve(factors_, system, rhs, solution);
  }

 private:
  LoopFactors<S, width> factors_;
  LoopSubstitution<S, width> substitution_;
};

}  // namespace detail

template <class S>
std::unique_ptr<LoopElimination<S>> make_loop_elimination(const Model& model, EliminationPlan plan) {
  if constexpr (std::is_same_v<S, double>) {
    if (plan.width == 3) return std::make_unique<detail::Elimination<S, 3>>(model, std::move(plan));
    if (plan.width == 6) return std::make_unique<detail::Elimination<S, 6>>(model, std::move(plan));
  }
  return std::make_unique<detail::Elimination<S, 1>>(model, std::move(plan));
}
template <class S>
std::unique_ptr<LoopElimination<S>> make_loop_elimination(const Model& model) {
  return make_loop_elimination<S>(model, plan_for<S>(model));
}

}  // namespace lanc
