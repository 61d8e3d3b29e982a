#include "formulations/partitioning/partitioning.h"

#include <fmt/format.h>

namespace lanc {

template <class S>
Partitioning<S>::Partitioning(const Model& model, ExplicitOptions options)
    : ReducedFormulation<S>(model), options_(std::move(options)), choice_(model, options_) {}

template <class S>
Outcome Partitioning<S>::factorise_closed(const System<S>& system) {
  const Matrix G = this->independent_jacobian();
  independent_ = choice_.choice(G.unaryExpr([](const S& x) { return to_double(x); }), to_double(system.state.t));
  dependent_.clear();
  for (int k = 0, next = 0; k < G.cols(); ++k)
    if (next < static_cast<int>(independent_.size()) && independent_[next] == k)
      ++next;
    else
      dependent_.push_back(k);
  Gd_.compute(chosen_columns(G, dependent_));
  J_.setConstant(G.cols(), G.cols() - G.rows(), S(0.0));
  if (independent_.empty()) return {};  // no freedom is left
  const Matrix X = Gd_.solve(chosen_columns(G, independent_));
  for (std::size_t c = 0; c < independent_.size(); ++c) {
    J_(independent_[c], c) = S(1.0);
    for (std::size_t k = 0; k < dependent_.size(); ++k) J_(dependent_[k], c) = -X(k, c);
  }
  return cholesky_.compute(projected(this->mass_matrix(), J_)) ? Outcome() : this->no_inertia("J*ᵀM̄J*");
}

template <class S>
void Partitioning<S>::substitute_closed(const Vector& b, const Vector& gamma, Vector& vdot, Vector& lambda) {
  const std::vector<int>& rows = this->independent_rows();
  vdot.setConstant(S(0.0));
  put<S>(-Gd_.solve(chosen(gamma, rows)), dependent_, vdot);  // η̿
  if (!independent_.empty()) {                                // J*ᵀM̄J* ṡ = J*ᵀ (b − M̄ η̿)
    Vector rest = b;
    subtract_product(this->mass_matrix(), vdot, rest);
    add_product(J_, cholesky_.solve(transposed_product(J_, rest)), vdot);
  }
  Vector reaction = product(this->mass_matrix(), vdot);  // Gᵀ λ = M̄ η̇ − b
  reaction -= b;
  put(Gd_.solve_transposed(chosen(reaction, dependent_)), rows, lambda);
}

template class Partitioning<double>;
template class Partitioning<long double>;
template class Partitioning<Count>;

namespace {

const Registration registration(
    {.name = "partitioning",
     .idea = "independent velocities s, chosen and changed by pivoting: J*ᵀ M̄ J* ṡ = J*ᵀ (b − M̄ η̿)",
     .source = "lecture, explicit closure conditions; Wehage & Haug 1982",
     .objection = dense_reduced_objection,
     .create_double = create<Partitioning<double>, double>,
     .create_long_double = create<Partitioning<long double>, long double>,
     .create_count = create<Partitioning<Count>, Count>});

}  // namespace
}  // namespace lanc
