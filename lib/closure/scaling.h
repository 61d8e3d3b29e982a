// Units of closure rows and velocities, in one place: before any rank decision, least-squares or minimum-norm answer,
// rows that are lengths are divided by the model's length, and velocities that are lengths measured in it.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "lib/model/model.h"

namespace lanc {

/// G_s = diag(row) G diag(column) has entries without units; λ = diag(row) λ_s, η = diag(column) η_s.
struct ClosureScaling {
  std::vector<double> row, column;

  explicit ClosureScaling(const Model& model) : row(model.closures().rows()), column(model.nv(), 1.0) {
    const double L = model.length();
    for (int k = 0; k < model.nv(); ++k)
      if (model.column_kind(k) == ColumnKind::translation) column[k] = L;
    const ClosureSet& set = model.closures();
    for (int k = 0; k < set.body_rows; ++k) row[k] = set.row_is_length[k] ? 1 / L : 1;
    for (const Coupler& c : set.couplers) {
      double largest = 0;
      for (const Coupler::Term& term : c.terms) largest = std::max(largest, std::abs(term.factor) * column[term.v]);
      row[c.row] = 1 / largest;
    }
  }
};

}  // namespace lanc
