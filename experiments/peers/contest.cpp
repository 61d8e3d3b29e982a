#include "experiments/peers/contest.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <list>
#include <memory>
#include <optional>

#include "experiments/peers/peer.h"
#include "experiments/peers/plan.h"
#include "experiments/peers/verdict.h"
#include "lib/model/error.h"
#include "lib/report/phases.h"
#include "lib/system/equations.h"

namespace lanc::peers {
namespace {

constexpr double nothing = std::numeric_limits<double>::quiet_NaN();
constexpr double slow = 0.05;  // s: what takes longer is timed in the first repetitions only
constexpr int slow_repetitions = 3;

/// One side: what it answered, and how to time it once it has been found right.
struct Contestant {
  std::string name;
  Task task = Task::forward;
  std::string status = std::string(to_string(Status::solved));
  std::vector<double> answer;
  bool soft = false;
  std::function<std::vector<Measurement>()> repetition;  // the rows of one repetition, `total` last
  double seconds = 0;                                    // of the last one
};

/// Kinematics and inverse dynamics by eq. 8 and 3.
struct OurInverse {
  State<double> state;
  Evaluator<double> evaluator;
  Solution<double> solution;
  std::vector<double> tau;
  Repeat repeat;

  OurInverse(const Mechanism& m, const std::vector<double>& vdot)
      : state(m.state), evaluator(m.model), solution(m.model), tau(m.model.nv()) {
    solution.vdot = vdot;
    call();
  }
  void call() { lanc::inverse_dynamics(evaluator.system(state), solution, tau); }
};

/// The mechanism without friction, damping, joint springs and armature, which peers model each in their own way.
Mechanism bare(const Mechanism& mechanism) {
  ModelSpec spec = mechanism.model.spec();
  for (JointSpec& joint : spec.joints) joint.coordinates.clear();
  return {Model::build(std::move(spec)), mechanism.state};
}

std::vector<Measurement> total(double seconds) { return {{"total", "time", seconds, "s"}}; }

class Contest {
 public:
  Contest(Experiment& experiment, const std::string& argument)
      : experiment_(experiment), name_(short_name(argument)), mechanism_(experiment.load(argument)) {
    const Model& given = mechanism_.model;
    if (!given.passive().empty() || given.has_armature()) {
      say("friction, damping, joint springs and armature are left out, on all sides");
      mechanism_ = bare(mechanism_);
    }
    for (int k = 0; k < mechanism_.model.nv(); ++k) vdot_.push_back(std::sin(1.0 + k));  // any will do
  }

  const std::string& name() const { return name_; }
  /// The CSV that is continued has this model.
  bool done() const {
    const auto has = [&](std::string_view name, Task task) { return experiment_.report().has(cell(name, task)); };
    for (const FormulationInfo* info : experiment_.formulations())
      if (!has(info->name, Task::forward)) return false;
    if (ours_alone(mechanism_.model)) return true;
    for (const MandatoryPeer& peer : mandatory_peers())
      if (!has(peer.name, peer.task)) return false;
    for (const PeerInfo& peer : registered_peers())
      if (!has(peer.name, peer.task)) return false;
    return true;
  }
  void compare() {
    add_ours();
    add_peers();
    for (Contestant& c : contestants_) judge(c);
    take_up();
  }
  void time(int r) {
    for (Contestant& c : contestants_)
      if (c.repetition && (c.seconds < slow || r < slow_repetitions)) time(c, r);
  }
  /// Last: done() asks for it.
  void summarise() {
    for (const Contestant& c : contestants_) summarise(c);
  }

 private:
  void say(const std::string& text) { experiment_.progress().say(fmt::format("{}: {}", name_, text)); }

  Cell cell(std::string_view name, Task task, std::optional<int> repetition = std::nullopt) const {
    return experiment_.cell(name_, mechanism_.model, std::string(name), parameters(task), repetition);
  }
  void write(const Cell& cell, const std::vector<Measurement>& rows) {
    if (!experiment_.report().has(cell)) experiment_.report().write(cell, rows);
  }

  void add_ours() {
    for (const FormulationInfo* info : experiment_.formulations()) {
      Contestant& c = contestants_.emplace_back();
      c.name = info->name;
      if (const auto reason = info->objection(mechanism_.model)) {
        c.status = to_string(Status::objection);
        say(fmt::format("{}: {}", info->name, *reason));
        continue;
      }
      const auto timer =
          std::make_shared<PhaseTimer>(info->create_double, mechanism_.model, mechanism_.state,
                                       held_rank(info->create_double, mechanism_.model, mechanism_.state));
      c.status = to_string(timer->outcome().status);
      if (!timer->outcome().usable()) {
        say(fmt::format("{}: {} {}", info->name, c.status, timer->outcome().message));
        continue;
      }
      c.answer = timer->solution().vdot;
      if (forward_.empty()) forward_ = c.answer;
      c.repetition = [timer] { return timer->repetition(); };
    }
    if (forward_.empty()) throw InputError(fmt::format("{}: none of the chosen formulations solves it", name_));
    if (mechanism_.model.has_closures()) return;
    const auto own = std::make_shared<OurInverse>(mechanism_, vdot_);
    Contestant& c = contestants_.emplace_back();
    c.name = our_inverse;
    c.task = Task::inverse;
    c.answer = inverse_ = own->tau;
    c.repetition = [own] {
      own->call();
      return total(own->repeat.seconds([&] { own->call(); }));
    };
  }

  void add_peers() {
    if (ours_alone(mechanism_.model)) return;
    for (const PeerInfo& info : registered_peers()) {
      Contestant& c = contestants_.emplace_back();
      c.name = info.name;
      c.task = info.task;
      c.soft = info.soft_loops && mechanism_.model.has_closures();
      try {
        if (c.task == Task::inverse && mechanism_.model.has_closures())
          throw InputError("inverse dynamics is asked of open mechanisms only");
        const std::shared_ptr<PeerModel> peer = info.build(mechanism_, vdot_);
        c.answer = peer->answer();
        c.repetition = [peer, repeat = std::make_shared<Repeat>()] {
          peer->call();  // the caches hold what the side before left there
          return total(repeat->seconds([&] { peer->call(); }));
        };
      } catch (const std::exception& error) {  // of the peer, too
        c.status = to_string(Status::objection);
        say(fmt::format("{} ({}): {}", c.name, to_string(c.task), error.what()));
      }
    }
    for (const MandatoryPeer& peer : mandatory_peers()) {
      const auto own = [&](const Contestant& c) { return c.name == peer.name && c.task == peer.task; };
      if (std::any_of(contestants_.begin(), contestants_.end(), own)) continue;
      Contestant& c = contestants_.emplace_back();
      c.name = peer.name;
      c.task = peer.task;
      c.status = missing;
    }
  }

  const std::vector<double>& expected(Task task) const { return task == Task::forward ? forward_ : inverse_; }

  /// Who solved another problem is not timed.
  void judge(Contestant& c) {
    if (c.answer.empty()) return;
    const double apart = difference(c.answer, expected(c.task));
    if (same(apart, c.soft)) return;
    c.status = different;
    c.repetition = nullptr;
    say(fmt::format("{} ({}) differs from us by {:.1e} of the largest value, more than {:.0e}: not timed", c.name,
                    to_string(c.task), apart, c.soft ? same_if_soft : same_answer));
  }

  /// Of a run that is continued: who was slow there.
  void take_up() {
    for (const Row& row : experiment_.report().rows())
      if (row.cell.model == name_ && row.cell.repetition && row.measurement.phase == "total")
        for (Contestant& c : contestants_)
          if (row.cell.formulation == c.name && row.cell.parameters == parameters(c.task))
            c.seconds = row.measurement.value;
  }

  void time(Contestant& c, int r) {
    if (experiment_.report().has(cell(c.name, c.task, r))) return;
    experiment_.progress().advance(0, fmt::format("{} {}", name_, c.name));
    std::vector<Measurement> rows = c.repetition();
    c.seconds = rows.back().value;
    for (Measurement& row : rows) row.status = c.status;
    write(cell(c.name, c.task, r), rows);
  }

  void summarise(const Contestant& c) {
    std::vector<Measurement> rows = {
        {"total", "difference", c.answer.empty() ? nothing : difference(c.answer, expected(c.task)), "1", c.status}};
    const std::vector<double> exact = closed_form(name_, mechanism_.model, mechanism_.state);
    if (!exact.empty() && c.task == Task::forward)
      rows.push_back({"total", "error", c.answer.empty() ? nothing : difference(c.answer, exact), "1", c.status});
    write(cell(c.name, c.task), rows);
  }

  Experiment& experiment_;
  std::string name_;
  Mechanism mechanism_;
  std::vector<double> vdot_, forward_, inverse_;  // given, and our answers
  std::vector<Contestant> contestants_;
};

}  // namespace

void contest(Experiment& experiment, const std::vector<std::string>& models) {
  Progress& progress = experiment.progress();
  const int repetitions = experiment.options().repetitions;
  progress.start(static_cast<std::int64_t>(models.size()) * (1 + repetitions));
  std::list<Contest> contests;
  for (const std::string& model : models) {
    Contest& c = contests.emplace_back(experiment, model);
    if (c.done()) {
      progress.advance(1 + repetitions, c.name(), true);
      contests.pop_back();
      continue;
    }
    c.compare();
    progress.advance(1, c.name());
  }
  for (int r = 0; r < repetitions; ++r)
    for (Contest& c : contests) {
      c.time(r);
      progress.advance(1, c.name());
    }
  for (Contest& c : contests) c.summarise();
  progress.clear();
}

}  // namespace lanc::peers
