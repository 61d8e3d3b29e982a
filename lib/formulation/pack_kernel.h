// A kernel for batches out of the phases of a tree formulation on packs.
// Private to lib and formulations.
#pragma once

#include <algorithm>
#include <array>

#include "lib/formulation/batch.h"
#include "lib/formulation/momentum_balance.h"
#include "lib/scalar/native_pack.h"
#include "lib/system/evaluator.h"

namespace lanc {

extern template class Evaluator<NativePack>;

/// `Phases` has on the pack P, as Recursion<P> does: solve(system, solution) for η̇ and â, factorise(system) and
/// substitute(system, rhs, solution) for all.
template <class Phases, class P>
class PackKernel final : public BatchKernel {
 public:
  explicit PackKernel(const Model& model)
      : model_(model),
        evaluator_(model),
        phases_(model),
        solution_(model),
        state_{0, {}, {}},
        ahead_(model.bodies()),
        balance_(model) {
    state_.q.resize(model.nq()), state_.v.resize(model.nv()), loads_.tau.resize(model.nv());
  }

  int lanes() const override { return P::lanes; }

  unsigned solve(const BatchStates& states, int first, int count, const BatchOptions& options,
                 BatchAnswers& answers) override {
    state_.t = states.t;
    gather(states.q, first, count, state_.q), gather(states.v, first, count, state_.v);
    if (!states.tau.empty()) gather(states.tau, first, count, loads_.tau);
    call_for_next_states(states, first, answers);
    const System<P>& system = evaluator_.system(state_, states.tau.empty() ? none_ : loads_, &ahead_);
    const P excess = solved(system, options.all_outputs);
    scatter(solution_.vdot, first, count, answers.vdot);
    static_assert(P::lanes <= 32);  // bits of what is returned
    unsigned good = 0;
    for (int lane = 0; lane < count; ++lane) {
      if (options.all_outputs) scatter_bodies(first + lane, lane, answers);
      good |= unsigned{excess[lane] == 0} << lane;
    }
    return good;
  }

 private:
  using Rows = std::array<P, P::lanes>;

  /// Fills solution_; 0 where the answer has passed a look. The quick one is by the momentum balance; a pack that does
  /// not pass it gets the look of Formulation::solve(), at the answer that goes with that.
  P solved(const System<P>& system, bool all_outputs) {
    phases_.solve(system, solution_);
    const P excess = balance_.look(system, solution_, all_outputs);
    if (vanishes(excess)) return excess;
    phases_.factorise(system);
    phases_.substitute(system, system.rhs, solution_);
    return judgement::first_look(system, solution_);
  }

  void call_for_next_states(const BatchStates& states, int first, const BatchAnswers& answers) {
    const std::ptrdiff_t next = first + P::lanes, nq = model_.nq(), nv = model_.nv();
    ahead_.clear();
    ahead_.add(states.q, nq * next, nq * P::lanes);
    for (const std::span<const double> numbers : {states.v, states.tau, std::span<const double>(answers.vdot)})
      ahead_.add(numbers, nv * next, nv * P::lanes);
  }
  /// Numbers of `count` states side by side; lanes beyond the last state repeat it. A square of numbers at a time; what
  /// is left over number by number.
  static void gather(std::span<const double> from, int first, int count, std::vector<P>& to) {
    const int size = static_cast<int>(to.size());
    const auto numbers = [&](int lane) {
      return from.data() + std::ptrdiff_t{size} * (first + std::min(lane, count - 1));
    };
    int k = 0;
    for (; k + P::lanes <= size; k += P::lanes) {
      Rows rows;
      for (int lane = 0; lane < P::lanes; ++lane) rows[lane] = P::load(numbers(lane) + k);
      transpose(rows);
      std::copy(rows.begin(), rows.end(), to.begin() + k);
    }
    for (; k < size; ++k) {  // put together in a register
      P pack;
      for (int lane = 0; lane < P::lanes; ++lane) pack.set(lane, numbers(lane)[k]);
      to[k] = pack;
    }
  }
  static void scatter(const std::vector<P>& from, int first, int count, std::vector<double>& to) {
    const int size = static_cast<int>(from.size());
    const auto numbers = [&](int lane) { return to.data() + std::ptrdiff_t{size} * (first + lane); };
    int k = 0;
    for (; k + P::lanes <= size; k += P::lanes) {
      Rows rows;
      std::copy(from.begin() + k, from.begin() + k + P::lanes, rows.begin());
      transpose(rows);
      for (int lane = 0; lane < count; ++lane) rows[lane].store(numbers(lane) + k);
    }
    for (; k < size; ++k)
      for (int lane = 0; lane < count; ++lane) numbers(lane)[k] = from[k][lane];
  }
  void scatter_bodies(int state, int lane, BatchAnswers& answers) const {
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
  Prefetch ahead_;
  MomentumBalance<P> balance_;
};

/// A factory to be put into FormulationInfo.
template <class Phases, class P>
std::unique_ptr<BatchKernel> create_kernel(const Model& model) {
  return std::make_unique<PackKernel<Phases, P>>(model);
}

}  // namespace lanc
