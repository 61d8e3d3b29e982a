
#include "lib/formulation/reduced_formulation.h"
#include "lib/solve/dense_algebra.h"

namespace lanc {
namespace {

/// The tree's own acceleration, and the least correction of it, measured by M̄, that satisfies the closure conditions:
/// by the pseudo-inverse of B = G L⁻ᵀ, M̄ = L Lᵀ, of the independent rows. (Of all rows, truncated at their rank, it
/// loses reactions where bodies are light: rounding errors that L⁻¹ magnifies stand for small rows. Seed 71094 of
/// fuzz_closed lost 3e-4.) Divides by M̄: where the tree without its loops is singular, this is an objection.
template <class S>
class UdwadiaKalaba final : public ReducedFormulation<S> {
 public:
  using ReducedFormulation<S>::ReducedFormulation;

 private:
  using typename ReducedFormulation<S>::Matrix;
  using typename ReducedFormulation<S>::Vector;

  Outcome factorise_closed(const System<S>& system) override;
  void substitute_closed(const Vector& b, const Vector& gamma, Vector& vdot, Vector& lambda) override;

  Matrix L_;
  Matrix Bt_;  // Bᵀ = L⁻¹ Gᵀ
  Qr<S> qr_;
  Matrix Q1_, R_;  // Bᵀ = Q₁ R, so that B⁺ = Q₁ R⁻ᵀ
};

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
  Bt_ = solve_lower<S>(L_, this->independent_jacobian().transpose());
  qr_.compute(Bt_);
  Q1_ = qr_.Q(r);
  R_ = qr_.R(r);
  return {};
}

template <class S>
void UdwadiaKalaba<S>::substitute_closed(const Vector& b, const Vector& gamma, Vector& vdot, Vector& lambda) {
  const std::vector<int>& rows = this->independent_rows();
  vdot = solve_lower(L_, b);  // Lᵀ times the acceleration of the tree
  Vector open = -chosen(gamma, rows);
  subtract_transposed_product(Bt_, vdot, open);
  const Vector along = solve_upper_transposed(R_, open);
  vdot += product(Q1_, along);
  vdot = solve_lower_transposed(L_, vdot);
  put(solve_upper(R_, along), rows, lambda);  // λ = (B⁺)ᵀ times the correction
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
