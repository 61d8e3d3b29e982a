#include <memory>

#include "formulations/recursive-loops/loop_substitution.h"
#include "lib/formulation/formulation.h"

namespace lanc {
namespace {

/// Which rows of closures depend on others is seen by their pivots, loop by loop. Where that is another number than
/// lib/closure/rank.h finds (near singular configurations, or far off the manifold), its independent rows are taken;
/// and where one of those has no pivot in its turn, closures go after all bodies.
template <class S>
class RecursiveLoops final : public Formulation<S> {
 public:
  explicit RecursiveLoops(const Model& model) : Formulation<S>(model), by_path_(model), substitution_(model) {}

  void assemble(const System<S>&) override {}

  Outcome factorise(const System<S>& system) override {
    present_ = &by_path_;
    if (!this->model().has_closures()) {
      by_path_.factorise(system);
      return {};
    }
    const ClosureDecision& decision = this->closures();
    if (by_path_.factorise(system) && by_path_.dropped() == decision.redundant) return {};
    if (by_path_.factorise(system, decision.independent)) return {};
    const Model& model = this->model();
    constexpr std::size_t most_closures = 200;  // every body meets every closure
    if (model.closures().closures.size() + model.closures().couplers.size() <= most_closures) {
      if (!bodies_first_) bodies_first_ = std::make_unique<LoopFactors<S>>(model, EliminationRule::bodies_first);
      present_ = bodies_first_.get();
      if (present_->factorise(system, decision.independent)) return {};
    }
    return {Status::objection,
            "the mass matrix of the tree that is left without its loops is singular or not positive definite, and this "
            "formulation divides by it; take one that does not, such as dense, nullspace or eq14-umfpack"};
  }

  void substitute(const System<S>& system, const RightHandSide<S>& rhs, Solution<S>& solution) override {
    substitution_.solve(*present_, system, rhs, solution);
  }

 private:
  LoopFactors<S> by_path_;
  std::unique_ptr<LoopFactors<S>> bodies_first_;  // made when needed
  LoopFactors<S>* present_ = nullptr;             // of the last factorisation
  LoopSubstitution<S> substitution_;
};

const Registration registration(
    {.name = "recursive-loops",
     .idea = "eq. 18 with closures: block elimination on the graph of bodies and closures, closed loops in linear time",
     .source = "lecture, eq. 18; Featherstone 1983; the order of closures and the dropping of rows are this project's",
     .recursive = true,
     .create_double = create<RecursiveLoops<double>, double>,
     .create_long_double = create<RecursiveLoops<long double>, long double>,
     .create_count = create<RecursiveLoops<Count>, Count>});

}  // namespace
}  // namespace lanc
