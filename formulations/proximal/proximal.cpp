
#include "lib/formulation/reduced_formulation.h"
#include "lib/solve/dense_algebra.h"

namespace lanc {
namespace {

/// Proximal iterations on the multipliers: LU of [M̄ Gᵀ; G −μ1] with all rows.
template <class S>
class Proximal final : public RegularisedFormulation<S> {
 public:
  explicit Proximal(const Model& model)
      : RegularisedFormulation<S>(model), both_(model.nv() + model.closures().rows()) {}

 private:
  using typename RegularisedFormulation<S>::Matrix;
  using typename RegularisedFormulation<S>::Vector;

  Outcome factorise_regularised() override;
  void step(const Vector& p, const Vector& q, Vector& x, Vector& l) override;

  Matrix saddle_;  // equilibrated
  Vector scale_, both_;
  Lu<S> lu_;
};

/// μ over the largest diagonal entry of G M̄⁻¹ Gᵀ.
constexpr double relative_mu = 1e-10;

template <class S>
Outcome Proximal<S>::factorise_regularised() {
  const auto& M = this->mass_matrix();
  const auto& G = this->closure_jacobian();
  const Eigen::Index n = G.cols(), m = G.rows();
  const Vector delassus = this->delassus_diagonal();
  saddle_.setConstant(n + m, n + m, S(0.0));
  saddle_.topLeftCorner(n, n) = M;
  saddle_.topRightCorner(n, m) = G.transpose();
  saddle_.bottomLeftCorner(m, n) = G;
  saddle_.bottomRightCorner(m, m).diagonal().setConstant(-S(relative_mu) * delassus.maxCoeff());
  scale_.setConstant(n + m, S(1.0));
  for (Eigen::Index k = 0; k < n; ++k)
    if (to_double(M(k, k)) > 0) scale_[k] = S(1.0) / sqrt(M(k, k));
  for (Eigen::Index i = 0; i < m; ++i) scale_[n + i] = S(1.0) / sqrt(delassus[i]);
  scale_both_sides(scale_, saddle_);
  lu_.compute(saddle_);
  return {};
}

template <class S>
void Proximal<S>::step(const Vector& p, const Vector& q, Vector& x, Vector& l) {
  both_.head(p.size()) = p;
  both_.tail(q.size()) = q;
  both_.array() *= scale_.array();
  both_ = lu_.solve(both_);
  both_.array() *= scale_.array();
  x = both_.head(p.size());
  l = -both_.tail(q.size());
}

const Registration registration({.name = "proximal",
                                 .idea = "proximal iterations on λ: [M̄ Gᵀ; G −μ1], all rows",
                                 .source = "Carpentier, Budhiraja & Mansard 2021",
                                 .objection = dense_reduced_objection,
                                 .create_double = create<Proximal<double>, double>,
                                 .create_long_double = create<Proximal<long double>, long double>,
                                 .create_count = create<Proximal<Count>, Count>});

}  // namespace
}  // namespace lanc
