
#include "lib/formulation/reduced_formulation.h"
#include "lib/solve/dense_algebra.h"

namespace lanc {
namespace {

/// Momentum balance along an orthonormal basis Z of ker G, from Householder's QR of Gᵀ; M̄ is never divided by, only
/// ZᵀM̄Z.
template <class S>
class NullSpace final : public ReducedFormulation<S> {
 public:
  using ReducedFormulation<S>::ReducedFormulation;

 private:
  using typename ReducedFormulation<S>::Matrix;
  using typename ReducedFormulation<S>::Vector;

  Outcome factorise_closed(const System<S>& system) override;
  void substitute_closed(const Vector& b, const Vector& gamma, Vector& vdot, Vector& lambda) override;

  Qr<S> qr_;              // of Gᵀ
  Matrix Q1_, R_;         // Gᵀ = Q₁ R
  Matrix Z_;              // [Q₁ Z] is orthogonal
  Cholesky<S> cholesky_;  // of ZᵀM̄Z
};

template <class S>
Outcome NullSpace<S>::factorise_closed(const System<S>&) {
  const auto r = static_cast<Eigen::Index>(this->independent_rows().size());
  qr_.compute(this->independent_jacobian().transpose());
  const Matrix Q = qr_.Q();
  Q1_ = Q.leftCols(r);
  R_ = qr_.R(r);
  Z_ = Q.rightCols(Q.cols() - r);
  if (Z_.cols() == 0) return {};  // no freedom is left
  return cholesky_.compute(projected(this->mass_matrix(), Z_)) ? Outcome() : this->no_inertia("ZᵀM̄Z");
}

template <class S>
void NullSpace<S>::substitute_closed(const Vector& b, const Vector& gamma, Vector& vdot, Vector& lambda) {
  const std::vector<int>& rows = this->independent_rows();
  vdot = product(Q1_, solve_upper_transposed(R_, -chosen(gamma, rows)));  // η̇ = −Q₁ R⁻ᵀ γ̿ + Z z
  if (Z_.cols() > 0) {                                                    // ZᵀM̄Z z = Zᵀ (b − M̄ η̇)
    Vector rest = b;
    subtract_product(this->mass_matrix(), vdot, rest);
    add_product(Z_, cholesky_.solve(transposed_product(Z_, rest)), vdot);
  }
  Vector reaction = product(this->mass_matrix(), vdot);  // Gᵀ λ = M̄ η̇ − b
  reaction -= b;
  put(solve_upper(R_, transposed_product(Q1_, reaction)), rows, lambda);
}

const Registration registration({.name = "nullspace",
                                 .idea = "momentum balance projected on an orthonormal basis of ker G, from QR of Gᵀ",
                                 .source = "Kamman & Huston 1984; Mani, Haug & Atkinson 1985",
                                 .objection = dense_reduced_objection,
                                 .create_double = create<NullSpace<double>, double>,
                                 .create_long_double = create<NullSpace<long double>, long double>,
                                 .create_count = create<NullSpace<Count>, Count>});

}  // namespace
}  // namespace lanc
