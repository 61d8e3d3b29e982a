
#include "lib/formulation/reduced_formulation.h"
#include "lib/solve/dense.h"

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
  Matrix B_;
  Eigen::ColPivHouseholderQR<Matrix> rows_;  // Bᵀ P = Q [K; 0]
  Eigen::HouseholderQR<Matrix> columns_;     // Kᵀ = W T
};

template <class S>
Outcome UdwadiaKalaba<S>::factorise_closed(const System<S>&) {
  L_ = this->mass_matrix();
  const Eigen::LLT<Eigen::Ref<Matrix>> cholesky(L_);  // in place
  bool regular = cholesky.info() == Eigen::Success;
  // a pivot that is a rounding error of what was subtracted in it
  const double rounding = 100 * to_double(Eigen::NumTraits<S>::epsilon());
  for (int k = 0; k < L_.rows() && regular; ++k)
    regular = to_double(L_(k, k) * L_(k, k)) > rounding * to_double(this->mass_matrix()(k, k));
  if (!regular)
    return {Status::objection,
            "the mass matrix of the tree that is left without its loops is singular, and Udwadia & Kalaba's equation "
            "divides by it; take one that does not, such as dense, partitioning or nullspace"};
  const auto r = static_cast<Eigen::Index>(this->independent_rows().size());
  const Matrix Bt = L_.template triangularView<Eigen::Lower>().solve(this->closure_jacobian().transpose());
  B_ = Bt.transpose();
  rows_.compute(Bt);
  const Matrix K = rows_.matrixR().topRows(r).template triangularView<Eigen::Upper>();
  columns_.compute(K.transpose());
  return {};
}

template <class S>
void UdwadiaKalaba<S>::substitute_closed(const Vector& b, const Vector& gamma, Vector& vdot, Vector& lambda) {
  const auto r = static_cast<Eigen::Index>(this->independent_rows().size());
  const auto T = columns_.matrixQR().topRows(r).template triangularView<Eigen::Upper>();
  vdot = L_.template triangularView<Eigen::Lower>().solve(b);  // Lᵀ times the acceleration of the tree
  const Vector open = rows_.colsPermutation().transpose() * Vector(-gamma - B_ * vdot);
  const Vector along = T.solve(Vector((columns_.householderQ().adjoint() * open).head(r)));
  Vector correction = Vector::Constant(vdot.size(), S(0.0));
  correction.head(r) = along;
  vdot += rows_.householderQ() * correction;
  vdot = L_.transpose().template triangularView<Eigen::Upper>().solve(vdot).eval();
  Vector reaction = Vector::Constant(gamma.size(), S(0.0));  // λ = (B⁺)ᵀ times the correction: of minimum norm
  reaction.head(r) = T.transpose().solve(along);
  lambda = rows_.colsPermutation() * Vector(columns_.householderQ() * reaction);
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
