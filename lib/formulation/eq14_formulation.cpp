#include "lib/formulation/eq14_formulation.h"

#include <fmt/format.h>

namespace lanc {

Eq14Formulation::Eq14Formulation(const Model& model, const Eq14Settings& settings)
    : Formulation<double>(model), matrix_(model, settings.layout), b_(matrix_.size()), x_(matrix_.size()) {
  solver_ = settings.make_solver(view(), settings.solver);
}

SparseView Eq14Formulation::view() const {
  return {matrix_.size(), matrix_.starts().data(), matrix_.rows().data(), matrix_.values().data()};
}

void Eq14Formulation::assemble(const System<double>& system) { matrix_.refill(system); }

Outcome Eq14Formulation::factorise(const System<double>&) {
  const Factorisation end = solver_->factorise(view());
  if (end.result == Factorisation::Result::done) return {};
  if (end.result == Factorisation::Result::failed) return {Status::objection, std::string(end.reason)};
  const std::string where =
      end.column < 0 ? std::string()
                     : fmt::format(" at body '{}'", model().spec().bodies[matrix_.body_of_column(end.column)].name);
  return {Status::singular,
          fmt::format("eq. 14 is singular at this state: a pivot vanished{}; it or what it carries has "
                      "too little inertia for its freedoms",
                      where)};
}

void Eq14Formulation::substitute(const System<double>&, const RightHandSide<double>& rhs, Solution<double>& solution) {
  matrix_.scatter(rhs, b_);
  solver_->solve(view(), b_, x_);
  matrix_.gather(x_, solution);
}

std::optional<LibraryStatistics> Eq14Formulation::statistics() const {
  const FactorStatistics s = solver_->statistics();
  return LibraryStatistics{.unknowns = matrix_.size(),
                           .matrix_nonzeros = matrix_.nonzeros(),
                           .factor_nonzeros = s.nonzeros,
                           .bytes = s.bytes,
                           .factorise_flops = s.factorise_flops,
                           .solve_flops = s.solve_flops};
}

std::optional<std::string> eq14_objection(const Model& model) { return Eq14Matrix<double>::objection(model); }

}  // namespace lanc
