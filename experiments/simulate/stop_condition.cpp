#include <fmt/format.h>

#include <cmath>

#include "experiments/simulate/run.h"
#include "lib/model/error.h"

namespace lanc {

StopCondition read_stop_condition(const std::string& text) {
  const std::size_t sign = text.find_first_of("<>");
  if (sign == text.npos || sign == 0)
    throw InputError(
        fmt::format("--stop-when '{}' is not of the form 'QUANTITY<VALUE' or 'QUANTITY>VALUE', for "
                    "example 'q.j1.angle>1.5'",
                    text));
  const std::vector<double> value = read_numbers("--stop-when", text.substr(sign + 1));
  if (value.size() != 1 || !std::isfinite(value[0]))
    throw InputError(fmt::format("--stop-when '{}': one finite number is needed", text));
  std::string quantity = text.substr(0, sign);
  quantity.erase(quantity.find_last_not_of(" \t") + 1);
  return {text, quantity, value[0], text[sign] == '>'};
}

double StopCondition::distance(const std::vector<Quantity>& quantities) const {
  const double d = value_of(quantities, quantity) - value;
  return above ? d : -d;
}

void locate(const StopCondition& condition, const Checkpoint& before, double t, Simulation& simulation,
            Quantities& quantities) {
  const auto at = [&](double time) {
    (void)simulation.resume(before);
    while (simulation.t() < time && simulation.step(time).usable()) {
    }
    return condition.distance(quantities.at(simulation.instant()));
  };
  // Illinois: secants that keep the sign change
  double a = before.point.state.t, b = t, fa = at(a), fb = at(b);
  const double resolution = 1e-12 * (b - a);
  int side = 0;
  for (int k = 0; k < 100 && b - a > resolution && fb != 0; ++k) {
    double c = (a * fb - b * fa) / (fb - fa);
    if (!(c > a && c < b)) c = (a + b) / 2;
    const double fc = at(c);
    if (fc >= 0) {
      if (b - c < resolution) break;
      b = c, fb = fc;
      if (side == 1) fa /= 2;
      side = 1;
    } else {
      a = c, fa = fc;
      if (side == -1) fb /= 2;
      side = -1;
    }
  }
  at(b);
}

}  // namespace lanc
