#include "lib/formulation/eq14_formulation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "lib/closure/scaling.h"

namespace lanc {

Eq14Formulation::Eq14Formulation(const Model& model, const Eq14Settings& settings)
    : Formulation<double>(model),
      matrix_(model, settings.layout),
      fixed_pivots_(settings.fixed_pivots),
      b_(matrix_.size()),
      x_(matrix_.size()) {
  solver_ = settings.make_solver(view(), settings.solver);
}

SparseView Eq14Formulation::view() const {
  return {matrix_.size(), matrix_.starts().data(), matrix_.rows().data(), matrix_.values().data()};
}

void Eq14Formulation::assemble(const System<double>& system) {
  if (model().has_closures())
    matrix_.refill(system, closures().independent);
  else
    matrix_.refill(system);
}

std::string Eq14Formulation::place(int column) const {
  if (column < 0) return {};
  if (const int row = matrix_.closure_of_column(column); row >= 0)
    return fmt::format(" at closure row '{}'", model().closures().row_names[row]);
  return fmt::format(" at body '{}'", model().spec().bodies[matrix_.body_of_column(column)].name);
}

Outcome Eq14Formulation::factorise(const System<double>&) {
  const Factorisation end = solver_->factorise(view());
  if (end.result == Factorisation::Result::done) return {};
  if (end.result == Factorisation::Result::failed) return {Status::objection, std::string(end.reason)};
  if (fixed_pivots_ && model().has_closures())
    return {Status::objection,
            fmt::format("a pivot vanished{}: the mass matrix of the tree that is left without its loops is singular, "
                        "and the pivots of this formulation divide by it; take one that looks for others",
                        place(end.column))};
  return {Status::singular,
          fmt::format("eq. 14 is singular at this state: a pivot vanished{}; it or what it carries has "
                      "too little inertia for its freedoms",
                      place(end.column))};
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

std::vector<double> unit_scale(const Model& model, const Eq14Layout& layout) {
  double mass = 0;
  for (const Link& link : model.links()) mass += std::abs(link.inertia.mass);
  if (!(mass > 0)) mass = model.bodies();
  const auto power_of_two = [](double x) { return std::exp2(std::rint(std::log2(x))); };
  const double root = power_of_two(std::sqrt(mass / model.bodies())), length = power_of_two(model.length());
  const Eq14Matrix<double> matrix(model, layout);
  std::vector<double> scale(matrix.size());
  for (int i = 0; i < model.bodies(); ++i) {
    double* const a = scale.data() + matrix.column(i, Block::acceleration);
    double* const f = scale.data() + matrix.column(i, Block::wrench);
    double* const vdot = scale.data() + matrix.column(i, Block::velocity);
    std::fill(a, a + 3, 1 / (root * length)), std::fill(a + 3, a + 6, 1 / root);
    std::fill(f, f + 3, root * length), std::fill(f + 3, f + 6, root);
    const Link& link = model.link(i);
    for (int k = 0; k < link.nv; ++k)
      vdot[k] = model.column_kind(link.v + k) == ColumnKind::translation ? 1 / root : 1 / (root * length);
  }
  const ClosureScaling closures(model);
  for (int k = 0; k < model.closures().rows(); ++k)
    scale[matrix.column(k, Block::closure)] = root * power_of_two(model.length() * closures.row[k]);
  return scale;
}

std::optional<std::string> eq14_objection(const Model& model) {
  if (model.bodies() == 0) return "the model has no bodies, and sparse solvers take no empty matrix";
  return Eq14Matrix<double>::objection(model);
}

}  // namespace lanc
