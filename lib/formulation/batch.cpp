#include "lib/formulation/batch.h"

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <mutex>

#include "lib/model/error.h"
#include "lib/system/evaluator.h"

namespace lanc {

State<double> BatchStates::state(const Model& model, int k) const {
  const auto part = [k](std::span<const double> all, int size) {
    return std::vector<double>(all.begin() + std::ptrdiff_t{k} * size, all.begin() + std::ptrdiff_t{k + 1} * size);
  };
  return {t, part(q, model.nq()), part(v, model.nv())};
}

Loads<double> BatchStates::loads(const Model& model, int k) const {
  if (tau.empty()) return {};
  return {{tau.begin() + std::ptrdiff_t{k} * model.nv(), tau.begin() + std::ptrdiff_t{k + 1} * model.nv()}, {}};
}

/// What a thread works with.
struct Batch::Workspace {
  std::unique_ptr<BatchKernel> kernel;
  Evaluator<double> evaluator;
  std::unique_ptr<Formulation<double>> formulation;
  Solution<double> solution;

  Workspace(const Model& model, const FormulationInfo& info, bool in_packs)
      : kernel(in_packs ? info.create_kernel(model) : nullptr),
        evaluator(model),
        formulation(info.create_double(model)),
        solution(model) {}

  /// One state by itself, with all that Formulation::solve() looks at.
  Outcome solve(const Model& model, const BatchStates& states, int k, bool all_outputs, BatchAnswers& answers) {
    const System<double>& system = evaluator.system(states.state(model, k), states.loads(model, k));
    Outcome outcome = formulation->solve(system, solution);
    answers.status[k] = outcome.status;
    const std::ptrdiff_t nv = model.nv(), n = model.bodies();
    std::copy(solution.vdot.begin(), solution.vdot.end(), answers.vdot.begin() + k * nv);
    if (!all_outputs) return outcome;
    std::copy(solution.acceleration.begin(), solution.acceleration.end(), answers.acceleration.begin() + k * n);
    std::copy(solution.wrench.begin(), solution.wrench.end(), answers.wrench.begin() + k * n);
    return outcome;
  }
};

struct Batch::Work {
  Model model;
  BatchOptions options;
  bool in_packs;
  tbb::task_arena arena;
  tbb::enumerable_thread_specific<Workspace> workspaces;

  Work(const Model& m, const FormulationInfo& info, BatchOptions o)
      : model(m),
        options(o),
        in_packs(info.create_kernel && !m.has_closures() && !m.has_singular_inertia()),
        arena(o.threads > 0 ? o.threads : tbb::task_arena::automatic),
        workspaces([m, info, packs = in_packs] { return Workspace(m, info, packs); }) {}

  void solve(const BatchStates& states, int first, int count, BatchAnswers& answers, std::mutex& outcomes) {
    Workspace& own = workspaces.local();
    const unsigned good = in_packs ? own.kernel->solve(states, first, count, options, answers) : 0;
    for (int k = 0; k < count; ++k) {
      if (good >> k & 1) {
        answers.status[first + k] = Status::solved;
        continue;
      }
      Outcome outcome = own.solve(model, states, first + k, options.all_outputs, answers);
      const std::lock_guard lock(outcomes);
      answers.outcome.emplace(first + k, std::move(outcome));
    }
  }

  void solve_all(const BatchStates& states, int count, BatchAnswers& answers) {
    const int lanes = in_packs ? workspaces.local().kernel->lanes() : 1, packs = (count + lanes - 1) / lanes;
    std::mutex outcomes;
    const auto some = [&](int first_pack, int last_pack) {
      for (int p = first_pack; p < last_pack; ++p)
        solve(states, p * lanes, std::min(lanes, count - p * lanes), answers, outcomes);
    };
    if (options.threads == 1) return some(0, packs);
    arena.execute([&] {
      tbb::parallel_for(tbb::blocked_range<int>(0, packs),
                        [&](const auto& range) { some(range.begin(), range.end()); });
    });
  }
};

Batch::Batch(const Model& model, const FormulationInfo& formulation, BatchOptions options)
    : work_(std::make_unique<Work>(model, formulation, options)) {}

Batch::~Batch() = default;

int Batch::lanes() const { return work_->in_packs ? work_->workspaces.local().kernel->lanes() : 1; }

void Batch::solve(const BatchStates& states, BatchAnswers& answers) {
  const Model& model = work_->model;
  const std::size_t nq = model.nq(), nv = model.nv(), n = model.bodies();
  const std::size_t count = nv == 0 ? 0 : states.v.size() / nv;
  if (states.v.size() != count * nv || states.q.size() != count * nq ||
      (!states.tau.empty() && states.tau.size() != count * nv))
    throw InputError(
        fmt::format("a batch has {} positions, {} velocities and {} torques; each state of this model has {} positions "
                    "and {} velocities (torques: as many, or none)",
                    states.q.size(), states.v.size(), states.tau.size(), nq, nv));
  answers.vdot.resize(count * nv);
  answers.status.assign(count, Status::not_converged);
  answers.outcome.clear();
  answers.acceleration.resize(work_->options.all_outputs ? count * n : 0);
  answers.wrench.resize(work_->options.all_outputs ? count * n : 0);
  work_->solve_all(states, static_cast<int>(count), answers);
}

}  // namespace lanc
