// Dual numbers: derivatives by the chain rule, of arithmetic and of kinematics.
#include <gtest/gtest.h>

#include <cmath>

#include "lib/scalar/scalar.h"

namespace lanc::test {
namespace {

using D = Dual<2>;

/// f and its partial derivatives at (x, y), which stand beside it.
struct Known {
  const char* name;
  D (*f)(D, D);
  double (*value)(double, double);
  double (*dx)(double, double);
  double (*dy)(double, double);
};

TEST(Dual, carries_the_derivatives_of_every_operation) {
  const Known all[] = {
      {"sum", [](D x, D y) { return x + y; }, [](double x, double y) { return x + y; },
       [](double, double) { return 1.0; }, [](double, double) { return 1.0; }},
      {"difference", [](D x, D y) { return x - y; }, [](double x, double y) { return x - y; },
       [](double, double) { return 1.0; }, [](double, double) { return -1.0; }},
      {"product", [](D x, D y) { return x * y; }, [](double x, double y) { return x * y; },
       [](double, double y) { return y; }, [](double x, double) { return x; }},
      {"quotient", [](D x, D y) { return x / y; }, [](double x, double y) { return x / y; },
       [](double, double y) { return 1 / y; }, [](double x, double y) { return -x / (y * y); }},
      {"root", [](D x, D y) { return sqrt(x * y); }, [](double x, double y) { return std::sqrt(x * y); },
       [](double x, double y) { return y / (2 * std::sqrt(x * y)); },
       [](double x, double y) { return x / (2 * std::sqrt(x * y)); }},
      {"sine", [](D x, D y) { return sin(x * y); }, [](double x, double y) { return std::sin(x * y); },
       [](double x, double y) { return y * std::cos(x * y); }, [](double x, double y) { return x * std::cos(x * y); }},
      {"cosine", [](D x, D y) { return -cos(x - y); }, [](double x, double y) { return -std::cos(x - y); },
       [](double x, double y) { return std::sin(x - y); }, [](double x, double y) { return -std::sin(x - y); }},
      {"assignment",
       [](D x, D y) {
         x += y;
         x *= y;
         x -= D(2.0);
         x /= y;
         return x;
       },
       [](double x, double y) { return x + y - 2 / y; }, [](double, double) { return 1.0; },
       [](double, double y) { return 1 + 2 / (y * y); }}};
  for (const Known& k : all)
    for (const auto& [x, y] : {std::pair{1.3, 0.7}, {0.4, 2.1}, {3.0, 0.2}}) {
      const D f = k.f(D::variable(x, 0), D::variable(y, 1));
      EXPECT_NEAR(f.value, k.value(x, y), 1e-15 * 16) << k.name;
      EXPECT_NEAR(f.d[0], k.dx(x, y), 1e-14) << k.name;
      EXPECT_NEAR(f.d[1], k.dy(x, y), 1e-13) << k.name;
    }
}

}  // namespace
}  // namespace lanc::test
