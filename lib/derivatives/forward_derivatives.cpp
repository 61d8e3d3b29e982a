#include "lib/derivatives/forward_derivatives.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "lib/closure/scaling.h"
#include "lib/derivatives/closure_outcome.h"
#include "lib/derivatives/inverse_dynamics_derivatives.h"
#include "lib/derivatives/mass_inverse.h"
#include "lib/derivatives/pair_derivatives.h"
#include "lib/system/closure_jacobian.h"

namespace lanc {
namespace {

using Matrix = Eigen::MatrixXd;
using View = Eigen::Map<Matrix>;
using Rows = Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>;

constexpr double rounding = std::numeric_limits<double>::epsilon();
/// Of what Formulation::solve() promises for η̇.
constexpr double largest_error = 1e-8;

bool finite(const std::vector<double>& values) {
  return std::isfinite(
      Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size())).sum());
}

Outcome singular_tree(Outcome outcome) {
  outcome.status = Status::objection;
  outcome.message =
      "the mass matrix of the tree that is left without its loops is singular or not positive definite, and the "
      "derivatives are made by its inverse";
  return outcome;
}

}  // namespace

/// Rows of G and their projections, where loops are closed: with L Lᵀ = G M̄⁻¹ Gᵀ and Z = M̄⁻¹ Gᵀ L⁻ᵀ,
///   T = −L⁻¹ (∂(G η̇ + γ̿) − G M̄⁻¹ ∂r),   ∂η̇ = −M̄⁻¹ ∂r + Z T,   ∂λ = L⁻ᵀ T,
/// ∂(G η̇ + γ̿) and ∂r at constant η̇ and λ.
class AnalyticDerivatives::Loops {
 public:
  explicit Loops(const Model& model)
      : model_(model),
        rank_(model),
        jacobian_(model),
        scale_(ClosureScaling(model).column),
        lambda_(model.closures().rows()),
        force_(model.nv()) {
    const std::size_t n = model.nv(), rows = model.closures().rows();
    for (std::vector<double>* m : {&position_, &velocity_, &G_, &Z_, &T_}) m->resize(rows * n);
    S_.resize(rows * rows);
  }

  Outcome decide(const System<double>& system, RankPolicy policy, std::vector<int>& independent) {
    const ClosureDecision& decision = rank_.decide(system, policy);
    independent.clear();
    for (std::size_t k = 0; k < lambda_.size(); ++k)
      if (decision.independent[k]) independent.push_back(static_cast<int>(k));
    return closure_outcome(decision);
  }

  /// False when the rows are not independent in the metric of M̄⁻¹.
  bool factorise(const System<double>& system, const std::vector<double>& inverse,
                 const std::vector<int>& independent) {
    const int n = model_.nv(), r = static_cast<int>(independent.size());
    jacobian_.evaluate(system);
    View G(G_.data(), r, n), Z(Z_.data(), n, r), S(S_.data(), r, r);
    G.setZero();
    for (int i = 0; i < r; ++i)
      for (int p = jacobian_.starts()[independent[i]]; p < jacobian_.starts()[independent[i] + 1]; ++p)
        G(i, jacobian_.columns()[p]) += jacobian_.values()[p];
    if (r == 0) return true;
    Z.noalias() = View(const_cast<double*>(inverse.data()), n, n) * G.transpose();
    S.noalias() = G * Z;
    Eigen::LLT<Eigen::Ref<Matrix>> factor(S);
    if (factor.info() != Eigen::Success) return false;
    S.triangularView<Eigen::Lower>().transpose().solveInPlace<Eigen::OnTheRight>(Z);
    return true;
  }

  /// The largest inverse mass on the diagonal, velocities scaled by the model's length.
  double largest(const std::vector<double>& inverse) const {
    double result = 0;
    for (std::size_t k = 0; k < scale_.size(); ++k) {
      const double scaled = inverse[k * scale_.size() + k] / (scale_[k] * scale_[k]);
      if (!(scaled <= result)) result = scaled;
    }
    return result;
  }

  /// Adds the reactions of the independent rows that do what all of the answer do: λ = L⁻ᵀ Zᵀ Gᵀλ.
  void add_reactions(const Evaluator<double>& evaluator, const System<double>& system, double t,
                     const Solution<double>& solution, const std::vector<int>& independent, PairDerivatives& pairs,
                     InverseDynamicsDerivatives& dynamics) {
    const int n = model_.nv(), r = static_cast<int>(independent.size());
    lambda_ = solution.lambda;
    if (r < static_cast<int>(lambda_.size())) {
      Eigen::Map<Eigen::VectorXd> force(force_.data(), n), chosen(T_.data(), r);
      force.setZero();
      for (int k = 0; k < jacobian_.rows(); ++k)
        for (int p = jacobian_.starts()[k]; p < jacobian_.starts()[k + 1]; ++p)
          force[jacobian_.columns()[p]] += jacobian_.values()[p] * lambda_[k];
      chosen.noalias() = View(Z_.data(), n, r).transpose() * force;
      View(S_.data(), r, r).triangularView<Eigen::Lower>().transpose().solveInPlace(chosen);
      std::fill(lambda_.begin(), lambda_.end(), 0.0);
      for (int k = 0; k < r; ++k) lambda_[independent[k]] = chosen[k];
    }
    std::fill(position_.begin(), position_.end(), 0.0);
    std::fill(velocity_.begin(), velocity_.end(), 0.0);
    pairs.add_closures(evaluator, system, t, solution, lambda_, dynamics, position_, velocity_);
  }

  /// ∂η̇ holds −M̄⁻¹ ∂r.
  void constrain_position(ForwardDerivatives& result) {
    constrain(position_, result.independent, result.position, result.multiplier_position);
  }
  void constrain_velocity(ForwardDerivatives& result) {
    constrain(velocity_, result.independent, result.velocity, result.multiplier_velocity);
  }
  /// ∂η̇ holds M̄⁻¹.
  void constrain_force(ForwardDerivatives& result) {
    const int n = model_.nv(), r = static_cast<int>(result.independent.size());
    Rows T(T_.data(), r, n);
    T = -View(Z_.data(), n, r).transpose();
    finish(T, result.force, result.multiplier_force);
  }

 private:
  /// closure: ∂(G η̇ + γ̿), all rows, column after column.
  void constrain(const std::vector<double>& closure, const std::vector<int>& independent, std::vector<double>& vdot,
                 std::vector<double>& multiplier) {
    const int n = model_.nv(), r = static_cast<int>(independent.size()), rows = static_cast<int>(lambda_.size());
    Rows T(T_.data(), r, n);
    for (int k = 0; k < r; ++k)
      for (int c = 0; c < n; ++c) T(k, c) = -closure[std::size_t(c) * rows + independent[k]];
    T.noalias() -= View(G_.data(), r, n) * Rows(vdot.data(), n, n);
    View(S_.data(), r, r).triangularView<Eigen::Lower>().solveInPlace(T);
    finish(T, vdot, multiplier);
  }

  void finish(Rows& T, std::vector<double>& vdot, std::vector<double>& multiplier) {
    const auto n = T.cols(), r = T.rows();
    Rows(vdot.data(), n, n).noalias() += View(Z_.data(), n, r) * T;
    View(S_.data(), r, r).triangularView<Eigen::Lower>().transpose().solveInPlace(T);
    multiplier.assign(T.data(), T.data() + T.size());
  }

  Model model_;
  ClosureRank<double> rank_;
  ClosureJacobian<double> jacobian_;
  std::vector<double> scale_, lambda_, force_, position_, velocity_, G_, Z_, S_, T_;
};

AnalyticDerivatives::AnalyticDerivatives(const Model& model)
    : model_(model),
      order_(std::make_unique<CoordinateOrder>(model)),
      dynamics_(std::make_unique<InverseDynamicsDerivatives>(model, *order_)),
      mass_inverse_(std::make_unique<MassInverse>(model, *order_)),
      pairs_(std::make_unique<PairDerivatives>(model)),
      loops_(model.has_closures() ? std::make_unique<Loops>(model) : nullptr) {
  const std::size_t n = model.nv(), rows = model.closures().rows();
  for (auto* m : {&result_.position, &result_.velocity, &result_.force}) m->resize(n * n);
  for (auto* m : {&result_.multiplier_position, &result_.multiplier_velocity, &result_.multiplier_force})
    m->reserve(rows * n);
  result_.independent.reserve(rows);
}

AnalyticDerivatives::~AnalyticDerivatives() = default;

Outcome AnalyticDerivatives::at(Evaluator<double>& evaluator, const System<double>& system, const State<double>& state,
                                const Loads<double>& loads, const Solution<double>& solution, RankPolicy policy) {
  const int n = model_.nv();
  Outcome outcome;
  if (loops_) {
    outcome = loops_->decide(system, policy, result_.independent);
    if (!outcome.usable()) return outcome;
  }
  InverseDynamicsDerivatives& d = *dynamics_;
  d.evaluate(evaluator, system, state, loads,
             pairs_->any() ? pairs_->without_pairs(evaluator, system, solution) : solution);
  pairs_->add_springs(evaluator, d);
  mass_inverse_->evaluate(system, result_.force);
  if (loops_ && !loops_->factorise(system, result_.force, result_.independent)) return singular_tree(outcome);
  if (loops_) loops_->add_reactions(evaluator, system, state.t, solution, result_.independent, *pairs_, d);
  const double before = loops_ ? loops_->largest(result_.force) : 0;
  const Rows inverse(result_.force.data(), n, n);
  Rows(result_.position.data(), n, n).noalias() = -inverse * Rows(d.position.data(), n, n);
  Rows(result_.velocity.data(), n, n).noalias() = -inverse * Rows(d.velocity.data(), n, n);
  if (loops_) {
    loops_->constrain_position(result_);
    loops_->constrain_velocity(result_);
    loops_->constrain_force(result_);
    if (outcome.rank < n) outcome.forward_error = rounding * before / loops_->largest(result_.force);
  }
  if (!finite(result_.force)) return singular_tree(outcome);
  if (!finite(result_.position) || !finite(result_.velocity)) {
    outcome.status = Status::not_finite;
    outcome.message = "a force or a closure condition has no derivative here";
  } else if (outcome.forward_error > largest_error) {
    outcome.status = Status::objection;
    outcome.message = fmt::format(
        "the loops hold what the mass matrix of the tree hardly does: of derivatives made by its inverse, errors of "
        "{:.0e} would be left",
        outcome.forward_error);
  }
  return outcome;
}

}  // namespace lanc
