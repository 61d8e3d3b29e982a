#include "lib/formulation/tree_formulation.h"

#include <cmath>

#include "lib/solve/dense_algebra.h"
#include "lib/system/equations.h"

namespace lanc {
namespace {

/// Packs and dual numbers solve trees: which conditions count, and Cholesky's pivots, are decided by comparison.
template <class S>
constexpr bool closes_loops = requires(S a) {
  a < a;
};

}  // namespace

template <class S>
TreeFormulation<S>::TreeFormulation(const Model& model) : Formulation<S>(model) {
  if (!model.has_closures()) return;
  loaded_ = RightHandSide<S>(model);
  unit_ = Solution<S>(model);
  closure_.resize(model.closures().rows());
  lambda_.resize(model.closures().rows());
}

template <class S>
TreeFormulation<S>::~TreeFormulation() = default;

template <class S>
Outcome TreeFormulation<S>::factorise(const System<S>& system) {
  Outcome outcome = factorise_tree(system);
  if (!outcome.usable() || !this->model().has_closures()) return outcome;
  if constexpr (closes_loops<S>) return factorise_closures(system);
  return {Status::objection, "closed loops need a scalar that can be compared"};
}

template <class S>
Outcome TreeFormulation<S>::factorise_closures(const System<S>& system) {
  constexpr const char* objection =
      "the mass matrix of the tree that is left without its loops is singular, and this formulation divides by it; "
      "take "
      "one that does not, such as dense, nullspace or eq14-umfpack";
  const Model& model = this->model();
  rows_.clear();
  for (int k = 0; k < model.closures().rows(); ++k)
    if (this->closures().independent[k]) rows_.push_back(k);
  const int r = static_cast<int>(rows_.size());
  schur_.resize(r, r);
  for (int c = 0; c < r; ++c) {
    loaded_.set_zero();
    std::fill(closure_.begin(), closure_.end(), S(0.0));
    closure_[rows_[c]] = S(1.0);
    add_closure_reactions(system, closure_, loaded_);
    substitute_tree(system, loaded_, unit_);
    closure_accelerations(system, loaded_, unit_, closure_);
    for (int k = 0; k < r; ++k) {
      schur_(k, c) = closure_[rows_[k]];
      if (!std::isfinite(to_double(schur_(k, c)))) return {Status::objection, objection};
    }
  }
  if (!cholesky_in_place(schur_)) return {Status::objection, objection};
  return {};
}

template <class S>
void TreeFormulation<S>::substitute(const System<S>& system, const RightHandSide<S>& rhs, Solution<S>& solution) {
  const bool closed = this->model().has_closures();
  if (closed) std::fill(solution.lambda.begin(), solution.lambda.end(), S(0.0));  // the tree knows of no multipliers
  substitute_tree(system, rhs, solution);
  if constexpr (closes_loops<S>)
    if (closed) close(system, rhs, solution);
}

template <class S>
void TreeFormulation<S>::close(const System<S>& system, const RightHandSide<S>& rhs, Solution<S>& solution) {
  closure_accelerations(system, rhs, solution, closure_);  // of the open loops
  for (std::size_t k = 0; k < rows_.size(); ++k) lambda_[k] = -closure_[rows_[k]];
  solve_cholesky_in_place<S>(schur_, lambda_.head(rows_.size()));
  std::fill(closure_.begin(), closure_.end(), S(0.0));
  for (std::size_t k = 0; k < rows_.size(); ++k) closure_[rows_[k]] = lambda_[k];
  loaded_ = rhs;
  add_closure_reactions(system, closure_, loaded_);
  substitute_tree(system, loaded_, solution);
  solution.lambda = closure_;
}

template class TreeFormulation<double>;
template class TreeFormulation<long double>;
template class TreeFormulation<Count>;

}  // namespace lanc
