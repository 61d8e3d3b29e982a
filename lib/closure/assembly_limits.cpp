#include "lib/closure/assembly_limits.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "lib/closure/alignment.h"
#include "lib/closure/assembly_report.h"
#include "lib/closure/limited_loops.h"
#include "lib/closure/loop_search.h"
#include "lib/closure/retraction.h"
#include "lib/solve/ipopt.h"

namespace lanc {
namespace {

/// What became of one part over all its starts.
struct StartRecord {
  LimitedAttempt best;
  bool flipped = false;
  int starts = 0, start = 0;  // how many, and which was best

  bool closed() const { return best.end == LimitedEnd::closed && !flipped; }
};

std::vector<ReachedLimit> limits_met(const PositionSpace& space, const std::vector<double>& q,
                                     const std::vector<int>& coordinates) {
  std::vector<ReachedLimit> list;
  for (const int k : coordinates) {
    if (q[k] <= space.lower[k]) list.push_back({k, false, space.lower[k], q[k]});
    if (q[k] >= space.upper[k] && space.upper[k] > space.lower[k]) list.push_back({k, true, space.upper[k], q[k]});
  }
  return list;
}

class LimitedAssembler {
 public:
  LimitedAssembler(const Model& model, State<double> given, const LimitedAssemblyOptions& options)
      : model_(model),
        options_(options),
        loops_(model, options.tolerance),
        search_(model, options.tolerance, 200),
        given_(std::move(given)),
        state_(given_),
        random_(options.seed) {
    if (!options.preferred.empty()) state_.q = options.preferred;
    state_ = checked_state(model, std::move(state_));
    for (int k = 0; k < model.nq(); ++k) state_.q[k] = space().turned(k, state_.q[k]);
    preferred_ = state_.q;
    std::vector<bool> on_part(model.nq());
    for (const LimitedPart& part : loops_.parts())
      for (const int k : part.positions) on_part[k] = true;
    for (int k = 0; k < model.nq(); ++k)
      if (!on_part[k]) state_.q[k] = std::clamp(state_.q[k], space().lower[k], space().upper[k]);
  }

  LimitedAssemblyResult run() {
    LimitedAssemblyResult result;
    for (int part = 0; part < static_cast<int>(loops_.parts().size()); ++part) {
      records_.push_back(close(part));
      put(part, records_.back().best.q);
      result.starts = std::max(result.starts, records_.back().start + 1);
      if (records_.back().best.end == LimitedEnd::interrupted) break;
    }
    report(result);
    return result;
  }

 private:
  const PositionSpace& space() const { return loops_.space(); }

  void put(int part, const std::vector<double>& q) {
    const std::vector<int>& where = loops_.parts()[part].positions;
    for (std::size_t k = 0; k < where.size(); ++k) state_.q[where[k]] = q[k];
  }

  StartRecord close(int part) {
    StartRecord record;
    const int starts = loops_.parts()[part].rows.empty() ? 1 : std::max(1, options_.starts);
    for (int start = 0; start < starts && !(record.closed() && start >= options_.compared); ++start) {
      put(part, start_of(part, start));
      const LimitedAttempt attempt = loops_.run(part, state_, preferred_, options_.interrupted);
      put(part, attempt.q);
      const bool flipped = attempt.end == LimitedEnd::closed && is_flipped(part);
      ++record.starts;
      if (start == 0 || is_better(attempt, flipped, record))
        record.best = attempt, record.flipped = flipped, record.start = start;
      if (attempt.end == LimitedEnd::interrupted || attempt.end == LimitedEnd::not_finite) {
        if (!record.closed()) record.best.end = attempt.end;
        break;
      }
      if (record.closed() && record.best.distance == 0) break;
    }
    return record;
  }

  static bool is_better(const LimitedAttempt& attempt, bool flipped, const StartRecord& record) {
    constexpr double rounding = 1e-7;  // the same place again is not nearer
    if (attempt.end == LimitedEnd::closed && !flipped)
      return !record.closed() || attempt.distance < record.best.distance * (1 - rounding);
    return !record.closed() && !flipped && (record.flipped || attempt.violation < record.best.violation);
  }

  /// Positions of a part, within limits.
  std::vector<double> start_of(int part, int start) {
    const LimitedPart& which = loops_.parts()[part];
    State<double> state = state_;
    state.q = start > 1 ? departed(which, start) : preferred_;
    if (start > 0) search_.run(state, {part});
    for (std::size_t j = 0; j < which.quaternions.size(); ++j) {  // of e and −e the one that is nearer
      double* e = &state.q[which.positions[which.quaternions[j]]];
      const double* wanted = &preferred_[which.positions[which.quaternions[j]]];
      double product = 0;
      for (int k = 0; k < 4; ++k) product += e[k] * wanted[k];
      for (int k = 0; k < 4 && product < 0; ++k) e[k] = -e[k];
    }
    std::vector<double> q;
    for (const int k : which.positions)
      q.push_back(std::clamp(space().turned(k, state.q[k]), space().lower[k], space().upper[k]));
    return q;
  }

  std::vector<double> departed(const LimitedPart& part, int start) {
    constexpr int pieces = 8;  // so that ball joints, which a single step turns by less than half a turn, go anywhere
    double part_of_turn = 0, half = 0.5;  // 1/2, 1/4, 3/4, 1/8, ...: large and small ones alternate
    for (int k = start - 1; k > 0; k /= 2, half /= 2) part_of_turn += half * (k % 2);
    const double reach = std::numbers::pi * part_of_turn / pieces;
    const ClosureScaling scaling(model_);
    std::vector<double> change(model_.nv(), 0.0), q = preferred_;
    std::vector<bool> moves(model_.nq());
    for (const int k : part.positions) moves[k] = true;
    for (int k = 0; k < model_.nv(); ++k) {
      const Link& link = model_.link(model_.body_of_velocity(k));
      const int position = link.kind.traits().rates_are_velocities() ? link.q + k - link.v : link.q;
      const double unit = static_cast<double>(random_() >> 11) * 0x1p-53;
      if (moves[position]) change[k] = reach * (2 * unit - 1) * scaling.column[k];
    }
    for (int piece = 0; piece < pieces; ++piece) q = moved(model_, q, change);
    return q;
  }

  bool is_flipped(int part) {
    loops_.residual(state_);
    const std::vector<int>& rows = loops_.parts()[part].rows;
    for (const int c : flipped_closures(model_, state_.t, loops_.evaluator(), loops_.evaluator().positions()))
      if (const Closure& closure = model_.closures().closures[c];
          closure.conditions().count > 0 && std::binary_search(rows.begin(), rows.end(), closure.row))
        return true;
    return false;
  }

  void report(LimitedAssemblyResult& result) {
    const std::vector<double> g = loops_.residual(state_);
    for (const double x : g) result.violation = std::max(result.violation, std::isnan(x) ? x : std::abs(x));
    const AssemblyReport words(model_, options_.tolerance);
    result.gaps = words.gaps(g);
    words.measure_move(given_.q, state_.q, result);
    std::vector<int> all(model_.nq());
    for (int k = 0; k < model_.nq(); ++k) {
      all[k] = k;
      result.distance = std::hypot(result.distance, (state_.q[k] - preferred_[k]) / space().scale[k]);
    }
    result.reached = limits_met(space(), state_.q, all);
    explain(words, g, result);
    result.state = std::move(state_);
  }

  /// Status and message, from the part that is worst.
  void explain(const AssemblyReport& words, const std::vector<double>& g, LimitedAssemblyResult& result) const {
    int worst = -1, count = 0;
    for (int i = 0; i < static_cast<int>(records_.size()); ++i) {
      if (records_[i].closed()) continue;
      ++count;
      if (worst < 0 || !(records_[i].best.violation <= records_[worst].best.violation)) worst = i;
    }
    if (worst < 0) return;
    const LimitedPart& part = loops_.parts()[worst];
    const StartRecord& record = records_[worst];
    if (record.best.end == LimitedEnd::interrupted) {
      result.status = AssemblyStatus::interrupted;
      result.message = "interrupted";
      return;
    }
    if (part.rows.empty()) {
      result.status = AssemblyStatus::beyond_limits;
      result.message = fmt::format("the limits of the Euler parameters of joint '{}' leave no orientation",
                                   model_.spec().joints[part.joints[0]].name);
      return;
    }
    const std::string open = words.open_rows(part.rows, g);
    const std::vector<ReachedLimit> met = limits_met(space(), state_.q, part.positions);
    const AssemblyResult without = assemble(model_, given_, {.tolerance = options_.tolerance, .seed = options_.seed});
    result.message = fmt::format("{} within the limits of joints, the least of {} starts; {}",
                                 record.flipped ? "closes the wrong way round" : open, record.starts,
                                 met.empty() ? "no limit is reached" : "reached: " + to_text(model_, met));
    if (count > 1) result.message += fmt::format(" ({} loops more stay open)", count - 1);
    if (without.assembled()) {
      result.status = AssemblyStatus::beyond_limits;
      const std::vector<ReachedLimit> violated = violated_limits(model_, without.state.q);
      result.message +=
          fmt::format("; without limits it closes{}", violated.empty() ? "" : ", with " + to_text(model_, violated));
    } else {
      result.status = without.status;
      result.message += fmt::format("; nor does it close without limits: {}", without.message);
    }
  }

  const Model& model_;
  const LimitedAssemblyOptions& options_;
  LimitedLoops loops_;
  LoopSearch search_;
  State<double> given_, state_;
  std::vector<double> preferred_;
  std::vector<StartRecord> records_;
  std::mt19937_64 random_;  // its numbers, unlike those of distributions, are the same everywhere
};

}  // namespace

LimitedAssemblyResult assemble_within_limits(const Model& model, State<double> state,
                                             const LimitedAssemblyOptions& options) {
  if (!has_ipopt())
    throw InputError(
        "assembly within the limits of joints needs Ipopt, without which this was built; install it (Debian: "
        "coinor-libipopt-dev) and configure with -DLANC_WITH_IPOPT=ON");
  return LimitedAssembler(model, std::move(state), options).run();
}

std::vector<ReachedLimit> violated_limits(const Model& model, const std::vector<double>& q) {
  const PositionSpace space(model);
  std::vector<ReachedLimit> list;
  for (int k = 0; k < model.nq(); ++k) {
    if (q[k] < space.lower[k]) list.push_back({k, false, space.lower[k], q[k]});
    if (q[k] > space.upper[k]) list.push_back({k, true, space.upper[k], q[k]});
  }
  return list;
}

std::string to_text(const Model& model, const std::vector<ReachedLimit>& limits) {
  const std::vector<std::string> names = model.position_names();
  std::vector<std::string_view> units(model.nq());
  for (const Link& link : model.links())
    for (int k = 0; k < link.nq; ++k) units[link.q + k] = link.kind.traits().q_units[k];
  std::string text;
  for (const ReachedLimit& limit : limits) {
    const double beyond = limit.upper ? limit.value - limit.limit : limit.limit - limit.value;
    const std::string_view unit = units[limit.coordinate];
    text += fmt::format("{}'{}' {} its {} limit {:.6g} {}", text.empty() ? "" : ", ", names[limit.coordinate],
                        beyond > 0 ? fmt::format("{:.3g} {} beyond", beyond, unit) : "at",
                        limit.upper ? "upper" : "lower", limit.limit, unit);
  }
  return text;
}

}  // namespace lanc
