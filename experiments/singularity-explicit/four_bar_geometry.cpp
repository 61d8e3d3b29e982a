#include "experiments/singularity-explicit/four_bar_geometry.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "lib/model/error.h"

namespace lanc {
namespace {

const double pi = std::acos(-1.0);

/// The angle between sides p and q of a triangle, r being opposite; nothing when there is no such triangle.
std::optional<double> triangle_angle(double p, double q, double r) {
  const double cosine = (p * p + q * q - r * r) / (2 * p * q);
  if (!(std::abs(cosine) <= 1)) return std::nullopt;
  return std::acos(cosine);
}

double gap(double a, double b) { return std::abs(std::remainder(a - b, 2 * pi)); }

}  // namespace

State<double> some_closed_position(const FourBarLengths& l) {
  const double nearest = std::max(std::abs(l.b - l.c), std::abs(l.a - l.d));
  const double farthest = std::min(l.b + l.c, l.a + l.d);
  if (!(nearest < farthest))
    throw InputError(
        fmt::format("crank {}, coupler {}, rocker {} and ground {} cannot be joined: one is longer than "
                    "the others together; make it shorter",
                    l.a, l.b, l.c, l.d));
  const double e = 0.1 * nearest + 0.9 * farthest;  // between coupler-on-crank and the rocker's pivot
  const double beta1 = pi / 2 - *triangle_angle(l.a, l.d, e);
  const double x = l.a * std::cos(beta1), y = l.a * std::sin(beta1);
  const double rocker = std::atan2(y - l.d, x) + *triangle_angle(e, l.c, l.b);
  const double coupler = std::atan2(l.d + l.c * std::sin(rocker) - y, l.c * std::cos(rocker) - x);
  return {0, {beta1, std::remainder(coupler - beta1, 2 * pi), rocker + pi / 2}, {0, 0, 0}};
}

std::optional<ExtremePoint> nearest_extreme(const FourBarLengths& l, int coordinate, double beta1, double beta3) {
  std::optional<ExtremePoint> best;
  for (const double fold : {1.0, -1.0}) {
    // β1: coupler and rocker are one line from the rocker's pivot; β3: crank and coupler one from the crank's
    const double line = coordinate == 0 ? l.c + fold * l.b : l.a + fold * l.b;
    const double link = coordinate == 0 ? l.a : l.c;
    const auto at_link = triangle_angle(link, l.d, line);
    auto at_line = triangle_angle(line, l.d, link);
    if (!at_link || !at_line) continue;
    if (line < 0) *at_line = -*at_line;  // the first of its links points away from where the line ends
    for (const double mirror : {1.0, -1.0}) {
      ExtremePoint point;
      point.coordinate = coordinate;
      point.in_line = fmt::format("{}{}{}", coordinate == 0 ? "coupler" : "crank", fold > 0 ? '+' : '-',
                                  coordinate == 0 ? "rocker" : "coupler");
      point.beta1 = pi / 2 - mirror * (coordinate == 0 ? *at_link : *at_line);
      point.beta3 = mirror * (coordinate == 0 ? *at_line : *at_link);
      const auto away = [&](const ExtremePoint& p) { return gap(p.beta1, beta1) + gap(p.beta3, beta3); };
      if (!best || away(point) < away(*best)) best = point;
    }
  }
  return best;
}

}  // namespace lanc
