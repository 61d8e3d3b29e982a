#include "experiments/crossover/published.h"

namespace lanc {

namespace {

// Bias torques by recursive Newton-Euler inverse dynamics.
constexpr double newton_euler(double n) { return 231 * n - 124; }
constexpr double newton_euler_tuned(double n) { return 174 * n - 135; }
// Mass matrix by composite inertias, and its factorisation with one solve.
constexpr double composite(double n) { return 16 * n * n + 59 * n - 75; }
constexpr double cholesky(double n) { return n * n * n / 3 + 2.5 * n * n + n / 6; }
// Mass matrix as the product JᵀMJ: nothing exploited, or M kept block by block.
constexpr double dense_product(double n) { return 84 * n * n * n; }
constexpr double block_product(double n) { return 12 * n * n * n + 72 * n * n; }

constexpr PublishedCount table[] = {
    {"published: recursion 579n-526", "Featherstone 1987, Robot Dynamics Algorithms", true,
     [](double n) { return 579 * n - 526; }},
    {"published: recursion 470n-420", "Brandl, Johanni & Otter 1986", true, [](double n) { return 470 * n - 420; }},
    {"published: recursion 429n-507", "McMillan & Orin 1995", true, [](double n) { return 429 * n - 507; }},
    {"published: composite, RNEA 231n-124", "composite inertias 16n^2+59n-75; Cholesky n^3/3+2.5n^2+n/6", false,
     [](double n) { return newton_euler(n) + composite(n) + cholesky(n); }},
    {"published: composite, RNEA 174n-135", "the same with the inverse dynamics of Balafoutis & Patel", false,
     [](double n) { return newton_euler_tuned(n) + composite(n) + cholesky(n); }},
    {"published: JtMJ dense 84n^3", "plain count: three dense 6n products; RNEA 231n-124, Cholesky", false,
     [](double n) { return newton_euler(n) + dense_product(n) + cholesky(n); }},
    {"published: JtMJ block 12n^3+72n^2", "plain count: M block-diagonal; RNEA 231n-124, Cholesky", false,
     [](double n) { return newton_euler(n) + block_product(n) + cholesky(n); }},
};

}  // namespace

std::span<const PublishedCount> published_counts() { return table; }

}  // namespace lanc
