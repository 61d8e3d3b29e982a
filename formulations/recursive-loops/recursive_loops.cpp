#include <memory>

#include "formulations/recursive-loops/loop_elimination.h"
#include "formulations/recursive-loops/quasi_definite.h"
#include "lib/formulation/formulation.h"

namespace lanc {
namespace {

/// Operations of the block elimination that take the time of an unknown of the quasi-definite matrix, and of one of its
/// operations (measured).
constexpr double per_unknown = 500, per_operation = 2;

/// Eq. 18 with closures where bodies before closures fill little; else eq. 14 as a sparse quasi-definite matrix.
///
/// Which rows of closures depend on others is seen by their pivots, loop by loop. Where that is another number than
/// lib/closure/rank.h finds (near singular configurations, or far off the manifold), its independent rows are taken;
/// and where one of those has no pivot in its turn, closures go after all bodies.
template <class S>
class RecursiveLoops final : public Formulation<S> {
 public:
  explicit RecursiveLoops(const Model& model) : Formulation<S>(model) {
    EliminationPlan plan = plan_for<S>(model, EliminationRule::path, most_operations(model));
    const double operations = plan.operations;
    if (operations <= most_operations(model)) by_path_ = make_loop_elimination<S>(model, std::move(plan));
    if constexpr (std::is_same_v<S, double>) {
      if (!may_be_sparse(model) || operations <= per_unknown * unknowns(model)) return;
      sparse_ = std::make_unique<QuasiDefinite>(model);
      if (operations > per_unknown * unknowns(model) + per_operation * sparse_->statistics().factorise_flops)
        by_path_.reset();
      else
        sparse_.reset();
    }
  }

  void assemble(const System<S>&) override {}

  Outcome factorise(const System<S>& system) override {
    if (!this->model().has_closures()) {
      present_ = by_path_.get();
      by_path_->factorise(system);
      return {};
    }
    if (!by_path_ && !sparse_)
      return {
          Status::objection,
          "leaf first the loops of this model fill beyond 1e9 operations, and the sparse matrix that would do takes "
          "bodies with regular inertia only, and double"};
    const ClosureDecision& decision = this->closures();
    if constexpr (std::is_same_v<S, double>)
      if (sparse_ && sparse_->factorise(system, decision.independent)) {
        present_ = nullptr;
        return {};
      }
    if (by_path_) {
      present_ = by_path_.get();
      const bool regular = present_->factorise(system);
      if (regular && (decision.by_pivots || present_->dropped() == decision.redundant)) return {};
    }
    if (!decision.by_pivots && factorise_independent(system)) return {};
    return {Status::objection,
            "the mass matrix of the tree that is left without its loops is singular or not positive definite, and this "
            "formulation divides by it; take one that does not, such as dense, nullspace or eq14-umfpack"};
  }

  void substitute(const System<S>& system, const RightHandSide<S>& rhs, Solution<S>& solution) override {
    if (present_) return present_->solve(system, rhs, solution);
    if constexpr (std::is_same_v<S, double>) sparse_->substitute(system, rhs, solution);
  }

  int dropped_rows() const override { return by_path_ && !sparse_ ? by_path_->dropped() : -1; }

  /// Of the sparse matrix, where it is taken.
  std::optional<LibraryStatistics> statistics() const override {
    if (!sparse_) return std::nullopt;
    const FactorStatistics s = sparse_->statistics();
    return LibraryStatistics{.unknowns = sparse_->unknowns(),
                             .matrix_nonzeros = sparse_->nonzeros(),
                             .factor_nonzeros = s.nonzeros,
                             .bytes = s.bytes,
                             .factorise_flops = s.factorise_flops,
                             .solve_flops = s.solve_flops};
  }

 private:
  bool factorise_independent(const System<S>& system) {
    const std::vector<char>& independent = this->closures().independent;
    if (by_path_ && by_path_->factorise(system, independent)) return true;
    const ClosureSet& set = this->model().closures();
    constexpr std::size_t most = 200;  // every body meets every closure
    if (set.closures.size() + set.couplers.size() > most) return false;
    if (!bodies_first_)
      bodies_first_ =
          make_loop_elimination<S>(this->model(), plan_for<S>(this->model(), EliminationRule::bodies_first));
    present_ = bodies_first_.get();
    return present_->factorise(system, independent);
  }
  static double unknowns(const Model& model) { return 12.0 * model.bodies() + model.nv() + model.closures().rows(); }
  static bool may_be_sparse(const Model& model) {
    return std::is_same_v<S, double> && model.has_closures() && !model.has_singular_inertia() &&
           !Eq14Matrix<double>::objection(model);
  }
  /// Beyond, not even a plan is made: where there is another way it is long the better one, where there is none the
  /// plan would take gigabytes.
  static double most_operations(const Model& model) {
    if (!model.has_closures()) return std::numeric_limits<double>::infinity();
    constexpr double hopeless = 5, most = 1e9;
    return may_be_sparse(model) ? hopeless * per_unknown * unknowns(model) : most;
  }

  std::unique_ptr<LoopElimination<S>> by_path_;
  std::unique_ptr<LoopElimination<S>> bodies_first_;  // made when needed
  std::unique_ptr<QuasiDefinite> sparse_;
  LoopElimination<S>* present_ = nullptr;  // of the last factorisation; null: sparse_
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
