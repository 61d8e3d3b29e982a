#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "formulations/schur-cholmod/schur_matrix.h"
#include "formulations/schur-cholmod/sparse_ldl.h"
#include "lib/formulation/formulation.h"
#include "lib/formulation/inertia_rank.h"
#include "lib/solve/cholmod.h"

namespace lanc {

namespace {

/// √ε: what inverting M_i and S may leave of the digits together.
constexpr double least_pivot = 1.5e-8;
/// S and its factor take 12 bytes an entry each: 3.6 GB.
constexpr std::int64_t most_nonzeros = 150'000'000;

/// CHOLMOD on double, the same elimination written out on other scalars.
template <class S>
class SchurSolver {
 public:
  SchurSolver(const SchurMatrix<S>& matrix, EliminationOrder) : matrix_(matrix), ldl_(matrix.starts(), matrix.rows()) {}

  Factorisation factorise() {
    ldl_.factorise(matrix_.values());
    for (int k = 0; k < matrix_.size(); ++k)
      if (to_double(ldl_.pivot(k)) == 0) return {Factorisation::Result::singular, k, {}};
    return {};
  }
  void solve(std::vector<S>& b, std::vector<S>& x) {
    x = b;
    ldl_.solve(x);
  }
  /// Least pivot relative to the diagonal entry it is what is left of.
  double quality() const {
    double least = 1;
    for (int k = 0; k < matrix_.size(); ++k)
      least = std::min(least, std::abs(to_double(ldl_.pivot(k)) / to_double(matrix_.diagonal(k))));
    return least;
  }
  std::optional<FactorStatistics> statistics() const { return std::nullopt; }

 private:
  const SchurMatrix<S>& matrix_;
  SparseLdl<S> ldl_;
};

template <>
class SchurSolver<double> {
 public:
  SchurSolver(const SchurMatrix<double>& matrix, EliminationOrder order) : matrix_(matrix) {
    if (matrix_.size() > 0) cholmod_ = make_cholmod(view(), {.order = order});
  }

  Factorisation factorise() { return cholmod_ ? cholmod_->factorise(view()) : Factorisation{}; }
  void solve(std::vector<double>& b, std::vector<double>& x) {
    if (cholmod_) cholmod_->solve(view(), b, x);
  }
  double quality() const {
    double least = 1;
    if (!cholmod_) return least;
    const LdlFactors f = cholmod_->factors();
    for (int k = 0; k < matrix_.size(); ++k)
      least = std::min(least, std::abs(f.values[f.starts[k]] / matrix_.diagonal(f.order[k])));
    return least;
  }
  std::optional<FactorStatistics> statistics() const {
    return cholmod_ ? cholmod_->statistics() : FactorStatistics{.factorise_flops = 0, .solve_flops = 0};
  }

 private:
  SparseView view() const {
    return {matrix_.size(), matrix_.starts().data(), matrix_.rows().data(), matrix_.values().data()};
  }

  const SchurMatrix<double>& matrix_;
  std::unique_ptr<CholmodSolver> cholmod_;  // null when no joint leaves an unknown: all bodies are free
};

template <class S>
class SchurCholmod final : public Formulation<S> {
 public:
  /// Any order will do for a positive definite matrix; that of the recursion fills only where loops are closed.
  explicit SchurCholmod(const Model& model)
      : SchurCholmod(model, model.has_closures() ? EliminationOrder::amd : EliminationOrder::as_given) {}
  SchurCholmod(const Model& model, EliminationOrder order)
      : Formulation<S>(model), matrix_(model), solver_(matrix_, order), b_(matrix_.size()), mu_(matrix_.size()) {}

  void assemble(const System<S>& system) override {
    if (this->model().has_closures())
      matrix_.refill(system, this->closures().independent);
    else
      matrix_.refill(system, {});
  }

  Outcome factorise(const System<S>&) override {
    const Factorisation end = solver_.factorise();
    if (end.result == Factorisation::Result::failed) return {Status::objection, std::string(end.reason)};
    if (end.result == Factorisation::Result::singular)
      return {Status::objection,
              "G M^-1 G^T is singular to working precision; take a formulation that does not form it"};
    return judged();
  }

  void substitute(const System<S>& system, const RightHandSide<S>& rhs, Solution<S>& solution) override {
    matrix_.scatter(system, rhs, b_);
    solver_.solve(b_, mu_);
    matrix_.gather(system, rhs, mu_, solution);
  }

  std::optional<LibraryStatistics> statistics() const override {
    const auto s = solver_.statistics();
    if (!s) return std::nullopt;
    return LibraryStatistics{.unknowns = matrix_.size(),
                             .matrix_nonzeros = matrix_.starts().back(),
                             .factor_nonzeros = s->nonzeros,
                             .bytes = s->bytes,
                             .factorise_flops = s->factorise_flops,
                             .solve_flops = s->solve_flops};
  }

 private:
  /// S has the errors of M⁻¹, and its elimination magnifies them: the product of both is what is lost.
  Outcome judged() const {
    const Model& model = this->model();
    int worst = 0;
    for (int i = 1; i < model.bodies(); ++i)
      if (!(matrix_.inertia_quality(i) >= matrix_.inertia_quality(worst))) worst = i;
    const double inertia = model.bodies() > 0 ? matrix_.inertia_quality(worst) : 1, pivot = solver_.quality();
    if (pivot * inertia > least_pivot) return {};
    return {
        Status::objection,
        fmt::format("the inertia of body '{}' is singular to {:.1e} and G M^-1 G^T to {:.1e}; take a formulation that "
                    "does not form it",
                    model.spec().bodies[worst].name, inertia, pivot)};
  }

  SchurMatrix<S> matrix_;
  SchurSolver<S> solver_;
  std::vector<S> b_, mu_;
};

std::optional<std::string> objection(const Model& model) {
  for (int i = 0; i < model.bodies(); ++i)
    if (const int rank = inertia_rank(model, i); rank < 6)
      return fmt::format("body '{}' has a spatial inertia of rank {}, and maximal coordinates divide by it",
                         model.spec().bodies[i].name, rank);
  if (const std::int64_t entries = SchurMatrix<double>::count_nonzeros(model); entries > most_nonzeros)
    return fmt::format(
        "G M^-1 G^T would have {:.3g} entries ({:.1f} GB with its factor), since joints that meet at a "
        "body are all coupled",
        static_cast<double>(entries), 24e-9 * static_cast<double>(entries));
  return std::nullopt;
}

template <EliminationOrder order>
std::unique_ptr<Formulation<double>> ordered(const Model& model) {
  return std::make_unique<SchurCholmod<double>>(model, order);
}

constexpr Variant variants[] = {{"ordering=leaf-to-root", ordered<EliminationOrder::as_given>},
                                {"ordering=amd", ordered<EliminationOrder::amd>}};

const Registration registration({.name = "schur-cholmod",
                                 .idea = "maximal coordinates: eliminate the accelerations, G M^-1 G^T by CHOLMOD",
                                 .source = "Baraff 1996",
                                 .objection = objection,
                                 .create_double = create<SchurCholmod<double>, double>,
                                 .create_long_double = create<SchurCholmod<long double>, long double>,
                                 .create_count = create<SchurCholmod<Count>, Count>,
                                 .variants = variants});

}  // namespace

}  // namespace lanc
