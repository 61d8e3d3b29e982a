
#include "lib/formulation/reduced_formulation.h"
#include "lib/solve/dense.h"

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

  Matrix Q_;  // [Q₁ Z], Gᵀ = Q₁ R
  Matrix R_;
  Eigen::LLT<Matrix> cholesky_;  // of ZᵀM̄Z
};

template <class S>
Outcome NullSpace<S>::factorise_closed(const System<S>&) {
  const Eigen::HouseholderQR<Matrix> qr(this->independent_jacobian().transpose());
  const auto r = static_cast<Eigen::Index>(this->independent_rows().size());
  Q_ = qr.householderQ();
  R_ = qr.matrixQR().topRows(r).template triangularView<Eigen::Upper>();
  if (Q_.cols() == r) return {};  // no freedom is left
  const auto Z = Q_.rightCols(Q_.cols() - r);
  cholesky_.compute(Z.transpose() * this->mass_matrix() * Z);
  return cholesky_.info() == Eigen::Success ? Outcome() : this->no_inertia("ZᵀM̄Z");
}

template <class S>
void NullSpace<S>::substitute_closed(const Vector& b, const Vector& gamma, Vector& vdot, Vector& lambda) {
  const std::vector<int>& rows = this->independent_rows();
  const auto r = static_cast<Eigen::Index>(rows.size());
  const auto Q1 = Q_.leftCols(r), Z = Q_.rightCols(Q_.cols() - r);
  const auto R = R_.template triangularView<Eigen::Upper>();
  vdot = Q1 * R_.transpose().template triangularView<Eigen::Lower>().solve(Vector(-gamma(rows)));
  if (Z.cols() > 0) vdot += Z * cholesky_.solve(Z.transpose() * (b - this->mass_matrix() * vdot));
  lambda(rows) = Vector(R.solve(Vector(Q1.transpose() * (this->mass_matrix() * vdot - b))));
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
