#include "lib/formulation/reduced_formulation.h"

#include <fmt/format.h>

#include <limits>

#include "lib/solve/dense_algebra.h"
#include "lib/system/equations.h"

namespace lanc {

template <class S>
ReducedFormulation<S>::ReducedFormulation(const Model& model)
    : Formulation<S>(model),
      scaling_(model),
      sparse_jacobian_(model),
      composite_(model.bodies()),
      load_(model.bodies()),
      mass_matrix_(model.nv(), model.nv()),
      jacobian_(model.closures().rows(), model.nv()),
      b_(model.nv()),
      gamma_(model.closures().rows()),
      vdot_(model.nv()),
      lambda_(model.closures().rows()) {
  rows_.reserve(model.closures().rows());
}

template <class S>
void ReducedFormulation<S>::assemble(const System<S>& system) {
  form_mass_matrix(system);
  if (this->model().has_closures()) form_jacobian(system);
}

/// M^c C_k moved towards the root meets the columns of every joint on the way; the lower triangle.
template <class S>
void ReducedFormulation<S>::form_mass_matrix(const System<S>& system) {
  const Model& model = this->model();
  mass_matrix_.setConstant(S(0.0));
  for (int i = 0; i < model.bodies(); ++i) composite_[i] = system.bodies[i].inertia;
  for (int i = model.bodies() - 1; i >= 0; --i) {
    const Link& link = model.link(i);
    for (int k = link.v; k < link.v + link.nv; ++k) {
      Wrench<S> F = times_column(composite_[i], model.column_kind(k), system.columns[k]);
      for (int l = k; l >= link.v; --l) mass_matrix_(k, l) = project(model.column_kind(l), system.columns[l], F);
      for (int body = i; model.link(body).parent != ground;) {
        F = moved_inward(system.bodies[body].r, F);
        body = model.link(body).parent;
        const Link& on_path = model.link(body);
        for (int l = on_path.v; l < on_path.v + on_path.nv; ++l)
          mass_matrix_(k, l) = project(model.column_kind(l), system.columns[l], F);
      }
      if (model.has_armature()) mass_matrix_(k, k) += S(model.armature()[k]);
    }
    if (link.parent != ground) composite_[link.parent] += moved_inward(system.bodies[i].r, composite_[i]);
  }
}

template <class S>
void ReducedFormulation<S>::form_jacobian(const System<S>& system) {
  sparse_jacobian_.evaluate(system);
  jacobian_.setConstant(S(0.0));
  for (int k = 0; k < sparse_jacobian_.rows(); ++k)
    for (int p = sparse_jacobian_.starts()[k]; p < sparse_jacobian_.starts()[k + 1]; ++p) {
      const int c = sparse_jacobian_.columns()[p];
      jacobian_(k, c) = sparse_jacobian_.values()[p] * S(scaling_.row[k] * scaling_.column[c]);
    }
}

template <class S>
Outcome ReducedFormulation<S>::no_inertia(const char* matrix) {
  return {Status::singular,
          fmt::format("Cholesky: {} is not positive definite, so some freedom has no inertia at this state", matrix)};
}

template <class S>
Outcome ReducedFormulation<S>::factorise(const System<S>& system) {
  const Model& model = this->model();
  rows_.clear();
  for (int k = 0; k < model.closures().rows(); ++k)
    if (this->closures().independent[k]) rows_.push_back(k);
  if (rows_.empty()) {
    return cholesky_in_place(mass_matrix_) ? Outcome() : no_inertia("M̄");
  }
  for (int k = 0; k < model.nv(); ++k)
    for (int l = 0; l <= k; ++l) mass_matrix_(l, k) = mass_matrix_(k, l) *= S(scaling_.column[k] * scaling_.column[l]);
  return factorise_closed(system);
}

template <class S>
typename ReducedFormulation<S>::Matrix ReducedFormulation<S>::independent_jacobian() const {
  return chosen_rows(jacobian_, rows_);
}

/// b = Jᵀ (f̂^tc − M ā) + τ, leaf to root. Leaves ā in the solution.
template <class S>
void ReducedFormulation<S>::form_b(const System<S>& system, const RightHandSide<S>& rhs, Solution<S>& solution) {
  const Model& model = this->model();
  bias_accelerations(system, rhs, solution);
  for (int i = 0; i < model.bodies(); ++i)
    load_[i] = rhs.force[i] - system.bodies[i].inertia * solution.acceleration[i];
  for (int i = model.bodies() - 1; i >= 0; --i) {
    const Link& link = model.link(i);
    for (int k = link.v; k < link.v + link.nv; ++k)
      b_[k] = rhs.tau[k] + project(model.column_kind(k), system.columns[k], load_[i]);
    if (link.parent != ground) load_[link.parent] += moved_inward(system.bodies[i].r, load_[i]);
  }
}

template <class S>
void ReducedFormulation<S>::solve_closed(const System<S>& system, const RightHandSide<S>& rhs, Solution<S>& solution) {
  std::fill(solution.vdot.begin(), solution.vdot.end(), S(0.0));
  closure_accelerations(system, rhs, solution, solution.lambda);  // γ̿ in joint coordinates: â is that at η̇ = 0
  for (int k = 0; k < gamma_.size(); ++k) gamma_[k] = solution.lambda[k] * S(scaling_.row[k]);
  for (int k = 0; k < b_.size(); ++k) b_[k] *= S(scaling_.column[k]);
  lambda_.setConstant(S(0.0));
  substitute_closed(b_, gamma_, vdot_, lambda_);
  for (int k = 0; k < b_.size(); ++k) solution.vdot[k] = vdot_[k] * S(scaling_.column[k]);
  for (int k = 0; k < gamma_.size(); ++k) solution.lambda[k] = lambda_[k] * S(scaling_.row[k]);
}

template <class S>
void ReducedFormulation<S>::substitute(const System<S>& system, const RightHandSide<S>& rhs, Solution<S>& solution) {
  form_b(system, rhs, solution);
  if (rows_.empty()) {
    solve_cholesky_in_place<S>(mass_matrix_, b_);
    for (int k = 0; k < b_.size(); ++k) solution.vdot[k] = b_[k];
    std::fill(solution.lambda.begin(), solution.lambda.end(), S(0.0));
  } else {
    solve_closed(system, rhs, solution);
  }
  newton_euler(system, rhs, solution);
}

template <class S>
RegularisedFormulation<S>::RegularisedFormulation(const Model& model)
    : ReducedFormulation<S>(model), x_(model.nv()), l_(model.closures().rows()) {}

template <class S>
Outcome RegularisedFormulation<S>::factorise_closed(const System<S>&) {
  const auto r = static_cast<Eigen::Index>(this->independent_rows().size());
  const auto& G = this->closure_jacobian();
  range_.resize(0, 0);
  if (r < G.rows()) {
    PivotedQr<S> qr;
    qr.compute(G);
    range_ = qr.Q(r);
  }
  return factorise_regularised();
}

template <class S>
void RegularisedFormulation<S>::keep_in_range(Vector& rows) const {
  if (range_.size() > 0) rows = product(range_, transposed_product(range_, rows));
}

template <class S>
void RegularisedFormulation<S>::substitute_closed(const Vector& b, const Vector& gamma, Vector& vdot, Vector& lambda) {
  constexpr int most_steps = 200;
  const auto& M = this->mass_matrix();
  const auto& G = this->closure_jacobian();
  const auto largest = [](const auto& x) { return to_double(x.cwiseAbs().maxCoeff()); };
  const double rows = to_double(G.cwiseAbs().rowwise().sum().maxCoeff());
  const double inertia = std::max(to_double(M.diagonal().maxCoeff()), std::numeric_limits<double>::min());
  const double rounding = to_double(Eigen::NumTraits<S>::epsilon()) * std::sqrt(static_cast<double>(b.size()));
  vdot.setConstant(S(0.0));
  // A step repeats the momentum balance, too: it has come to its rounding errors when it changes nothing, or no less
  // than the step before.
  bool settled = false;
  double last = std::numeric_limits<double>::infinity();
  for (steps_ = 0; steps_ < most_steps; ++steps_) {
    q_ = -gamma;
    subtract_product(G, vdot, q_);
    keep_in_range(q_);
    // what its rounding errors come from; loads that balance leave accelerations of rounding errors alone
    const double size = rows * std::max(largest(vdot), largest(b) / inertia) + largest(gamma);
    if (settled && !(largest(q_) > rounding * size)) break;
    p_ = b;
    subtract_product(M, vdot, p_);
    add_transposed_product(G, lambda, p_);
    step(p_, q_, x_, l_);
    vdot += x_;
    lambda += l_;
    const double change = largest(x_);
    settled = !(change > rounding * largest(vdot)) || !(change < last / 2);
    last = change;
  }
  keep_in_range(lambda);
}

template <class S>
typename RegularisedFormulation<S>::Vector RegularisedFormulation<S>::delassus_diagonal() const {
  const auto& M = this->mass_matrix();
  const auto& G = this->closure_jacobian();
  Vector diagonal = Vector::Constant(G.rows(), S(0.0));
  for (int k = 0; k < G.cols(); ++k) {
    if (!(to_double(M(k, k)) > 0)) continue;
    const S inverse = S(1.0) / M(k, k);
    for (int i = 0; i < G.rows(); ++i)
      if (to_double(G(i, k)) != 0) diagonal[i] += G(i, k) * G(i, k) * inverse;
  }
  const double largest = to_double(diagonal.maxCoeff());
  // a row of rounding errors alone (the plane of a planar loop) would get a penalty of 1e32
  const double smallest = zero_singular_value * zero_singular_value * largest;
  for (int i = 0; i < G.rows(); ++i)
    if (!(to_double(diagonal[i]) > smallest)) diagonal[i] = S(largest > 0 ? largest : 1.0);
  return diagonal;
}

std::optional<std::string> dense_reduced_objection(const Model& model) {
  constexpr double most = 1e8;  // entries, 0.8 GB, and minutes of work
  const double unknowns = model.nv() + model.closures().rows();
  if (unknowns * unknowns <= most) return std::nullopt;
  return fmt::format(
      "{} velocities and {} closure rows: dense M̄ and G would take {:.2g} GB; use a formulation that "
      "keeps the structure",
      model.nv(), model.closures().rows(), 8e-9 * unknowns * unknowns);
}

template class ReducedFormulation<double>;
template class ReducedFormulation<long double>;
template class ReducedFormulation<Count>;
template class RegularisedFormulation<double>;
template class RegularisedFormulation<long double>;
template class RegularisedFormulation<Count>;

}  // namespace lanc
