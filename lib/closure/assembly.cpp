#include "lib/closure/assembly.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "lib/closure/alignment.h"
#include "lib/closure/assembly_report.h"
#include "lib/closure/loop_search.h"
#include "lib/closure/retraction.h"

namespace lanc {
namespace {

/// What became of one loop over all its starts.
struct Record {
  bool closed = false;
  int stationary = 0, flipped = 0, not_finite = 0, starts = 0;
  double best = std::numeric_limits<double>::infinity();  // |g|, scaled
  std::vector<double> positions;                          // of the best
};

class Assembler {
 public:
  Assembler(const Model& model, State<double> guess, const AssemblyOptions& options)
      : model_(model),
        options_(options),
        scaling_(model),
        words_(model, options.tolerance),
        search_(model, options.tolerance, options.steps),
        guess_(std::move(guess)),
        state_(guess_),
        records_(search_.loops().size()),
        loop_of_row_(model.closures().rows()),
        random_(options.seed) {
    for (int i = 0; i < static_cast<int>(search_.loops().size()); ++i)
      for (const int k : search_.loops()[i].part.rows) loop_of_row_[k] = i;
  }

  AssemblyResult run() {
    AssemblyResult result;
    std::vector<int> open(search_.loops().size());
    for (int i = 0; i < static_cast<int>(open.size()); ++i) open[i] = i;
    for (int start = 0; start < std::max(1, options_.starts) && !open.empty(); ++start) {
      if (start > 0) depart(open, start);
      search_.run(state_, open);
      record(open);
      std::erase_if(open, [&](int i) { return records_[i].closed || records_[i].not_finite > 0; });
      result.starts = start + 1;
    }
    for (int i = 0; i < static_cast<int>(records_.size()); ++i)
      if (!records_[i].closed) restore(search_.loops()[i].positions, records_[i].positions);
    search_.evaluate(state_);
    report(result);
    return result;
  }

 private:
  /// Moves the loops that are open away from the guess, the farther the more often that was tried.
  void depart(const std::vector<int>& open, int start) {
    constexpr int parts = 8;  // so that ball joints, which a single step turns by less than half a turn, go anywhere
    const double reach = std::numbers::pi * start / std::max(1, options_.starts - 1) / parts;
    std::vector<double> change(model_.nv(), 0.0);
    for (const int i : open)
      for (const int k : search_.loops()[i].part.columns) {
        const double unit = static_cast<double>(random_() >> 11) * 0x1p-53;
        change[k] = reach * (2 * unit - 1) * scaling_.column[k];
      }
    std::vector<double> q = guess_.q;
    for (int part = 0; part < parts; ++part) q = moved(model_, q, change);
    for (const int i : open)
      for (const int k : search_.loops()[i].positions) state_.q[k] = q[k];
  }

  void record(const std::vector<int>& open) {
    search_.evaluate(state_);
    std::vector<bool> flipped(records_.size());
    for (const int c : flipped_closures(model_, state_.t, search_.evaluator(), search_.evaluator().positions()))
      if (const Closure& closure = model_.closures().closures[c]; closure.conditions().count > 0)
        flipped[loop_of_row_[closure.row]] = true;
    for (const int i : open) {
      const Loop& loop = search_.loops()[i];
      Record& record = records_[i];
      ++record.starts;
      if (loop.end == LoopEnd::closed && !flipped[i]) record.closed = true;
      if (loop.end == LoopEnd::closed && flipped[i]) ++record.flipped;
      if (loop.end == LoopEnd::stationary) ++record.stationary;
      if (loop.end == LoopEnd::not_finite) ++record.not_finite;
      // a flipped loop is nearer to nothing than one that is open
      const double size = flipped[i] ? 1e3 + loop.g.norm() : loop.g.norm();
      if (record.closed || size < record.best || record.positions.empty()) {
        record.best = size;
        record.positions.clear();
        for (const int k : loop.positions) record.positions.push_back(state_.q[k]);
      }
    }
  }

  void restore(const std::vector<int>& where, const std::vector<double>& values) {
    for (std::size_t k = 0; k < where.size(); ++k) state_.q[where[k]] = values[k];
  }

  void report(AssemblyResult& result) {
    std::vector<double> g(model_.closures().rows());
    for (const Loop& loop : search_.loops()) {
      for (std::size_t r = 0; r < loop.part.rows.size(); ++r)
        g[loop.part.rows[r]] = loop.g[static_cast<Eigen::Index>(r)];
      result.violation = std::max(result.violation, loop.largest());
    }
    result.gaps = words_.gaps(g);
    words_.measure_move(guess_.q, state_.q, result);
    explain(g, result);
    result.state = std::move(state_);
  }

  /// Status and message, from the loop that is worst.
  void explain(const std::vector<double>& g, AssemblyResult& result) const {
    int worst = -1, count = 0;
    for (int i = 0; i < static_cast<int>(records_.size()); ++i) {
      if (records_[i].closed) continue;
      ++count;
      if (worst < 0 || records_[i].not_finite > 0 || records_[i].best > records_[worst].best) worst = i;
      if (records_[i].not_finite > 0) break;
    }
    if (worst < 0) return;
    const Record& record = records_[worst];
    const std::string starts = record.starts == 1 ? "the start" : fmt::format("all {} starts", record.starts);
    std::string why;
    if (record.not_finite > 0) {
      result.status = AssemblyStatus::not_finite;
      result.message =
          fmt::format("the loop of {} cannot be evaluated at t = {}: a prescribed motion is not defined there",
                      names_of_rows(worst, g), guess_.t);
      return;
    }
    if (record.flipped > 0) {
      result.status = AssemblyStatus::flipped;
      why = fmt::format(
          "it closes the wrong way round only ({} of {} starts): axes antiparallel that should be "
          "parallel, or a screw half a turn out of its thread; turn a frame, or give another state",
          record.flipped, record.starts);
    } else if (record.stationary == record.starts) {
      result.status = AssemblyStatus::infeasible;
      why = fmt::format(
          "from {} the gap ends in a minimum that is not zero: the dimensions look as if this loop "
          "cannot be assembled",
          starts);
    } else {
      result.status = AssemblyStatus::bad_start;
      why =
          fmt::format("{} of {} starts ended in a minimum of the gap, the others nowhere: give a state that is nearer",
                      record.stationary, record.starts);
    }
    result.message = fmt::format("{}: {}{}", names_of_rows(worst, g), why,
                                 count > 1 ? fmt::format(" ({} loops more stay open)", count - 1) : "");
  }

  std::string names_of_rows(int loop, const std::vector<double>& g) const {
    return words_.open_rows(search_.loops()[loop].part.rows, g);
  }

  const Model& model_;
  const AssemblyOptions& options_;
  ClosureScaling scaling_;
  AssemblyReport words_;
  LoopSearch search_;
  State<double> guess_, state_;
  std::vector<Record> records_;
  std::vector<int> loop_of_row_;
  std::mt19937_64 random_;  // its numbers, unlike those of distributions, are the same everywhere
};

}  // namespace

AssemblyResult assemble(const Model& model, State<double> state, const AssemblyOptions& options) {
  return Assembler(model, std::move(state), options).run();
}

}  // namespace lanc
