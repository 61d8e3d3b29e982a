#include "lib/formulation/eq14_formulation.h"
#include "lib/solve/klu.h"

namespace lanc {

namespace {

constexpr Eq14Layout symmetric;

/// The pivots of eq. 18, leaf to root: −1 (â_i from (8)), −1 (f̂_i from (3)), N_i (η̇_i from (12)); no division by M*.
/// The half of f̂ that Cᵀ does not project (the force, in a revolute joint) waits until η̇ is out: fewer products.
SparseOptions recursion(const Model& model, double pivot_tolerance) {
  SparseOptions options{.symmetric = true, .pivot_tolerance = pivot_tolerance};
  const auto eliminate = [&](int row, int column, int count) {
    for (int k = 0; k < count; ++k) options.pivot_rows.push_back(row + k), options.pivot_columns.push_back(column + k);
  };
  for (int i = model.bodies() - 1; i >= 0; --i) {
    const Link& link = model.link(i);
    bool projected[] = {false, false};  // moment, force
    for (int k = link.v; k < link.v + link.nv; ++k) {
      projected[0] |= model.column_kind(k) != ColumnKind::translation;
      projected[1] |= model.column_kind(k) != ColumnKind::rotation;
    }
    const auto at = [&](Block block) { return position(model, symmetric, symmetric.rows, i, block); };
    const int a = at(Block::acceleration), f = at(Block::wrench), vdot = at(Block::velocity);
    eliminate(f, a, 6);
    for (const int half : {0, 1})
      if (projected[half]) eliminate(a + 3 * half, f + 3 * half, 3);
    eliminate(vdot, vdot, link.nv);
    for (const int half : {0, 1})
      if (!projected[half]) eliminate(a + 3 * half, f + 3 * half, 3);
  }
  return options;
}

/// Columns (f̂, â, η̇) against rows (3), (8), (12): no zero on the diagonal, where AMD expects the pivots.
constexpr Eq14Layout full_diagonal{.rows = {Block::acceleration, Block::wrench, Block::velocity},
                                   .columns = {Block::wrench, Block::acceleration, Block::velocity}};

std::unique_ptr<Formulation<double>> make(const Model& model, const Eq14Layout& layout, const SparseOptions& options) {
  const bool fixed_pivots = options.pivot_tolerance == 0;
  return std::make_unique<Eq14Formulation>(model, Eq14Settings{layout, options, make_klu, fixed_pivots});
}

/// With closure rows, which stand behind the bodies of their loops, the plain order of the matrix.
std::unique_ptr<Formulation<double>> leaf_to_root(const Model& model, double pivot_tolerance) {
  if (model.has_closures()) return make(model, full_diagonal, {.pivot_tolerance = pivot_tolerance});
  return make(model, symmetric, recursion(model, pivot_tolerance));
}

std::unique_ptr<Formulation<double>> no_pivoting(const Model& model) { return leaf_to_root(model, 0); }
std::unique_ptr<Formulation<double>> pivoting(const Model& model) { return leaf_to_root(model, 1e-3); }

/// A tree without inertia may be held by its loops; the pivots of eq. 18 then vanish, and others have to be found.
std::unique_ptr<Formulation<double>> standard(const Model& model) {
  return model.has_closures() && model.has_singular_inertia() ? pivoting(model) : no_pivoting(model);
}

constexpr Variant variants[] = {
    {"ordering=leaf-to-root;pivoting=none", no_pivoting},
    {"ordering=leaf-to-root;pivoting=0.001", pivoting},
    {"ordering=amd;pivoting=0.001",
     [](const Model& model) {
       return make(model, full_diagonal, {.order = EliminationOrder::amd, .pivot_tolerance = 1e-3});
     }},
    {"ordering=library;pivoting=0.001",
     [](const Model& model) {
       return make(model, symmetric, {.order = EliminationOrder::library, .pivot_tolerance = 1e-3});
     }},
};

const Registration registration({.name = "eq14-klu",
                                 .idea = "eq. 14 as a sparse matrix, LU by KLU in leaf-to-root order",
                                 .source = "lecture, eq. 14; Davis & Palamadai Natarajan 2010",
                                 .objection = eq14_objection,
                                 .create_double = standard,
                                 .variants = variants});

}  // namespace

}  // namespace lanc
