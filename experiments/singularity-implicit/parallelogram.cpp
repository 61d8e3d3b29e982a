#include "experiments/singularity-implicit/parallelogram.h"

#include <algorithm>
#include <cmath>

namespace lanc {
namespace {

const double pi = std::acos(-1.0);

}  // namespace

double antiparallel_beta3(double a, double d, double beta1) {
  const double half = (pi / 2 - beta1) / 2;
  return std::remainder(2 * std::atan2((a - d) * std::cos(half), (a + d) * std::sin(half)), 2 * pi);
}

std::string branch_name(const std::vector<std::vector<double>>& positions) {
  const auto all = [&](auto&& deviation) {
    return std::all_of(positions.begin(), positions.end(), [&](const std::vector<double>& q) {
      return std::abs(std::remainder(deviation(q), 2 * pi)) < 1e-6;
    });
  };
  if (all([](const auto& q) { return q[2] - q[0] - pi / 2; })) return "parallel";
  if (all([](const auto& q) { return q[0] - pi / 2; })) return "beta1-fixed";
  if (all([](const auto& q) { return q[2]; })) return "beta3-fixed";
  return "antiparallel";
}

std::vector<Crossing> crossings(double a, double d) {
  const Eigen::Vector3d parallel = Eigen::Vector3d(1, -1, 1).normalized();
  const bool rhombus = a == d;
  const auto other = [&](double e1, double e2, double e3, const char* line) {
    return std::pair<std::string, Eigen::Vector3d>(rhombus ? line : "antiparallel",
                                                   Eigen::Vector3d(e1, e2, e3).normalized());
  };
  std::vector<Crossing> list = {
      {{pi / 2, 0, pi}, {{"parallel", parallel}, other(a - d, a + d, a + d, "beta1-fixed")}},
      {{-pi / 2, pi, 0}, {{"parallel", parallel}, other(a + d, a - d, a - d, "beta3-fixed")}}};
  if (rhombus) list.push_back({{pi / 2, pi, 0}, {other(0, 1, 1, "beta1-fixed"), other(1, 0, 0, "beta3-fixed")}});
  return list;
}

}  // namespace lanc
