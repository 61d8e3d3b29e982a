#include "lib/model/motion.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <unsupported/Eigen/Splines>

#include "lib/model/error.h"
#include "lib/model/expression.h"

namespace lanc {
namespace {

template <class Evaluate>
class FunctionMotion final : public PrescribedMotion {
 public:
  explicit FunctionMotion(Evaluate evaluate) : evaluate_(std::move(evaluate)) {}
  MotionSample at(double t) const override { return evaluate_(t); }

 private:
  Evaluate evaluate_;
};

template <class Evaluate>
std::shared_ptr<const PrescribedMotion> motion(Evaluate evaluate) {
  return std::make_shared<FunctionMotion<Evaluate>>(std::move(evaluate));
}

void require_finite(std::initializer_list<double> numbers) {
  for (const double x : numbers)
    if (!std::isfinite(x)) throw InputError("a number of the prescribed motion is not finite");
}

std::shared_ptr<const PrescribedMotion> create_from(const ConstantSpeed& m) {
  require_finite({m.start, m.rate});
  return motion([m](double t) { return MotionSample{m.start + m.rate * t, m.rate, 0}; });
}

std::shared_ptr<const PrescribedMotion> create_from(const Polynomial& m) {
  if (m.coefficients.empty()) throw InputError("a polynomial motion needs at least one coefficient");
  for (const double c : m.coefficients) require_finite({c});
  return motion([c = m.coefficients](double t) {
    MotionSample s;  // Horner's scheme for the value and its derivatives at once
    for (auto k = c.rbegin(); k != c.rend(); ++k) {
      s.acceleration = s.acceleration * t + 2 * s.velocity;
      s.velocity = s.velocity * t + s.position;
      s.position = s.position * t + *k;
    }
    return s;
  });
}

std::shared_ptr<const PrescribedMotion> create_from(const Sine& m) {
  require_finite({m.offset, m.amplitude, m.frequency, m.phase});
  return motion([m](double t) {
    const double s = m.amplitude * std::sin(m.frequency * t + m.phase),
                 c = m.amplitude * std::cos(m.frequency * t + m.phase);
    return MotionSample{m.offset + s, m.frequency * c, -m.frequency * m.frequency * s};
  });
}

std::shared_ptr<const PrescribedMotion> create_from(const SplineTable& m) {
  constexpr int degree = 3;
  const auto n = static_cast<Eigen::Index>(m.times.size());
  if (m.times.size() != m.values.size())
    throw InputError(
        fmt::format("the table of the motion has {} times and {} values", m.times.size(), m.values.size()));
  if (n <= degree) throw InputError("a spline needs a table of at least four times and values");
  for (Eigen::Index k = 0; k < n; ++k) {
    require_finite({m.times[k], m.values[k]});
    if (k > 0 && !(m.times[k] > m.times[k - 1]))
      throw InputError(fmt::format("the times of the table must increase; entry {} does not", k + 1));
  }
  const double start = m.times.front(), span = m.times.back() - start;
  using Spline = Eigen::Spline<double, 1, degree>;
  Spline::KnotVectorType u(n);
  Eigen::RowVectorXd values(n);
  for (Eigen::Index k = 0; k < n; ++k) u[k] = (m.times[k] - start) / span, values[k] = m.values[k];
  const Spline spline = Eigen::SplineFitting<Spline>::Interpolate(values, degree, u);
  return motion([spline, start, span](double t) {
    const double x = (t - start) / span;
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    if (!(x >= 0 && x <= 1)) return MotionSample{nan, nan, nan};
    const auto d = spline.derivatives(x, 2);
    return MotionSample{d(0, 0), d(0, 1) / span, d(0, 2) / (span * span)};
  });
}

std::shared_ptr<const PrescribedMotion> create_from(const Formula& m) {
  return motion([expression = Expression(m.text)](double t) { return expression.at(t); });
}

}  // namespace

std::shared_ptr<const PrescribedMotion> PrescribedMotion::create(const MotionSpec& spec) {
  return std::visit([](const auto& m) { return create_from(m); }, spec);
}

}  // namespace lanc
