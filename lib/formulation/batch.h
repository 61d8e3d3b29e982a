// Many states of one model at once: several in the lanes of SIMD registers, on all cores.
#pragma once

#include <map>
#include <memory>
#include <span>
#include <vector>

#include "lib/formulation/formulation.h"

namespace lanc {

/// States of one model at one time: state k has q[k·nq .. ), v[k·nv .. ) and, where there are any, τ[k·nv .. ).
struct BatchStates {
  double t = 0;
  std::span<const double> q, v, tau;

  State<double> state(const Model& model, int k) const;
  Loads<double> loads(const Model& model, int k) const;
};

/// Their answers: state k has vdot[k·nv .. ); and, where asked for, accelerations and wrenches of bodies [k·n .. ).
struct BatchAnswers {
  std::vector<double> vdot;
  std::vector<Motion<double>> acceleration;
  std::vector<Wrench<double>> wrench;
  std::vector<Status> status;  // of every state; numbers of one that is not usable() must not be used, but see Outcome
  /// In full, with messages, of the states that were solved one by one, among them all that are not `solved`. Ask by
  /// find() or at().
  std::map<int, Outcome> outcome;
};

struct BatchOptions {
  int threads = 0;           // 0: as many as there are cores
  bool all_outputs = false;  // â and f̂, too
};

/// Solves as many states of an open chain at once as it has lanes. One object per thread.
class BatchKernel {
 public:
  virtual ~BatchKernel() = default;
  virtual int lanes() const = 0;
  /// States first .. first + count − 1, count ≤ lanes. Bit k of what it returns is set where the answer of state
  /// first + k has passed a look like that of Formulation::solve(); the others are to be solved by themselves.
  virtual unsigned solve(const BatchStates& states, int first, int count, const BatchOptions& options,
                         BatchAnswers& answers) = 0;
};

/// Every state gets the answer and the status that Formulation::solve() gives it, to rounding. What a state lacks (a
/// NaN, a singular configuration) concerns no other: states that do not pass the first look of a kernel, and all where
/// loops are closed, inertias are singular or the formulation has no kernel, are solved one by one by
/// Formulation::solve(). A thread allocates what it works with at its first state; states that are solved one by one
/// allocate. A model without velocities has no states.
/// Tested by tests/contract/batch_test.cpp.
class Batch {
 public:
  /// The formulation must be offered for double and have no objection to the model.
  Batch(const Model& model, const FormulationInfo& formulation, BatchOptions options = {});
  ~Batch();

  /// States at once in one kernel; 1 where they are solved one by one.
  int lanes() const;
  /// Throws InputError when sizes are not those of a whole number of states. Euler parameters must be normalised.
  void solve(const BatchStates& states, BatchAnswers& answers);

 private:
  struct Workspace;
  struct Work;
  std::unique_ptr<Work> work_;
};

}  // namespace lanc
