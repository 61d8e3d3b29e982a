#include "lib/closure/explicit_walk.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "lib/closure/retraction.h"
#include "lib/closure/scaling.h"
#include "lib/system/evaluator.h"

namespace lanc {

ExplicitWalk::ExplicitWalk(const Model& model, const State<double>& start, ExplicitOptions options,
                           const Eigen::VectorXd& towards)
    : model_(model), closures_(model, std::move(options)), state_(start) {
  const auto conditions = conditions_at(state_, closures_);
  if (!conditions)
    throw InputError(
        fmt::format("a walk needs a mechanism with one freedom; the {} velocities of this one are not 1 more than its "
                    "independent closure conditions at the start",
                    model.nv()));
  conditions_ = *conditions;
  tangent_ = tangent_of(conditions_);
  if (towards.size() > 0 && tangent_.dot(towards) < 0) tangent_ = -tangent_;
}

std::optional<ExplicitConditions> ExplicitWalk::conditions_at(const State<double>& state,
                                                              ExplicitClosures& closures) const {
  Evaluator<double> evaluator(model_);
  ClosureRank<double> rank(model_);
  const System<double>& system = evaluator.system(state);
  const ClosureDecision& decision = rank.decide(system);
  if (decision.rank != model_.nv() - 1) return std::nullopt;
  return closures.at(system, decision);
}

Eigen::VectorXd ExplicitWalk::tangent_of(const ExplicitConditions& conditions) const {
  const ClosureScaling scaling(model_);
  Eigen::VectorXd tangent = conditions.J.col(0);
  for (int k = 0; k < model_.nv(); ++k) tangent[k] /= scaling.column[k];
  return tangent.normalized();
}

/// Between neighbouring positions, as scaled velocities measure it.
double ExplicitWalk::distance(const State<double>& a, const State<double>& b) const {
  const ClosureScaling scaling(model_);
  double sum = 0;
  for (const Link& link : model_.links()) {
    const int w = link.kind.traits().quaternion;
    for (int k = 0; k < link.nq; ++k) {
      double change = b.q[link.q + k] - a.q[link.q + k];
      if (w < 0)
        change /= scaling.column[link.v + k];
      else
        change *= k >= w ? 2 : 1 / model_.length();  // Euler parameters change by half the angle
      sum += change * change;
    }
  }
  return std::sqrt(sum);
}

bool ExplicitWalk::step(double h) {
  constexpr double farthest = 0.3;  // of the step, from where the tangent leads
  constexpr double turn = 0.8;      // cosine: a larger one is another branch, or the way back
  const ClosureScaling scaling(model_);
  std::vector<double> v(model_.nv());
  for (int k = 0; k < model_.nv(); ++k) v[k] = h * tangent_[k] * scaling.column[k];
  State<double> predicted = state_;
  predicted.q = moved(model_, state_.q, v);
  const auto next = solve_dependent(model_, predicted, conditions_);
  if (!next || distance(predicted, *next) > farthest * h) return false;

  // with the choice kept, the independent coordinate goes on in its direction: beyond a limit point the others go back
  ExplicitClosures kept(model_, {.candidates = {}, .leave = std::numeric_limits<double>::infinity()});
  kept.choose(conditions_.independent);
  const auto same = conditions_at(*next, kept);
  if (!same) return false;
  Eigen::VectorXd tangent = tangent_of(*same);
  if ((tangent[independent()] < 0) != (tangent_[independent()] < 0)) tangent = -tangent;
  if (!(tangent.dot(tangent_) > turn)) return false;

  const auto conditions = conditions_at(*next, closures_);
  arc_ += distance(state_, *next);
  state_ = *next;
  conditions_ = *conditions;
  tangent_ = tangent_of(conditions_);
  if (tangent_.dot(tangent) < 0) tangent_ = -tangent_;
  if (closures_.changes().size() > changes_.size()) changes_.push_back({arc_, state_, closures_.changes().back()});
  return true;
}

bool ExplicitWalk::advance(double h) {
  constexpr int most_halvings = 30;  // towards a limit point the way left is what counts, not h
  for (int k = 0; k <= most_halvings; ++k, h /= 2)
    if (step(h)) return true;
  return false;
}

}  // namespace lanc
