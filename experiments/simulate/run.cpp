#include "experiments/simulate/run.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "lib/model/error.h"
#include "lib/report/sidecar.h"
#include "lib/report/timing.h"

namespace lanc {
namespace {

std::string state_name(const std::string& csv) { return std::filesystem::path(csv).replace_extension(".state.json"); }

/// FNV-1a of a file's bytes, so that another model of the same name is seen; empty for a generator.
std::string contents_hash(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) return {};
  std::uint64_t hash = 14695981039346656037u;
  for (std::istreambuf_iterator<char> byte(in), end; byte != end; ++byte)
    hash = (hash ^ static_cast<unsigned char>(*byte)) * 1099511628211u;
  return fmt::format("{:016x}", hash);
}

class Run {
 public:
  Run(const StateInput& input, const RunOptions& options)
      : input_(input),
        options_(options),
        simulation_(input.model, with_loads(options.simulation, input.loads)),
        quantities_(input.model, options.quantities),
        conditions_(read_conditions(options.stop_when)),
        progress_("simulate", options.quiet),
        report_({"simulate", input.out, sidecar("simulate", input.command_line, resume_options(), std::nullopt),
                 options.resume}) {}

  StateOutput go() {
    Outcome outcome = begin();
    const double start = input_.state.t, length = options_.end - start;
    const auto rows = static_cast<std::int64_t>(std::ceil(length / options_.interval - 1e-9));
    progress_.start(rows);
    if (outcome.usable()) outcome = write_instant();
    std::int64_t row = 0;
    if (began()) row = rows_done();
    if (began() && row == 0) last_ = simulation_.renew();
    if (outcome.usable()) stop_at_start();
    while (outcome.usable() && row < rows && !met_) {
      progress_.advance(row, fmt::format("t = {:.6g} s", simulation_.t()));
      ++row;
      outcome = advance(row == rows ? options_.end : start + row * options_.interval);
      if (!outcome.usable()) break;
      if (row % options_.checkpoint_every == 0 || row == rows) checkpoint();
    }
    progress_.clear();
    write_end(outcome);
    report_.finish();
    return {summary(outcome), outcome.usable() ? 0 : 1};
  }

 private:
  /// Names are looked up now, before a file is touched.
  std::vector<StopCondition> read_conditions(const std::vector<std::string>& texts) {
    std::vector<StopCondition> list;
    Instant any;
    any.point.state = input_.state;
    any.solution = Solution<double>(input_.model);
    for (const std::string& text : texts) {
      list.push_back(read_stop_condition(text));
      (void)list.back().distance(quantities_.at(any));
    }
    return list;
  }

  static SimulationOptions with_loads(SimulationOptions options, const Loads<double>& loads) {
    options.loads = loads;
    return options;
  }

  /// All that is in the command line but --out, --quiet and --resume, and the state it came to.
  std::vector<std::pair<std::string, std::string>> resume_options() const {
    const auto text = [](const auto& numbers) { return fmt::format("{}", fmt::join(numbers, " ")); };
    std::string points;
    for (const TracedPoint& p : options_.quantities.points)
      points += fmt::format("{}={}:{},{},{} ", p.name, p.body, p.offset.x, p.offset.y, p.offset.z);
    const QuantityChoice& q = options_.quantities;
    return {{"model", input_.argument},
            {"t", fmt::format("{}", input_.state.t)},
            {"q", text(input_.state.q)},
            {"v", text(input_.state.v)},
            {"tau", text(input_.loads.tau)},
            {"wrenches", wrenches()},
            {"model_file", contents_hash(input_.argument)},
            {"formulation", options_.simulation.formulation},
            {"parameters", options_.parameters},
            {"baumgarte-time", fmt::format("{}", options_.simulation.baumgarte_time)},
            {"spectral-radius", fmt::format("{}", options_.simulation.spectral_radius)},
            {"end", fmt::format("{}", options_.end)},
            {"interval", fmt::format("{}", options_.interval)},
            {"checkpoint-every", std::to_string(options_.checkpoint_every)},
            {"candidates", text(options_.simulation.candidates)},
            {"points", points},
            {"quantities",
             fmt::format("{}{}{}{}", int(q.accelerations), int(q.reactions), int(q.multipliers), int(q.bodies))},
            {"stop-when", fmt::format("{}", fmt::join(options_.stop_when, " "))}};
  }

  std::string wrenches() const {
    std::string text;
    for (const auto& w : input_.loads.wrenches)
      text += fmt::format("{}={},{},{},{},{},{} ", w.body, w.wrench.moment.x, w.wrench.moment.y, w.wrench.moment.z,
                          w.wrench.force.x, w.wrench.force.y, w.wrench.force.z);
    return text;
  }

  Outcome begin() {
    if (options_.resume)
      if (const auto checkpoint = read_checkpoint(input_.out, input_.model)) return resume(*checkpoint);
    return simulation_.begin(input_.state);
  }

  /// The row before the checkpoint must be there: the last one may have been dropped as incomplete.
  Outcome resume(const Checkpoint& checkpoint) {
    const double start = input_.state.t, t = checkpoint.point.state.t;
    const std::int64_t row = std::llround((t - start) / options_.interval);
    const bool on_the_way = t >= start && t <= options_.end;
    if (!on_the_way || (row > 0 && !report_.has(cell(start + static_cast<double>(row - 1) * options_.interval))))
      throw InputError(fmt::format("{} does not belong to {}, which ends before it; run without --resume",
                                   checkpoint_name(input_.out), input_.out));
    return simulation_.resume(last_ = checkpoint);
  }

  std::int64_t rows_done() const { return std::llround((simulation_.t() - input_.state.t) / options_.interval); }

  Cell cell(double t, const std::string& event = {}) const {
    Cell cell;
    cell.model = input_.argument;
    cell.bodies = input_.model.bodies(), cell.velocities = input_.model.nv();
    cell.closure_rows = input_.model.closures().rows();
    cell.formulation = options_.simulation.formulation;
    cell.parameters = fmt::format("t={};{}{}", t, options_.parameters, event.empty() ? "" : ";event=" + event);
    return cell;
  }

  Outcome advance(double limit) {
    while (simulation_.t() < limit) {
      const double before = simulation_.t();
      if (Outcome outcome = simulation_.step(limit); !outcome.usable()) return outcome;
      if (before < simulation_.t() && find_stop()) return write_instant();
    }
    return write_instant();
  }

  /// The condition that is met first in the step that was taken; goes back to where it is.
  bool find_stop() {
    std::vector<const StopCondition*> met;
    for (const StopCondition& condition : conditions_)
      if (condition.distance(quantities_.at(simulation_.instant())) >= 0) met.push_back(&condition);
    if (met.empty()) return false;
    write_changes();
    write_branches();
    const double end = simulation_.t();
    double first = end;
    for (const StopCondition* condition : met) {
      locate(*condition, last_, end, simulation_, quantities_);
      if (!met_ || simulation_.t() < first) met_ = condition, first = simulation_.t();
    }
    locate(*met_, last_, end, simulation_, quantities_);
    return true;
  }

  void stop_at_start() {
    for (const StopCondition& condition : conditions_)
      if (!met_ && condition.distance(quantities_.at(simulation_.instant())) >= 0) met_ = &condition;
  }

  Outcome write_instant() {
    write_changes();
    write_branches();
    const Instant now = simulation_.instant();
    drift_ = std::max(drift_, std::abs(now.energy_drift));
    violation_ = std::max(violation_, now.position_violation);
    const Cell where = cell(now.point.state.t);
    if (!report_.has(where)) {
      std::vector<Measurement> measurements;
      for (const Quantity& q : quantities_.at(now))
        measurements.push_back({"total", q.name, q.value, q.unit, std::string(to_string(now.outcome.status))});
      report_.write(where, measurements);
    }
    return now.outcome;
  }

  void write_changes() {
    const auto names = input_.model.velocity_names();
    const auto list = [&](const std::vector<int>& some) {
      std::string text;
      for (const int k : some) text += (text.empty() ? "" : " ") + names[k];
      return text;
    };
    for (; told_ < simulation_.changes().size(); ++told_, ++changes_) {
      const IndependentChange& change = simulation_.changes()[told_];
      const Cell where = cell(change.t, fmt::format("choice;from={};to={}", list(change.before), list(change.after)));
      const Measurement conditions[] = {{"total", "choice_condition_before", change.condition_before, "1"},
                                        {"total", "choice_condition_after", change.condition_after, "1"}};
      if (!report_.has(where)) report_.write(where, conditions);
    }
  }

  void write_branches() {
    for (; told_branches_ < simulation_.branch_changes().size(); ++told_branches_) {
      const BranchChange& change = simulation_.branch_changes()[told_branches_];
      const Cell where = cell(change.t, fmt::format("branch;choice={}", change.choice));
      const Measurement facts[] = {{"total", "branches", static_cast<double>(change.branches), "1"},
                                   {"total", "energy_change", change.energy_change, "J"}};
      if (!report_.has(where)) report_.write(where, facts);
    }
  }

  void checkpoint() {
    last_ = simulation_.renew();
    told_ = 0;
    if (input_.out != "-") write_checkpoint(input_.out, last_);
  }

  void write_end(const Outcome& outcome) {
    if (!outcome.usable() && input_.out != "-") {
      const State<double> state = began() ? simulation_.point().state : input_.state;
      const nlohmann::ordered_json document = {{"t", state.t}, {"q", state.q}, {"v", state.v}};
      replace_file(state_name(input_.out), document.dump(1) + "\n");
    }
    if (!began()) return;
    write_changes();
    write_branches();
    const StepperCounts steps = simulation_.steps();
    const MotionCounts evaluations = simulation_.evaluations();
    const auto count = [&](const char* what, long value) {
      return Measurement{"total", what, static_cast<double>(value), "1", std::string(to_string(outcome.status))};
    };
    const Measurement list[] = {count("steps", steps.steps),
                                count("rejected_steps", steps.rejected),
                                count("newton_iterations", steps.newton_iterations),
                                count("evaluations", evaluations.rates),
                                count("jacobians", evaluations.jacobians),
                                count("kinematics", evaluations.kinematics),
                                count("dual_kinematics", evaluations.dual_kinematics)};
    const Cell where = cell(simulation_.t(), "end");
    if (!report_.has(where)) report_.write(where, list);
  }

  bool began() const { return simulation_.begun(); }

  std::string summary(const Outcome& outcome) const {
    std::string text;
    if (!outcome.usable())
      text += fmt::format("ended: {}: {}\n", to_string(outcome.status), outcome.message);
    else if (met_)
      text += fmt::format("stopped at t = {:.12g} s: {}\n", simulation_.t(), met_->text);
    if (!began()) return text;
    const StepperCounts steps = simulation_.steps();
    const MotionCounts evaluations = simulation_.evaluations();
    text += fmt::format("t = {:.9g} s after {} steps ({} rejected), {} evaluations, {} Jacobians\n", simulation_.t(),
                        steps.steps, steps.rejected, evaluations.rates, evaluations.jacobians);
    text += fmt::format(
        "largest energy drift {:.3g} J (beyond the work of drives, loads, dampers and friction: {:.6g} J "
        "at the end)\n",
        drift_, simulation_.point().work);
    if (input_.model.has_closures())
      text +=
          fmt::format("rank {} of {} closure conditions held; largest violation {:.2g} (model lengths, radians){}\n",
                      simulation_.held_rank(), input_.model.closures().rows(), violation_,
                      changes_ > 0 ? fmt::format("; independent velocities changed {} times", changes_) : "");
    return text;
  }

  const StateInput& input_;
  const RunOptions& options_;
  Simulation simulation_;
  Quantities quantities_;
  std::vector<StopCondition> conditions_;
  Progress progress_;
  Report report_;
  const StopCondition* met_ = nullptr;
  Checkpoint last_;
  std::size_t told_ = 0, told_branches_ = 0;
  int changes_ = 0;
  double drift_ = 0, violation_ = 0;
};

}  // namespace

StateOutput run(const StateInput& input, const RunOptions& options) {
  // before the CSV is begun: a checkpoint of another run must not be taken for one of this
  std::error_code none;
  if (options.resume && input.out == "-") throw InputError("--resume needs a file, --out FILE");
  if (!options.resume && input.out != "-") std::filesystem::remove(checkpoint_name(input.out), none);
  if (input.out != "-") std::filesystem::remove(state_name(input.out), none);
  return Run(input, options).go();
}

}  // namespace lanc
