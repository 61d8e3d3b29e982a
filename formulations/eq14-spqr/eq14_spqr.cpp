#include "lib/formulation/eq14_formulation.h"
#include "lib/solve/gpl/spqr.h"

namespace lanc {

namespace {

std::unique_ptr<Formulation<double>> make(const Model& model, EliminationOrder order,
                                          BodyOrder bodies = BodyOrder::leaf_to_root) {
  const Eq14Layout layout{.bodies = bodies};
  return std::make_unique<Eq14Formulation>(
      model, Eq14Settings{layout, {.order = order, .scale = unit_scale(model, layout)}, make_spqr});
}

std::unique_ptr<Formulation<double>> standard(const Model& model) { return make(model, EliminationOrder::as_given); }

constexpr Variant variants[] = {
    {"ordering=leaf-to-root", standard},
    {"ordering=root-to-leaf",
     [](const Model& model) { return make(model, EliminationOrder::as_given, BodyOrder::root_to_leaf); }},
    {"ordering=amd", [](const Model& model) { return make(model, EliminationOrder::amd); }},
    {"ordering=library", [](const Model& model) { return make(model, EliminationOrder::library); }},
};

const Registration registration({.name = "eq14-spqr",
                                 .idea = "eq. 14 as a sparse matrix, rank-revealing QR by SuiteSparseQR",
                                 .source = "lecture, eq. 14; Davis 2011",
                                 .objection = eq14_objection,
                                 .create_double = standard,
                                 .variants = variants});

}  // namespace

}  // namespace lanc
