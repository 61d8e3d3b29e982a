#include "lib/formulation/eq14_formulation.h"
#include "lib/solve/klu.h"

namespace lanc {

namespace {

/// Columns (f̂, â, η̇) against rows (3), (8), (12) put −1, −1 on the diagonal, and N where η̇ is eliminated: the pivots
/// of eq. 18, with no division by M*.
constexpr Eq14Layout recursion_order{.rows = {Block::acceleration, Block::wrench, Block::velocity},
                                     .columns = {Block::wrench, Block::acceleration, Block::velocity}};

std::unique_ptr<Formulation<double>> make(const Model& model, const Eq14Layout& layout, const SparseOptions& options) {
  const bool fixed_pivots = options.pivot_tolerance == 0;
  return std::make_unique<Eq14Formulation>(model, Eq14Settings{layout, options, make_klu, fixed_pivots});
}

std::unique_ptr<Formulation<double>> no_pivoting(const Model& model) { return make(model, recursion_order, {}); }
std::unique_ptr<Formulation<double>> pivoting(const Model& model) {
  return make(model, recursion_order, {.pivot_tolerance = 1e-3});
}

/// A tree without inertia may be held by its loops; the pivots of eq. 18 then vanish, and others have to be found.
std::unique_ptr<Formulation<double>> standard(const Model& model) {
  return model.has_closures() && model.has_singular_inertia() ? pivoting(model) : no_pivoting(model);
}

constexpr Variant variants[] = {
    {"ordering=leaf-to-root;pivoting=none", no_pivoting},
    {"ordering=leaf-to-root;pivoting=0.001", pivoting},
    {"ordering=amd;pivoting=0.001",
     [](const Model& model) {
       return make(model, recursion_order, {.order = EliminationOrder::amd, .pivot_tolerance = 1e-3});
     }},
    {"ordering=library;pivoting=0.001",
     [](const Model& model) { return make(model, {}, {.order = EliminationOrder::library, .pivot_tolerance = 1e-3}); }},
};

const Registration registration({.name = "eq14-klu",
                                 .idea = "eq. 14 as a sparse matrix, LU by KLU in leaf-to-root order",
                                 .source = "lecture, eq. 14; Davis & Palamadai Natarajan 2010",
                                 .objection = eq14_objection,
                                 .create_double = standard,
                                 .variants = variants});

}  // namespace

}  // namespace lanc
