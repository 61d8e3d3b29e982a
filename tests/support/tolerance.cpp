#include "tests/support/tolerance.h"

#include <cstdio>
#include <cstdlib>

namespace lanc::test {

double tolerance_scale() {
  static const double scale = [] {
    const char* text = std::getenv("LANC_TOLERANCE_SCALE");
    return text ? std::atof(text) : 1.0;
  }();
  return scale;
}

::testing::AssertionResult within_relative(const std::string& what, double error, double relative, double norm) {
  const double nominal = relative * norm;
  if (tolerance_scale() == 0) {
    std::printf("residual %.3e  tolerance %.3e  %s\n", error, nominal, what.c_str());
    return ::testing::AssertionSuccess();
  }
  const double tolerance = tolerance_scale() * nominal;
  if (error <= tolerance && error >= -tolerance) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << what << ": error " << error << " exceeds the tolerance " << tolerance
                                       << " (norm of the reference " << norm << ")";
}

::testing::AssertionResult within(const std::string& what, double error, double size, double norm) {
  return within_relative(what, error, safety * epsilon * size, norm);
}

}  // namespace lanc::test
