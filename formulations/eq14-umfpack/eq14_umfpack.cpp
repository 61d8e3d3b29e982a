#include "lib/formulation/eq14_formulation.h"
#include "lib/solve/gpl/umfpack.h"

namespace lanc {

namespace {

/// UMFPACK's own least size of a diagonal pivot, relative to its column.
constexpr double tolerance = 1e-3;

std::unique_ptr<Formulation<double>> make(const Model& model, const SparseOptions& options,
                                          BodyOrder bodies = BodyOrder::leaf_to_root) {
  return std::make_unique<Eq14Formulation>(model, Eq14Settings{{.bodies = bodies}, options, make_umfpack});
}

std::unique_ptr<Formulation<double>> standard(const Model& model) {
  return make(model, {.pivot_tolerance = tolerance});
}

constexpr Variant variants[] = {
    {"ordering=leaf-to-root;refinement=no", standard},
    {"ordering=leaf-to-root;refinement=yes",
     [](const Model& model) { return make(model, {.pivot_tolerance = tolerance, .refine = true}); }},
    {"ordering=root-to-leaf;refinement=no",
     [](const Model& model) { return make(model, {.pivot_tolerance = tolerance}, BodyOrder::root_to_leaf); }},
    {"ordering=amd;refinement=no",
     [](const Model& model) { return make(model, {.order = EliminationOrder::amd, .pivot_tolerance = tolerance}); }},
    {"ordering=library;refinement=yes",
     [](const Model& model) { return make(model, {.order = EliminationOrder::library, .refine = true}); }},
};

const Registration registration({.name = "eq14-umfpack",
                                 .idea = "eq. 14 as a sparse matrix, LU with pivoting by UMFPACK",
                                 .source = "lecture, eq. 14; Davis 2004",
                                 .objection = eq14_objection,
                                 .create_double = standard,
                                 .variants = variants});

}  // namespace

}  // namespace lanc
