// A kernel for batches out of the phases of a tree formulation on packs.
// Private to lib and formulations.
#pragma once

#include <algorithm>
#include <array>

#include "lib/formulation/batch.h"
#include "lib/formulation/judgement.h"
#include "lib/scalar/native_pack.h"
#include "lib/system/evaluator.h"

namespace lanc {

extern template class Evaluator<NativePack>;

/// `Phases` has factorise(system) and substitute(system, rhs, solution) on the pack P, as Recursion<P> does.
template <class Phases, class P>
class PackKernel final : public BatchKernel {
 public:
  explicit PackKernel(const Model& model)
      : model_(model), evaluator_(model), phases_(model), solution_(model), state_{0, {}, {}} {
    state_.q.resize(model.nq()), state_.v.resize(model.nv()), loads_.tau.resize(model.nv());
  }

  int lanes() const override { return P::lanes; }

  void solve(const BatchStates& states, int first, int count, const BatchOptions& options,
             BatchAnswers& answers) override {
    const int nv = model_.nv();
    state_.t = states.t;
    // lanes beyond the last state repeat it
    const auto gather = [&](std::span<const double> from, std::vector<P>& to) {
      const std::size_t size = to.size();
      std::array<const double*, P::lanes> columns;
      for (int lane = 0; lane < P::lanes; ++lane)
        columns[lane] = from.data() + size * (first + std::min(lane, count - 1));
      for (std::size_t k = 0; k < size; ++k) {  // a pack is put together in a register
        P x;
        for (int lane = 0; lane < P::lanes; ++lane) x.set(lane, columns[lane][k]);
        to[k] = x;
      }
    };
    gather(states.q, state_.q), gather(states.v, state_.v);
    if (!states.tau.empty()) gather(states.tau, loads_.tau);
    const System<P>& system = evaluator_.system(state_, states.tau.empty() ? none_ : loads_);
    phases_.factorise(system);
    phases_.substitute(system, system.rhs, solution_);
    const P excess = judgement::first_look(system, solution_);
    for (int lane = 0; lane < count; ++lane) {
      double* vdot = answers.vdot.data() + std::size_t(nv) * (first + lane);
      for (int k = 0; k < nv; ++k) vdot[k] = solution_.vdot[k][lane];
      if (options.all_outputs) scatter(first + lane, lane, answers);
      const bool good = excess[lane] == 0;
      answers.outcome[first + lane] = {good ? Status::solved : Status::not_converged};
    }
  }

 private:
  void scatter(int state, int lane, BatchAnswers& answers) const {
    const auto one = [lane](const Vec3<P>& a) { return Vec3<double>{a.x[lane], a.y[lane], a.z[lane]}; };
    const std::size_t n = model_.bodies();
    for (std::size_t i = 0; i < n; ++i) {
      const auto& [angular, linear] = solution_.acceleration[i];
      const auto& [moment, force] = solution_.wrench[i];
      answers.acceleration[n * state + i] = {one(angular), one(linear)};
      answers.wrench[n * state + i] = {one(moment), one(force)};
    }
  }

  Model model_;
  Evaluator<P> evaluator_;
  Phases phases_;
  Solution<P> solution_;
  State<P> state_;
  Loads<P> loads_;
  const Loads<P> none_{};
};

/// A factory to be put into FormulationInfo.
template <class Phases, class P>
std::unique_ptr<BatchKernel> create_kernel(const Model& model) {
  return std::make_unique<PackKernel<Phases, P>>(model);
}

}  // namespace lanc
