#include <fmt/format.h>

#include "lib/formulation/formulation.h"
#include "lib/model/paths.h"
#include "lib/scalar/count_eigen.h"
#include "lib/solve/dense_algebra.h"
#include "lib/system/closure_jacobian.h"
#include "lib/system/equations.h"

namespace lanc {
namespace {

/// The lecture's non-recursive way: J formed (11), M̄ = JᵀMJ block by block, dense Cholesky. O(n d²) to form M̄ at depth
/// d, O(n_η³) to factor it. Where loops are closed, LU of [M̄ Gᵀ; G 0] with the independent rows of G: it divides by no
/// M̄, so a tree without inertia may be held by its loops.
template <class S>
class Dense final : public Formulation<S> {
 public:
  explicit Dense(const Model& model)
      : Formulation<S>(model),
        paths_(model),
        closures_(model.closures().rows()),
        mass_matrix_(model.nv(), model.nv()),
        b_(model.nv() + closures_),
        jacobian_(model) {
    start_.reserve(model.bodies() + 1);
    start_.push_back(0);
    for (int i = 0; i < model.bodies(); ++i) start_.push_back(start_.back() + paths_.body_depth(i));
    J_.resize(start_.back());
  }

  void assemble(const System<S>& system) override {
    form_jacobian(system);
    form_mass_matrix(system);
  }
  Outcome factorise(const System<S>& system) override;
  void substitute(const System<S>& system, const RightHandSide<S>& rhs, Solution<S>& solution) override;

 private:
  using Matrix = DenseMatrix<S>;
  using Vector = DenseVector<S>;

  void form_jacobian(const System<S>& system);
  void form_mass_matrix(const System<S>& system);
  void form_kkt(const System<S>& system);
  void solve_kkt(const System<S>& system, const RightHandSide<S>& rhs, Solution<S>& solution);
  /// The non-zero columns of J_i: one for every coordinate on the path of body i, root first.
  Motion<S>* jacobian(int body) { return J_.data() + start_[body]; }

  VelocityPaths paths_;
  int closures_;
  std::vector<std::size_t> start_;
  std::vector<Motion<S>> J_;
  Matrix mass_matrix_;  // lower triangle: M̄, then its Cholesky factor
  Vector b_;
  ClosureJacobian<S> jacobian_;
  Matrix bordered_;  // [M̄ Gᵀ; G 0], equilibrated
  Vector scale_;
  Lu<S> kkt_;
};

/// J = B⁻¹ C by forward substitution: the columns of the parent moved outward, and the joint's own.
template <class S>
void Dense<S>::form_jacobian(const System<S>& system) {
  const Model& model = this->model();
  for (int i = 0; i < model.bodies(); ++i) {
    const Link& link = model.link(i);
    Motion<S>* J = jacobian(i);
    if (link.parent != ground) {
      const Motion<S>* parent = jacobian(link.parent);
      int k = paths_.last(link.parent);
      for (int d = paths_.body_depth(link.parent) - 1; d >= 0; --d, k = paths_.before(k))
        J[d] =
            model.column_kind(k) == ColumnKind::translation ? parent[d] : moved_outward(system.bodies[i].r, parent[d]);
    }
    for (int c = 0; c < link.nv; ++c) J[paths_.body_depth(i) - link.nv + c] = system.columns[link.v + c];
  }
}

template <class S>
void Dense<S>::form_mass_matrix(const System<S>& system) {
  const Model& model = this->model();
  mass_matrix_.setConstant(S(0.0));
  for (int i = 0; i < model.bodies(); ++i) {
    const Motion<S>* J = jacobian(i);
    int k = paths_.last(i);
    for (int d = paths_.body_depth(i) - 1; d >= 0; --d, k = paths_.before(k)) {
      const Wrench<S> F = system.bodies[i].inertia * J[d];
      int l = k;
      for (int e = d; e >= 0; --e, l = paths_.before(l)) mass_matrix_(k, l) += dot(J[e], F);
    }
  }
  if (model.has_armature())
    for (int k = 0; k < model.nv(); ++k) mass_matrix_(k, k) += S(model.armature()[k]);
}

/// [M̄ Gᵀ; G 0], dependent rows replaced by λ = 0. Rows and columns are scaled by 1/√M̄_kk and rows of G to unit length.
template <class S>
void Dense<S>::form_kkt(const System<S>& system) {
  const int nv = this->model().nv();
  bordered_.setConstant(nv + closures_, nv + closures_, S(0.0));
  scale_.setConstant(nv + closures_, S(1.0));
  for (int k = 0; k < nv; ++k)
    for (int l = 0; l <= k; ++l) bordered_(k, l) = bordered_(l, k) = mass_matrix_(k, l);
  for (int k = 0; k < nv; ++k)
    if (const double m = to_double(mass_matrix_(k, k)); m > 0) scale_[k] = S(1.0) / sqrt(mass_matrix_(k, k));
  jacobian_.evaluate(system);
  for (int k = 0; k < closures_; ++k) {
    if (!this->closures().independent[k]) {
      bordered_(nv + k, nv + k) = S(1.0);
      continue;
    }
    S square(0.0);
    for (int p = jacobian_.starts()[k]; p < jacobian_.starts()[k + 1]; ++p) {
      const S entry = jacobian_.values()[p];
      bordered_(nv + k, jacobian_.columns()[p]) = bordered_(jacobian_.columns()[p], nv + k) = entry;
      square += entry * scale_[jacobian_.columns()[p]] * entry * scale_[jacobian_.columns()[p]];
    }
    scale_[nv + k] = S(1.0) / sqrt(square);
  }
  scale_both_sides(scale_, bordered_);
}

template <class S>
Outcome Dense<S>::factorise(const System<S>& system) {
  if (closures_ > 0) {
    form_kkt(system);
    kkt_.compute(bordered_);
    return {};
  }
  if (!cholesky_in_place(mass_matrix_))
    return {Status::singular, "Cholesky: M̄ is not positive definite, so some freedom has no inertia at this state"};
  return {};
}

template <class S>
void Dense<S>::solve_kkt(const System<S>& system, const RightHandSide<S>& rhs, Solution<S>& solution) {
  const int nv = this->model().nv();
  std::fill(solution.vdot.begin(), solution.vdot.end(), S(0.0));
  closure_accelerations(system, rhs, solution, solution.lambda);  // γ̿ in joint coordinates: â is that at η̇ = 0
  for (int k = 0; k < closures_; ++k) b_[nv + k] = this->closures().independent[k] ? -solution.lambda[k] : S(0.0);
  Vector x = kkt_.solve(Vector(scale_.cwiseProduct(b_)));
  x.array() *= scale_.array();
  for (int k = 0; k < nv; ++k) solution.vdot[k] = x[k];
  for (int k = 0; k < closures_; ++k) solution.lambda[k] = -x[nv + k];  // M̄ η̇ − Gᵀ λ = b
}

template <class S>
void Dense<S>::substitute(const System<S>& system, const RightHandSide<S>& rhs, Solution<S>& solution) {
  const Model& model = this->model();
  bias_accelerations(system, rhs, solution);
  for (int k = 0; k < model.nv(); ++k) b_[k] = rhs.tau[k];
  for (int i = 0; i < model.bodies(); ++i) {  // b = Jᵀ (f̂^tc − M ā) + τ
    const Wrench<S> load = rhs.force[i] - system.bodies[i].inertia * solution.acceleration[i];
    const Motion<S>* J = jacobian(i);
    int k = paths_.last(i);
    for (int d = paths_.body_depth(i) - 1; d >= 0; --d, k = paths_.before(k)) b_[k] += dot(J[d], load);
  }
  if (closures_ > 0) {
    solve_kkt(system, rhs, solution);
  } else {
    solve_cholesky_in_place<S>(mass_matrix_, b_);
    for (int k = 0; k < model.nv(); ++k) solution.vdot[k] = b_[k];
  }
  newton_euler(system, rhs, solution);
}

std::optional<std::string> objection(const Model& model) {
  constexpr int most = 10'000;  // 0.8 GB of M̄ and minutes of Cholesky
  if (model.nv() <= most) return std::nullopt;
  return fmt::format("{} velocities: a dense M̄ would take {:.2g} GB; use a formulation that keeps the structure",
                     model.nv(), 8e-9 * model.nv() * model.nv());
}

const Registration registration({.name = "dense",
                                 .idea = "form J and M̄ = JᵀMJ, solve M̄ η̇ = Jᵀ(f̂^tc − M ā) + τ by dense Cholesky",
                                 .source = "lecture, eq. 11-14: the non-recursive way",
                                 .objection = objection,
                                 .create_double = create<Dense<double>, double>,
                                 .create_long_double = create<Dense<long double>, long double>,
                                 .create_count = create<Dense<Count>, Count>});

}  // namespace
}  // namespace lanc
