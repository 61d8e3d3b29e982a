#include "formulations/eq14-cholmod/eq14_cholmod.h"

#include <fmt/format.h>

#include <cmath>

#include "lib/formulation/inertia_rank.h"

namespace lanc {

namespace {

/// √ε: a pivot that is smaller against the diagonal entry it came from has lost half of the digits.
constexpr double least_pivot = 1.5e-8;

std::unique_ptr<SparseSolver> make_solver(const SparseView& sample, const SparseOptions& options) {
  return make_cholmod(sample, options);
}

}  // namespace

Eq14Cholmod::Eq14Cholmod(const Model& model, BodyOrder bodies)
    : Eq14Formulation(model, {{.bodies = bodies, .upper_triangle = true}, {}, make_solver, true}) {}

Outcome Eq14Cholmod::factorise(const System<double>& system) {
  Outcome outcome = Eq14Formulation::factorise(system);
  if (!outcome.usable()) {
    if (outcome.status == Status::singular)
      outcome = {Status::objection, outcome.message + "; or an M* is singular, which this formulation divides by"};
    return outcome;
  }
  for (int i = 0; i < model().bodies(); ++i)
    if (const double left = digits_left(i); !(left > least_pivot))
      return {Status::objection,
              fmt::format("the inertia M* of body '{}' and what it carries is singular to {:.1e}, and LDL^T without "
                          "pivoting divides by it; take a formulation that does not",
                          model().spec().bodies[i].name, left)};
  return model().has_closures() ? judged_closures() : outcome;
}

/// Of a closure row nothing is in the diagonal but what the eliminations before it have added and taken away: its pivot
/// relative to the sum of their magnitudes is what they leave of the digits.
Outcome Eq14Cholmod::judged_closures() const {
  const LdlFactors f = factors();
  std::vector<double> sum(matrix().size(), 0.0);
  for (int c = 0; c < matrix().size(); ++c) {
    const double pivot = std::abs(f.values[f.starts[c]]);
    for (int p = f.starts[c] + 1; p < f.starts[c] + f.counts[c]; ++p)
      sum[f.rows[p]] += f.values[p] * f.values[p] * pivot;
  }
  for (int k = 0; k < model().closures().rows(); ++k) {
    if (!closures().independent[k]) continue;
    const int at = matrix().column(k, Block::closure);
    if (const double left = std::abs(f.values[f.starts[at]]) / sum[at]; !(left > least_pivot))
      return {Status::objection,
              fmt::format("the pivot of closure row '{}' is what rounding leaves of terms {:.1e} times as large; LDL^T "
                          "without pivoting divides by it, take a formulation that does not",
                          model().closures().row_names[k], 1 / left)};
  }
  return {};
}

/// Least pivot of the block M* (M_i, root to leaf) relative to the diagonal entry it is what is left of: the factor by
/// which the elimination of â_i may magnify rounding errors, whatever the units.
double Eq14Cholmod::digits_left(int body) const {
  const LdlFactors f = factors();
  const int first = matrix().column(body, Block::acceleration);
  double diagonal[6] = {}, left = 1;
  for (int k = 0; k < 6; ++k) {
    const double* column = f.values + f.starts[first + k];
    const int* rows = f.rows + f.starts[first + k];
    const double pivot = column[0];
    diagonal[k] += pivot;
    left = std::min(left, std::abs(pivot / diagonal[k]));
    for (int p = 1; p < f.counts[first + k] && rows[p] < first + 6; ++p)
      diagonal[rows[p] - first] += column[p] * column[p] * pivot;
  }
  return left;
}

namespace {

std::optional<std::string> objection(const Model& model) {
  if (auto why = eq14_objection(model)) return why;
  const std::vector<int> rank = articulated_rank_bound(model);
  for (int i = model.bodies() - 1; i >= 0; --i)
    if (rank[i] < 6)
      return fmt::format(
          "body '{}' and what it carries have an articulated inertia of rank {} at most, and LDL^T "
          "without pivoting divides by it",
          model.spec().bodies[i].name, rank[i]);
  return std::nullopt;
}

constexpr Variant variants[] = {
    {"ordering=leaf-to-root", create<Eq14Cholmod, double>},
    {"ordering=root-to-leaf", [](const Model& model) -> std::unique_ptr<Formulation<double>> {
       return std::make_unique<Eq14Cholmod>(model, BodyOrder::root_to_leaf);
     }}};

const Registration registration({.name = "eq14-cholmod",
                                 .idea = "eq. 14 as a sparse symmetric matrix, LDL^T without pivoting by CHOLMOD",
                                 .source = "lecture, eq. 14; Chen, Davis, Hager & Rajamanickam 2008",
                                 .objection = objection,
                                 .create_double = create<Eq14Cholmod, double>,
                                 .variants = variants});

}  // namespace

}  // namespace lanc
