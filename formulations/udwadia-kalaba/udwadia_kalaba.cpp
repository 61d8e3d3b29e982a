
#include "lib/formulation/reduced_formulation.h"
#include "lib/solve/dense_algebra.h"

namespace lanc {
namespace {

/// The tree's own acceleration, and the least correction of it, measured by M̄, that satisfies the closure conditions:
/// by the pseudo-inverse of B = G L⁻ᵀ, M̄ = L Lᵀ, all rows, truncated at the decided rank. Divides by M̄: where the tree
/// without its loops is singular, this is an objection.
template <class S>
class UdwadiaKalaba final : public ReducedFormulation<S> {
 public:
  using ReducedFormulation<S>::ReducedFormulation;

 private:
  using typename ReducedFormulation<S>::Matrix;
  using typename ReducedFormulation<S>::Vector;

  Outcome factorise_closed(const System<S>& system) override;
  void substitute_closed(const Vector& b, const Vector& gamma, Vector& vdot, Vector& lambda) override;

  // B = P Kᵀ Q₁ᵀ with Kᵀ = W T: two QR factorisations make an orthogonal one, whose pseudo-inverse is Q₁ T⁻¹ Wᵀ Pᵀ
  Matrix L_;
  Matrix Bt_;          // Bᵀ = L⁻¹ Gᵀ
  PivotedQr<S> rows_;  // Bᵀ P = Q [K; 0]
  Qr<S> columns_;      // Kᵀ = W T
  Matrix T_;
};

/// x and zeros behind it.
template <class Vector>
Vector extended(const Vector& x, Eigen::Index size) {
  Vector result = Vector::Constant(size, typename Vector::Scalar(0.0));
  result.head(x.size()) = x;
  return result;
}

template <class S>
Outcome UdwadiaKalaba<S>::factorise_closed(const System<S>&) {
  L_ = this->mass_matrix();
  bool regular = cholesky_in_place(L_);
  // a pivot that is a rounding error of what was subtracted in it
  const double rounding = 100 * to_double(Eigen::NumTraits<S>::epsilon());
  for (int k = 0; k < L_.rows() && regular; ++k)
    regular = to_double(L_(k, k) * L_(k, k)) > rounding * to_double(this->mass_matrix()(k, k));
  if (!regular)
    return {Status::objection,
            "the mass matrix of the tree that is left without its loops is singular, and Udwadia & Kalaba's equation "
            "divides by it; take one that does not, such as dense, partitioning or nullspace"};
  const auto r = static_cast<Eigen::Index>(this->independent_rows().size());
  Bt_ = solve_lower<S>(L_, this->closure_jacobian().transpose());
  rows_.compute(Bt_);
  columns_.compute(rows_.R(r).transpose());
  T_ = columns_.R(r);
  return {};
}

template <class S>
void UdwadiaKalaba<S>::substitute_closed(const Vector& b, const Vector& gamma, Vector& vdot, Vector& lambda) {
  const auto r = static_cast<Eigen::Index>(this->independent_rows().size());
  vdot = solve_lower(L_, b);  // Lᵀ times the acceleration of the tree
  Vector open = -gamma;
  subtract_transposed_product(Bt_, vdot, open);
  // T⁻¹ Wᵀ Pᵀ, then Q₁
  const Vector along = solve_upper(T_, columns_.times_Q_transposed(rows_.permuted_back(open)).head(r));
  vdot += rows_.times_Q(extended(along, vdot.size()));
  vdot = solve_lower_transposed(L_, vdot);
  // λ = (B⁺)ᵀ times the correction: of minimum norm
  const Vector reaction = solve_upper_transposed(T_, along);
  lambda = rows_.permuted(columns_.times_Q(extended(reaction, gamma.size())));
}

const Registration registration({.name = "udwadia-kalaba",
                                 .idea = "the tree's acceleration, corrected by the pseudo-inverse of G M̄^(-1/2)",
                                 .source = "Udwadia & Kalaba 1992",
                                 .objection = dense_reduced_objection,
                                 .create_double = create<UdwadiaKalaba<double>, double>,
                                 .create_long_double = create<UdwadiaKalaba<long double>, long double>,
                                 .create_count = create<UdwadiaKalaba<Count>, Count>});

}  // namespace
}  // namespace lanc
