#include "lib/closure/limited_loops.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "lib/closure/components.h"
#include "lib/closure/rank.h"
#include "lib/solve/dense.h"
#include "lib/solve/ipopt.h"

namespace lanc {
namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();
constexpr double softness = 1e-3;     // 1/√ρ
constexpr double near_enough = 1e-9;  // scaled |g| from which Newton steps change nothing that matters
constexpr int most_shifts = 8;
// Positions of a loop up to which second derivatives are computed: with them a Stewart platform (25) takes 14 ms
// instead of 34 with BFGS, a ladder of 20 four-bars (41) 176 instead of 86.
constexpr int most_curved = 32;

Eigen::Index size_of(const std::vector<int>& list) { return static_cast<Eigen::Index>(list.size()); }

}  // namespace

PositionSpace::PositionSpace(const Model& model)
    : scale(model.nq(), 1.0), lower(model.nq(), -infinite), upper(model.nq(), infinite), turn(model.nq()) {
  for (int i = 0; i < model.bodies(); ++i) {
    const Link& link = model.link(i);
    const auto& limits = model.spec().joints[i].limits;
    const int w = link.kind.traits().quaternion;
    for (int k = 0; k < link.nq; ++k) {
      const int c = link.q + k;
      if (w >= 0)
        scale[c] = k < w ? model.length() : 0.5;
      else if (model.column_kind(link.v + k) == ColumnKind::translation)
        scale[c] = model.length();
      else
        turn[c] = model.column_kind(link.v + k) == ColumnKind::rotation;
      if (!limits.empty() && limits[k]) lower[c] = limits[k]->lower, upper[c] = limits[k]->upper;
    }
  }
  for (const Coupler& coupler : model.closures().couplers)  // these count turns
    for (const Coupler::Term& term : coupler.terms) turn[term.q] = false;
}

double PositionSpace::turned(int coordinate, double q) const {
  constexpr double whole = 2 * std::numbers::pi;
  const double low = lower[coordinate], high = upper[coordinate];
  if (!turn[coordinate] || (low <= q && q <= high)) return q;
  const double other = q < low ? q + whole * std::ceil((low - q) / whole) : q - whole * std::ceil((q - high) / whole);
  return low <= other && other <= high ? other : q;
}

LimitedLoops::LimitedLoops(const Model& model, double tolerance)
    : model_(model),
      tolerance_(tolerance),
      scaling_(model),
      space_(model),
      evaluator_(model),
      jacobian_(model),
      local_(model.nq(), -1),
      state_(neutral_state(model)) {
  for (const ClosureComponent& loop : closure_components(jacobian_.starts(), jacobian_.columns(), model.nv())) {
    LimitedPart part;
    part.rows = loop.rows;
    for (std::size_t k = 0; k < loop.columns.size(); ++k) {
      const Link& link = model.link(model.body_of_velocity(loop.columns[k]));
      if (link.kind.traits().rates_are_velocities()) {
        part.positions.push_back(link.q + loop.columns[k] - link.v);
      } else if (k == 0 || model.body_of_velocity(loop.columns[k - 1]) != model.body_of_velocity(loop.columns[k])) {
        part.joints.push_back(model.body_of_velocity(loop.columns[k]));
        part.quaternions.push_back(static_cast<int>(part.positions.size()) + link.kind.traits().quaternion);
        for (int i = 0; i < link.nq; ++i) part.positions.push_back(link.q + i);
      }
    }
    add_part(std::move(part));
  }
  for (int i = 0; i < model.bodies(); ++i) {
    const Link& link = model.link(i);
    const int w = link.kind.traits().quaternion;
    if (w < 0 || link.nq == 0 || local_[link.q] >= 0) continue;
    bool limited = false;
    for (int k = link.q + w; k < link.q + w + 4; ++k)
      limited = limited || space_.lower[k] > -infinite || space_.upper[k] < infinite;
    if (!limited) continue;
    LimitedPart part{{}, {}, {w}, {i}};
    for (int k = 0; k < link.nq; ++k) part.positions.push_back(link.q + k);
    add_part(std::move(part));
  }
}

void LimitedLoops::add_part(LimitedPart part) {
  for (std::size_t k = 0; k < part.positions.size(); ++k) local_[part.positions[k]] = static_cast<int>(k);
  parts_.push_back(std::move(part));
}

/// x into the state to be evaluated, Euler parameters normalised.
void LimitedLoops::put(const LimitedPart& part, const std::vector<double>& x) {
  for (std::size_t k = 0; k < part.positions.size(); ++k)
    state_.q[part.positions[k]] = space_.scale[part.positions[k]] * x[k];
  for (const int w : part.quaternions) {
    double* e = &state_.q[part.positions[w]];
    const double norm = std::hypot(std::hypot(e[0], e[1]), std::hypot(e[2], e[3]));
    for (int k = 0; k < 4; ++k) e[k] /= norm;
  }
}

std::vector<double> LimitedLoops::residual(const State<double>& state) {
  const System<double>& system = evaluator_.system(state);
  std::vector<double> g(jacobian_.rows());
  for (int k = 0; k < jacobian_.rows(); ++k) g[k] = system.closure_rows[k].g * scaling_.row[k];
  return g;
}

double LimitedLoops::extent() {
  double square = 0;
  for (const Vec3<double>& p : evaluator_.positions()) square = std::max(square, dot(p, p));
  return std::max(1.0, std::sqrt(square) / model_.length());
}

/// g of the part's rows, then |e|² − 1 of its Euler parameters.
bool LimitedLoops::residual(const LimitedPart& part, const std::vector<double>& x, Eigen::VectorXd& g) {
  put(part, x);
  const System<double>& system = evaluator_.system(state_);
  g.resize(size_of(part.rows) + size_of(part.quaternions));
  Eigen::Index r = 0;
  for (const int k : part.rows) g[r++] = system.closure_rows[k].g * scaling_.row[k];
  for (const int w : part.quaternions)
    g[r++] = (x[w] * x[w] + x[w + 1] * x[w + 1] + x[w + 2] * x[w + 2] + x[w + 3] * x[w + 3]) / 4 - 1;
  return g.allFinite();
}

/// Derivatives of that, dense.
bool LimitedLoops::jacobian(const LimitedPart& part, const std::vector<double>& x, Eigen::MatrixXd& J) {
  put(part, x);
  jacobian_.evaluate(evaluator_.system(state_));
  J.setZero(size_of(part.rows) + size_of(part.quaternions), size_of(part.positions));
  // velocity c of a joint with Euler parameters: dη = inverse · dx
  std::vector<Eigen::Matrix<double, 6, 7>> inverse(part.joints.size());
  std::vector<int> joint_of_body(model_.bodies(), -1);
  for (std::size_t j = 0; j < part.joints.size(); ++j) {
    const Link& link = model_.link(part.joints[j]);
    joint_of_body[part.joints[j]] = static_cast<int>(j);
    const int w = link.kind.traits().quaternion;
    const double* e = &x[part.quaternions[j]];
    const double norm = std::hypot(std::hypot(e[0], e[1]), std::hypot(e[2], e[3])) / 2;
    for (int c = 0; c < link.nv; ++c) {
      double unit[6] = {}, rate[7];
      unit[c] = 1;
      coordinate_rate(link.kind, state_.q.data() + link.q, unit, rate);
      for (int k = 0; k < link.nq; ++k) inverse[j](c, k) = rate[k] * (k < w ? 1 : 4 / norm) * space_.scale[link.q + k];
    }
  }
  for (Eigen::Index r = 0; r < size_of(part.rows); ++r) {
    const int row = part.rows[r];
    for (int p = jacobian_.starts()[row]; p < jacobian_.starts()[row + 1]; ++p) {
      const int c = jacobian_.columns()[p], body = model_.body_of_velocity(c);
      const Link& link = model_.link(body);
      const double value = jacobian_.values()[p] * scaling_.row[row];
      if (const int j = joint_of_body[body]; j >= 0)
        for (int k = 0; k < link.nq; ++k) J(r, local_[link.q + k]) += value * inverse[j](c - link.v, k);
      else
        J(r, local_[link.q + c - link.v]) += value * space_.scale[link.q + c - link.v];
    }
  }
  for (std::size_t j = 0; j < part.quaternions.size(); ++j)
    for (int k = part.quaternions[j]; k < part.quaternions[j] + 4; ++k)
      J(size_of(part.rows) + static_cast<Eigen::Index>(j), k) = x[k] / 2;
  return J.allFinite();
}

/// Where J can have entries.
std::vector<std::pair<int, int>> LimitedLoops::pattern(const LimitedPart& part) const {
  std::vector<std::pair<int, int>> entries;
  for (std::size_t r = 0; r < part.rows.size(); ++r) {
    int last = -1;
    for (int p = jacobian_.starts()[part.rows[r]]; p < jacobian_.starts()[part.rows[r] + 1]; ++p) {
      const int c = jacobian_.columns()[p], body = model_.body_of_velocity(c);
      const Link& link = model_.link(body);
      if (link.kind.traits().rates_are_velocities())
        entries.emplace_back(r, local_[link.q + c - link.v]);
      else if (body != last)
        for (int k = 0; k < link.nq; ++k) entries.emplace_back(r, local_[link.q + k]);
      last = body;
    }
  }
  for (std::size_t j = 0; j < part.quaternions.size(); ++j)
    for (int k = 0; k < 4; ++k) entries.emplace_back(part.rows.size() + j, part.quaternions[j] + k);
  return entries;
}

/// Lower triangle of Σ multiplier ∇²g by central differences of Jᵀ multiplier: to 1e-10, which costs Ipopt no step.
bool LimitedLoops::curvature(const LimitedPart& part, const std::vector<double>& x, const Eigen::VectorXd& multiplier,
                             std::vector<double>& values) {
  constexpr double h = 1e-5;
  const Eigen::Index n = size_of(part.positions);
  Eigen::MatrixXd H(n, n), J;
  std::vector<double> at = x;
  for (Eigen::Index j = 0; j < n; ++j) {
    at[j] = x[j] + h;
    if (!jacobian(part, at, J)) return false;
    H.col(j) = J.transpose() * multiplier;
    at[j] = x[j] - h;
    if (!jacobian(part, at, J)) return false;
    H.col(j) = (H.col(j) - J.transpose() * multiplier) / (2 * h);
    at[j] = x[j];
  }
  std::size_t entry = 0;
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j <= i; ++j) values[entry++] = (H(i, j) + H(j, i)) / 2;
  return true;
}

/// One part as Ipopt sees it: positions x, then the slacks s.
struct LimitedLoops::Problem {
  LimitedLoops& loops;
  const LimitedPart& part;
  Eigen::Index n, m;
  std::vector<std::pair<int, int>> entries;
  Eigen::VectorXd shift, g;
  Eigen::MatrixXd J;
  LeastDistanceProblem nlp;

  Problem(LimitedLoops& owner, const LimitedPart& of, const std::vector<double>& preferred,
          const std::function<bool()>& interrupted)
      : loops(owner),
        part(of),
        n(size_of(of.positions)),
        m(size_of(of.rows) + size_of(of.quaternions)),
        entries(owner.pattern(of)),
        shift(Eigen::VectorXd::Zero(m)) {
    for (const int k : part.positions) {
      const double scale = loops.space_.scale[k];
      nlp.target.push_back(preferred[k] / scale);
      nlp.lower.push_back(loops.space_.lower[k] / scale);
      nlp.upper.push_back(loops.space_.upper[k] / scale);
    }
    nlp.target.resize(n + m, 0.0);
    nlp.lower.resize(n + m, -infinite);
    nlp.upper.resize(n + m, infinite);
    nlp.weight.assign(n + m, 1.0);
    nlp.conditions = static_cast<int>(m);
    nlp.curved = static_cast<int>(n);
    nlp.interrupted = interrupted;
    set_pattern();
    set_functions();
  }

  void set_pattern() {
    for (const auto& entry : entries) nlp.rows.push_back(entry.first), nlp.columns.push_back(entry.second);
    for (Eigen::Index r = 0; r < m; ++r)
      nlp.rows.push_back(static_cast<int>(r)), nlp.columns.push_back(static_cast<int>(n + r));
  }

  void set_functions() {
    nlp.residual = [this](const std::vector<double>& x, std::vector<double>& values) {
      if (!loops.residual(part, x, g)) return false;
      for (Eigen::Index r = 0; r < m; ++r) values[r] = g[r] + shift[r] - softness * x[n + r];
      return true;
    };
    nlp.jacobian = [this](const std::vector<double>& x, std::vector<double>& values) {
      if (!loops.jacobian(part, x, J)) return false;
      for (std::size_t k = 0; k < entries.size(); ++k) values[k] = J(entries[k].first, entries[k].second);
      std::fill(values.begin() + static_cast<std::ptrdiff_t>(entries.size()), values.end(), -softness);
      return true;
    };
    if (n > most_curved) return;
    nlp.curvature = [this](const std::vector<double>& x, const std::vector<double>& multiplier,
                           std::vector<double>& values) {
      return loops.curvature(part, x, Eigen::Map<const Eigen::VectorXd>(multiplier.data(), m), values);
    };
  }
};

LimitedAttempt LimitedLoops::run(int index, const State<double>& state, const std::vector<double>& preferred,
                                 const std::function<bool()>& interrupted) {
  const LimitedPart& part = parts_[index];
  state_ = state;
  LimitedAttempt attempt;
  Problem problem(*this, part, preferred, interrupted);
  std::vector<double> x(problem.n + problem.m, 0.0);
  for (Eigen::Index k = 0; k < problem.n; ++k) x[k] = state.q[part.positions[k]] / space_.scale[part.positions[k]];
  std::vector<bool> fixed(problem.n);
  if (!is_answer(part, x, problem.nlp.target)) fixed = seek(problem, x, attempt);
  for (Eigen::Index k = 0; k < problem.n; ++k) attempt.q.push_back(x[k] * space_.scale[part.positions[k]]);
  polish(part, preferred, std::move(fixed), attempt);
  return attempt;
}

/// Whether x is what is preferred, and closed.
bool LimitedLoops::is_answer(const LimitedPart& part, const std::vector<double>& x,
                             const std::vector<double>& preferred) {
  Eigen::VectorXd g;
  if (!std::equal(preferred.begin(), preferred.begin() + size_of(part.positions), x.begin())) return false;
  return residual(part, x, g) && (g.size() == 0 || g.lpNorm<Eigen::Infinity>() <= tolerance_ * extent());
}

/// The method of multipliers; x: from the start to the end. Which coordinates a limit holds.
std::vector<bool> LimitedLoops::seek(Problem& problem, std::vector<double>& x, LimitedAttempt& attempt) {
  std::vector<bool> held(problem.n);
  double last = infinite;
  for (int pass = 0; pass < most_shifts; ++pass) {
    const LeastDistanceResult result = solve_least_distance(problem.nlp, x);
    attempt.steps += result.steps;
    if (result.status == LeastDistanceStatus::interrupted) attempt.end = LimitedEnd::interrupted;
    if (result.status == LeastDistanceStatus::not_finite) attempt.end = LimitedEnd::not_finite;
    x = result.x;
    for (Eigen::Index k = 0; k < problem.n; ++k)  // the force is larger than the way to the limit
      held[k] =
          result.lower_force[k] > x[k] - problem.nlp.lower[k] || result.upper_force[k] > problem.nlp.upper[k] - x[k];
    if (attempt.end != LimitedEnd::open || !residual(problem.part, x, problem.g)) break;
    const double largest = problem.m > 0 ? problem.g.lpNorm<Eigen::Infinity>() : 0;
    if (largest <= near_enough || !(largest <= last / 2)) break;
    last = largest;
    problem.shift += problem.g;
  }
  return held;
}

/// Newton steps of least norm in the coordinates that are not fixed at a limit; those that would leave theirs become
/// so.
void LimitedLoops::polish(const LimitedPart& part, const std::vector<double>& preferred, std::vector<bool> fixed,
                          LimitedAttempt& attempt) {
  constexpr double rounding = 2 * std::numeric_limits<double>::epsilon();
  constexpr double longest = 0.1;  // beyond it a Newton step leads anywhere
  constexpr int most_steps = 50;
  const Eigen::Index n = size_of(part.positions);
  std::vector<double>& q = attempt.q;
  bool met = true;  // a limit, in the last step
  const auto hold = [&](Eigen::Index k) {
    const double low = space_.lower[part.positions[k]], high = space_.upper[part.positions[k]];
    if (!fixed[k] && low < q[k] && q[k] < high) return;
    fixed[k] = met = true;
    q[k] = q[k] - low < high - q[k] ? low : high;
  };
  for (Eigen::Index k = 0; k < n; ++k) hold(k);
  std::vector<double> x(n), best_q = q;
  Eigen::VectorXd c;
  Eigen::MatrixXd J;
  double best = infinite;
  for (int step = 0; step < most_steps; ++step) {
    for (Eigen::Index k = 0; k < n; ++k) x[k] = q[k] / space_.scale[part.positions[k]];
    if (!residual(part, x, c)) break;
    const double largest = c.size() > 0 ? c.lpNorm<Eigen::Infinity>() : 0;
    if (!(largest <= best / 2) && !met) {
      if (largest < best) best = largest, best_q = q;
      break;
    }
    best = largest, best_q = q;
    std::vector<Eigen::Index> free;
    for (Eigen::Index k = 0; k < n; ++k)
      if (!fixed[k]) free.push_back(k);
    if (largest <= rounding * extent() || free.empty() || !jacobian(part, x, J)) break;
    const Eigen::MatrixXd G = J(Eigen::all, free);
    const double size = G.colwise().norm().maxCoeff();
    if (size == 0) break;
    const Eigen::VectorXd change = least_squares(G, -c, zero_singular_value * std::max(1.0, 1 / size));
    if (!(change.lpNorm<Eigen::Infinity>() <= longest)) break;
    met = false;
    for (std::size_t k = 0; k < free.size(); ++k) {
      q[free[k]] += change[static_cast<Eigen::Index>(k)] * space_.scale[part.positions[free[k]]];
      hold(free[k]);
    }
  }
  q = best_q;
  attempt.violation = best;
  for (Eigen::Index k = 0; k < n; ++k) {
    const int coordinate = part.positions[k];
    const double d = (q[k] - preferred[coordinate]) / space_.scale[coordinate];
    attempt.distance = std::hypot(attempt.distance, d);
    if (q[k] <= space_.lower[coordinate] || q[k] >= space_.upper[coordinate]) attempt.at_limit.push_back(coordinate);
  }
  if (attempt.end == LimitedEnd::open && best <= tolerance_ * extent()) attempt.end = LimitedEnd::closed;
}

}  // namespace lanc
