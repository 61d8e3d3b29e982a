#include "lib/closure/explicit.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "lib/closure/retraction.h"
#include "lib/closure/scaling.h"
#include "lib/solve/dense.h"
#include "lib/solve/dense_algebra.h"
#include "lib/system/closure_jacobian.h"
#include "lib/system/equations.h"
#include "lib/system/evaluator.h"

namespace lanc {
namespace {

/// The independent rows of the scaled G.
Eigen::MatrixXd scaled_rows(const System<double>& system, const std::vector<char>& independent) {
  const ClosureScaling scaling(system.model);
  ClosureJacobian<double> jacobian(system.model);
  jacobian.evaluate(system);
  const auto rank = std::count(independent.begin(), independent.end(), char(1));
  Eigen::MatrixXd G = Eigen::MatrixXd::Zero(rank, system.model.nv());
  for (int k = 0, r = 0; k < jacobian.rows(); ++k) {
    if (!independent[k]) continue;
    for (int p = jacobian.starts()[k]; p < jacobian.starts()[k + 1]; ++p) {
      const int c = jacobian.columns()[p];
      G(r, c) = jacobian.values()[p] * scaling.row[k] * scaling.column[c];
    }
    ++r;
  }
  return G;
}

std::vector<int> complement(const std::vector<int>& some, int n) {
  std::vector<int> rest;
  for (int k = 0; k < n; ++k)
    if (!std::binary_search(some.begin(), some.end(), k)) rest.push_back(k);
  return rest;
}

}  // namespace

ExplicitClosures::ExplicitClosures(const Model& model, ExplicitOptions options)
    : model_(model), options_(std::move(options)) {
  std::sort(options_.candidates.begin(), options_.candidates.end());
}

void ExplicitClosures::choose(std::vector<int> independent) {
  std::sort(independent.begin(), independent.end());
  conditions_.independent = std::move(independent);
  chosen_ = true;
}

double ExplicitClosures::condition_of(const Eigen::MatrixXd& G, const std::vector<int>& independent) const {
  if (static_cast<int>(independent.size()) + G.rows() != G.cols()) return std::numeric_limits<double>::infinity();
  if (G.rows() == 0) return 1;
  const Eigen::MatrixXd Gd = chosen_columns(G, complement(independent, model_.nv()));
  const Eigen::VectorXd sigma = singular_values(Gd).sigma;
  const double smallest = sigma[sigma.size() - 1];
  const double largest = std::max(sigma[0], G.rowwise().norm().maxCoeff());
  return smallest > 0 ? largest / smallest : std::numeric_limits<double>::infinity();
}

/// Pivots become dependent: first all that are no candidates, then, in their orthogonal complement, the best others.
std::vector<int> ExplicitClosures::best_choice(const Eigen::MatrixXd& G) const {
  const int nv = model_.nv(), r = static_cast<int>(G.rows());
  std::vector<int> candidates = options_.candidates;
  if (candidates.empty()) candidates = complement({}, nv);
  std::vector<int> dependent = complement(candidates, nv);
  const int more = r - static_cast<int>(dependent.size());
  if (more < 0)
    throw InputError(
        fmt::format("{} velocities are no candidates for independent ones, but only {} can depend on others; name at "
                    "least {} candidates",
                    dependent.size(), r, nv - r));
  Eigen::MatrixXd rest = chosen_columns(G, candidates);
  if (!dependent.empty()) {
    Qr<double> qr;
    qr.compute(chosen_columns(G, dependent));
    rest = transposed_product(qr.Q(), rest).bottomRows(more).eval();
  }
  const std::vector<int> order = pivot_order(rest);
  for (int k = 0; k < more; ++k) dependent.push_back(candidates[order[k]]);
  std::sort(dependent.begin(), dependent.end());
  return complement(dependent, nv);
}

const std::vector<int>& ExplicitClosures::choice(const Eigen::MatrixXd& G, double t) {
  conditions_.condition = chosen_ ? condition_of(G, conditions_.independent) : std::numeric_limits<double>::infinity();
  if (!(conditions_.condition <= options_.leave)) {
    std::vector<int> better = best_choice(G);
    const double condition = condition_of(G, better);
    if (!chosen_ || condition * options_.gain < conditions_.condition) {
      if (chosen_) changes_.push_back({t, conditions_.independent, better, conditions_.condition, condition});
      conditions_.independent = std::move(better);
      conditions_.condition = condition;
      chosen_ = true;
    }
  }
  return conditions_.independent;
}

const ExplicitConditions& ExplicitClosures::at(const System<double>& system, const ClosureDecision& decision) {
  const Eigen::MatrixXd G = scaled_rows(system, decision.independent);
  choice(G, system.state.t);
  const int nv = model_.nv(), f = static_cast<int>(conditions_.independent.size());
  conditions_.dependent = complement(conditions_.independent, nv);

  // γ̄ = ġ at η = 0 is what ġ is more than G η; γ̿ in joint coordinates: at η̇ = 0
  const ClosureScaling scaling(model_);
  ClosureJacobian<double> jacobian(model_);
  jacobian.evaluate(system);
  Solution<double> at_rest(model_);
  bias_accelerations(system, system.rhs, at_rest);
  std::vector<double> gamma;
  closure_accelerations(system, system.rhs, at_rest, gamma);
  Eigen::MatrixXd rhs(G.rows(), f + 2);  // Gⁱ, γ̄, γ̿
  for (int k = 0, r = 0; k < jacobian.rows(); ++k) {
    if (!decision.independent[k]) continue;
    rhs(r, f) = (system.closure_rows[k].rate - jacobian.times(k, system.state.v)) * scaling.row[k];
    rhs(r, f + 1) = (gamma[k] + decision.correction[k]) * scaling.row[k];
    ++r;
  }
  rhs.leftCols(f) = chosen_columns(G, conditions_.independent);
  const Eigen::MatrixXd Gd = chosen_columns(G, conditions_.dependent);
  Eigen::MatrixXd x = Eigen::MatrixXd::Zero(Gd.cols(), f + 2);
  if (Gd.size() > 0) x = -solve_fully_pivoted(Gd, rhs);
  conditions_.J = Eigen::MatrixXd::Zero(nv, f);
  conditions_.eta = conditions_.eta_bias = Eigen::VectorXd::Zero(nv);
  for (int c = 0; c < f; ++c) conditions_.J(conditions_.independent[c], c) = 1;
  for (int d = 0; d < static_cast<int>(conditions_.dependent.size()); ++d) {
    const int k = conditions_.dependent[d];
    for (int c = 0; c < f; ++c)
      conditions_.J(k, c) = x(d, c) * scaling.column[k] / scaling.column[conditions_.independent[c]];
    conditions_.eta[k] = x(d, f) * scaling.column[k];
    conditions_.eta_bias[k] = x(d, f + 1) * scaling.column[k];
  }
  return conditions_;
}

std::optional<State<double>> solve_dependent(const Model& model, State<double> state,
                                             const ExplicitConditions& conditions) {
  constexpr double tolerance = 1e-12;
  constexpr int most_steps = 30;
  const ClosureScaling scaling(model);
  Evaluator<double> evaluator(model);
  const std::vector<char> all(model.closures().rows(), 1);
  double last = std::numeric_limits<double>::infinity();
  for (int step = 0; step <= most_steps; ++step) {
    const System<double>& system = evaluator.system(state);
    Eigen::VectorXd g(model.closures().rows());
    for (int k = 0; k < g.size(); ++k) g[k] = system.closure_rows[k].g * scaling.row[k];
    const double error = g.size() == 0 ? 0 : g.cwiseAbs().maxCoeff();
    // once below the tolerance, as far as rounding allows
    if (!(error < tolerance || step < most_steps)) return std::nullopt;
    if (error == 0 || (error < tolerance && error > last / 2)) return state;
    last = error;
    // all rows: redundant ones agree to first order near a solution, and least squares weighs the rest
    const Eigen::MatrixXd Gd = chosen_columns(scaled_rows(system, all), conditions.dependent);
    const SingularValues svd = singular_values(Gd, SingularVectors::thin);
    const int rank = static_cast<int>(conditions.dependent.size());
    if (!(svd.sigma[rank - 1] > 1e-14 * svd.sigma[0])) return std::nullopt;
    const Eigen::VectorXd move = svd.solve(g, 0);
    std::vector<double> v(model.nv(), 0.0);
    for (int d = 0; d < rank; ++d) v[conditions.dependent[d]] = -move[d] * scaling.column[conditions.dependent[d]];
    state.q = moved(model, state.q, v);
  }
  return std::nullopt;
}

}  // namespace lanc
