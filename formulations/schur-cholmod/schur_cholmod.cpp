#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "formulations/schur-cholmod/schur_matrix.h"
#include "lib/formulation/formulation.h"
#include "lib/formulation/inertia_rank.h"
#include "lib/solve/cholmod.h"

namespace lanc {

namespace {

/// √ε: what inverting M_i and S may leave of the digits together.
constexpr double least_pivot = 1.5e-8;
/// S and its factor take 12 bytes an entry each: 3.6 GB.
constexpr std::int64_t most_nonzeros = 150'000'000;

class SchurCholmod final : public Formulation<double> {
 public:
  SchurCholmod(const Model& model, EliminationOrder order)
      : Formulation<double>(model), matrix_(model), b_(matrix_.size()), mu_(matrix_.size()) {
    if (matrix_.size() > 0) solver_ = make_cholmod(view(), {.order = order});
  }

  void assemble(const System<double>& system) override { matrix_.refill(system); }

  Outcome factorise(const System<double>&) override {
    if (!solver_) return worst_inertia();
    const Factorisation end = solver_->factorise(view());
    if (end.result == Factorisation::Result::failed) return {Status::objection, std::string(end.reason)};
    if (end.result == Factorisation::Result::singular)
      return {Status::objection,
              "G M^-1 G^T is singular to working precision; take a formulation that does not form it"};
    return worst_inertia();
  }

  void substitute(const System<double>& system, const RightHandSide<double>& rhs, Solution<double>& solution) override {
    matrix_.scatter(system, rhs, b_);
    if (solver_) solver_->solve(view(), b_, mu_);
    matrix_.gather(system, rhs, mu_, solution);
  }

  std::optional<LibraryStatistics> statistics() const override {
    LibraryStatistics result{.unknowns = matrix_.size(), .matrix_nonzeros = matrix_.starts().back()};
    if (!solver_) return result;
    const FactorStatistics s = solver_->statistics();
    result.factor_nonzeros = s.nonzeros, result.bytes = s.bytes;
    result.factorise_flops = s.factorise_flops, result.solve_flops = s.solve_flops;
    return result;
  }

 private:
  SparseView view() const {
    return {matrix_.size(), matrix_.starts().data(), matrix_.rows().data(), matrix_.values().data()};
  }

  /// S has the errors of M⁻¹, and its elimination magnifies them: the product of both is what is lost.
  Outcome worst_inertia() const {
    double pivot = 1;
    if (solver_) {
      const LdlFactors f = solver_->factors();
      for (int k = 0; k < matrix_.size(); ++k)
        pivot = std::min(pivot, std::abs(f.values[f.starts[k]] / matrix_.diagonal(f.order[k])));
    }
    int worst = 0;
    for (int i = 1; i < model().bodies(); ++i)
      if (!(matrix_.inertia_quality(i) >= matrix_.inertia_quality(worst))) worst = i;
    const double inertia = model().bodies() > 0 ? matrix_.inertia_quality(worst) : 1;
    if (pivot * inertia > least_pivot) return {};
    return {
        Status::objection,
        fmt::format("the inertia of body '{}' is singular to {:.1e} and G M^-1 G^T to {:.1e}; take a formulation that "
                    "does not form it",
                    model().spec().bodies[worst].name, inertia, pivot)};
  }

  SchurMatrix<double> matrix_;
  std::unique_ptr<CholmodSolver> solver_;  // null when no joint leaves an unknown: all bodies are free
  std::vector<double> b_, mu_;
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

std::unique_ptr<Formulation<double>> standard(const Model& model) {
  return std::make_unique<SchurCholmod>(model, EliminationOrder::as_given);
}

constexpr Variant variants[] = {{"ordering=leaf-to-root", standard},
                                {"ordering=amd", [](const Model& model) -> std::unique_ptr<Formulation<double>> {
                                   return std::make_unique<SchurCholmod>(model, EliminationOrder::amd);
                                 }}};

const Registration registration({.name = "schur-cholmod",
                                 .idea = "maximal coordinates: eliminate the accelerations, G M^-1 G^T by CHOLMOD",
                                 .source = "Baraff 1996; Lubich et al. 1992",
                                 .objection = objection,
                                 .create_double = standard,
                                 .variants = variants});

}  // namespace

}  // namespace lanc
