#include "lib/formulation/reduced_formulation.h"
#include "lib/solve/dense_algebra.h"

namespace lanc {
namespace {

/// Closure rows as penalties α on their accelerations, corrected by multipliers until they hold: Cholesky of
/// M̄ + Gᵀ α G with all rows.
template <class S>
class Augmented final : public RegularisedFormulation<S> {
 public:
  using RegularisedFormulation<S>::RegularisedFormulation;

 private:
  using typename RegularisedFormulation<S>::Matrix;
  using typename RegularisedFormulation<S>::Vector;

  Outcome factorise_regularised() override;
  void step(const Vector& p, const Vector& q, Vector& x, Vector& l) override;

  Vector alpha_;
  Cholesky<S> cholesky_;
};

/// α of each row relative to its own effective inertia 1 / (G M̄⁻¹ Gᵀ)_ii. A step leaves the fraction 1e-8 κ of the
/// closure errors, κ being the condition of the equilibrated G M̄⁻¹ Gᵀ, and 1e8 ε of the momentum's: the middle.
constexpr double relative_penalty = 1e8;

template <class S>
Outcome Augmented<S>::factorise_regularised() {
  alpha_ = S(relative_penalty) * this->delassus_diagonal().cwiseInverse();
  const Matrix& G = this->closure_jacobian();
  Matrix alpha_G = G;
  for (Eigen::Index i = 0; i < G.rows(); ++i) alpha_G.row(i) *= alpha_[i];
  Matrix matrix = transposed_product(G, alpha_G);
  matrix += this->mass_matrix();
  return cholesky_.compute(std::move(matrix)) ? Outcome() : this->no_inertia("M̄ + αGᵀG");
}

template <class S>
void Augmented<S>::step(const Vector& p, const Vector& q, Vector& x, Vector& l) {
  const Matrix& G = this->closure_jacobian();
  x = p;
  add_transposed_product(G, alpha_.cwiseProduct(q), x);
  x = cholesky_.solve(x);
  l = q;
  subtract_product(G, x, l);
  l.array() *= alpha_.array();
}

const Registration registration({.name = "augmented",
                                 .idea = "penalties on closure accelerations with multipliers: M̄ + αGᵀG, iterated",
                                 .source = "Bayo, García de Jalón & Serna 1988",
                                 .objection = dense_reduced_objection,
                                 .create_double = create<Augmented<double>, double>,
                                 .create_long_double = create<Augmented<long double>, long double>,
                                 .create_count = create<Augmented<Count>, Count>});

}  // namespace
}  // namespace lanc
