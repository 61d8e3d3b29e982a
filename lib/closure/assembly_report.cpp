#include "lib/closure/assembly_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace lanc {

/// Of a row that is no length: the angle whose sine it is, or for a coupler the angle itself.
double AssemblyReport::gap(int row, double scaled) const {
  const double value = std::abs(scaled) / scaling_.row[row];
  const bool sine = row < model_.closures().body_rows && !model_.closures().row_is_length[row];
  return sine ? std::asin(std::min(1.0, value)) : value;
}

std::vector<ClosureGap> AssemblyReport::gaps(const std::vector<double>& g) const {
  std::vector<ClosureGap> list;
  const auto add = [&](const std::string& name, int row, int count) {
    ClosureGap closure{name};
    for (int k = row; k < row + count; ++k) {
      double& worst = model_.closures().row_is_length[k] ? closure.length : closure.angle;
      if (const double x = gap(k, g[k]); !(x <= worst)) worst = x;
    }
    list.push_back(std::move(closure));
  };
  const ClosureSet& set = model_.closures();
  for (std::size_t c = 0; c < set.closures.size(); ++c)
    add(model_.spec().closures[c].name, set.closures[c].row, set.closures[c].conditions().count);
  for (std::size_t c = 0; c < set.couplers.size(); ++c) add(model_.spec().couplers[c].name, set.couplers[c].row, 1);
  return list;
}

std::string AssemblyReport::open_rows(std::vector<int> rows, const std::vector<double>& g) const {
  std::sort(rows.begin(), rows.end(), [&](int a, int b) { return !(std::abs(g[a]) <= std::abs(g[b])); });
  std::string text;
  for (std::size_t k = 0; k < std::min<std::size_t>(3, rows.size()); ++k) {
    const int row = rows[k];
    // what is small against the worst row is rounding, or has not settled
    if (k > 0 && !(std::abs(g[row]) > std::max(tolerance_, 1e-4 * std::abs(g[rows[0]])))) break;
    text += fmt::format("{}'{}' open by {:.3g} {}", k == 0 ? "" : ", ", model_.closures().row_names[row],
                        gap(row, g[row]), model_.closures().row_is_length[row] ? "m" : "rad");
  }
  return text;
}

void AssemblyReport::measure_move(const std::vector<double>& from, const std::vector<double>& to,
                                  AssemblyResult& result) const {
  for (const Link& link : model_.links()) {
    const JointTraits& traits = link.kind.traits();
    const double *a = from.data() + link.q, *b = to.data() + link.q;
    for (int k = 0; k < link.nq; ++k) {
      if (traits.quaternion >= 0 && k >= traits.quaternion) continue;
      const bool length = traits.quaternion > 0 || traits.q_units[k] == "m";
      double& worst = length ? result.moved_length : result.moved_angle;
      worst = std::max(worst, std::abs(b[k] - a[k]));
    }
    if (const int w = traits.quaternion; w >= 0 && link.nq > 0) {
      double same = 0, other = 0;  // distances from the one and the other sign: accurate for small turns
      for (int k = w; k < w + 4; ++k) same += (b[k] - a[k]) * (b[k] - a[k]), other += (b[k] + a[k]) * (b[k] + a[k]);
      const double chord = std::sqrt(std::min(same, other));
      result.moved_angle = std::max(result.moved_angle, 4 * std::asin(std::min(1.0, chord / 2)));
    }
  }
}

}  // namespace lanc
