// The counters of the libraries against the same elimination run on Count, on the same pattern in the same order.
#include <gtest/gtest.h>

#include "lib/formulation/eq14_formulation.h"
#include "lib/system/evaluator.h"
#include "tests/support/random_model.h"

namespace lanc::test {
namespace {

/// A matrix with its pattern, zeros that fill may reach included; dense storage, for small sizes.
struct Patterned {
  int n;
  std::vector<std::vector<Count>> value;
  std::vector<std::vector<bool>> there;

  /// Row and column k of this are rows[k] and columns[k] of the matrix.
  Patterned(const Eq14Matrix<double>& A, const std::vector<int>& rows, const std::vector<int>& columns, bool mirror)
      : n(A.size()), value(n, std::vector<Count>(n, Count(0.0))), there(n, std::vector<bool>(n, false)) {
    std::vector<int> place(n);
    for (int k = 0; k < n; ++k) place[rows[k]] = k;
    for (int c = 0; c < n; ++c)
      for (int p = A.starts()[columns[c]]; p < A.starts()[columns[c] + 1]; ++p) {
        const int r = place[A.rows()[p]];
        value[r][c] = A.values()[p], there[r][c] = true;
        if (mirror) value[c][r] = A.values()[p], there[c][r] = true;
      }
  }
};

/// Operations of A = L U without pivoting; fills `A` in.
std::int64_t lu(Patterned& A) {
  const Tally before = Count::tally();
  for (int k = 0; k < A.n; ++k)
    for (int r = k + 1; r < A.n; ++r) {
      if (!A.there[r][k]) continue;
      A.value[r][k] /= A.value[k][k];
      for (int c = k + 1; c < A.n; ++c)
        if (A.there[k][c]) A.value[r][c] -= A.value[r][k] * A.value[k][c], A.there[r][c] = true;
    }
  return (Count::tally() - before).flops();
}

/// Operations of A = L D Lᵀ without pivoting; uses and fills the lower triangle.
std::int64_t ldl(Patterned& A) {
  const Tally before = Count::tally();
  for (int k = 0; k < A.n; ++k) {
    for (int r = k + 1; r < A.n; ++r) {
      if (!A.there[r][k]) continue;
      const Count l = A.value[r][k] / A.value[k][k];
      for (int c = r; c < A.n; ++c)
        if (A.there[c][k]) A.value[c][r] -= A.value[c][k] * l, A.there[c][r] = true;
      A.value[r][k] = l;
    }
  }
  return (Count::tally() - before).flops();
}

/// Operations of A = Q R by Householder reflections of the rows that are there; fills `A` in.
std::int64_t qr(Patterned& A) {
  const Tally before = Count::tally();
  for (int k = 0; k < A.n; ++k) {
    std::vector<int> rows;
    for (int r = k; r < A.n; ++r)
      if (A.there[r][k]) rows.push_back(r);
    // the pivot row becomes row k, as row exchanges would make it
    if (rows.empty()) continue;
    if (rows[0] != k) std::swap(A.value[rows[0]], A.value[k]), std::swap(A.there[rows[0]], A.there[k]), rows[0] = k;
    if (rows.size() < 2) continue;
    Count square = A.value[rows[0]][k] * A.value[rows[0]][k];
    for (std::size_t i = 1; i < rows.size(); ++i) square += A.value[rows[i]][k] * A.value[rows[i]][k];
    const Count norm = sqrt(square), alpha = A.value[k][k] > Count(0.0) ? -norm : norm;
    const Count first = A.value[k][k] - alpha;
    const Count tau = -first / alpha;
    for (std::size_t i = 1; i < rows.size(); ++i) A.value[rows[i]][k] /= first;  // v = (1, …)
    A.value[k][k] = alpha;
    for (int c = k + 1; c < A.n; ++c) {
      bool touched = false;
      for (const int r : rows) touched = touched || A.there[r][c];
      if (!touched) continue;
      Count along = A.value[k][c];
      for (std::size_t i = 1; i < rows.size(); ++i) along += A.value[rows[i]][k] * A.value[rows[i]][c];
      along *= tau;
      A.value[k][c] -= along;
      for (std::size_t i = 1; i < rows.size(); ++i) A.value[rows[i]][c] -= along * A.value[rows[i]][k];
      for (const int r : rows) A.there[r][c] = true;
    }
  }
  return (Count::tally() - before).flops();
}

struct Counted {
  double library = 0, count = 0;
};

/// Zeros when the formulation is not built.
Counted counted(std::string_view name, const Case& c, std::int64_t (*eliminate)(Patterned&), bool mirror = false) {
  Evaluator<double> evaluator(c.model);
  const System<double>& system = evaluator.system(c.state, c.loads);
  const FormulationInfo* info = find_formulation(name);
  if (!info) return {};
  const auto formulation = info->create_double(c.model);
  formulation->assemble(system);
  EXPECT_TRUE(formulation->factorise(system).usable()) << name << " on " << c.name;
  const auto& eq14 = dynamic_cast<const Eq14Formulation&>(*formulation);
  std::vector<int> rows, columns;
  eq14.solver().elimination(rows, columns);
  Patterned A(eq14.matrix(), rows, columns, mirror);
  const Counted result{formulation->statistics()->factorise_flops, static_cast<double>(eliminate(A))};
  std::printf("%-13s %-14s library %8.0f  Count %8.0f  ratio %.3f\n", std::string(name).c_str(), c.name.c_str(),
              result.library, result.count, result.library / result.count);
  return result;
}

std::vector<Case> cases() {
  std::vector<Case> result;
  for (const char* joint : {"revolute", "spherical", "free", ""})
    for (const int bodies : {1, 4, 10})
      result.push_back(random_case(bodies, bodies, {.singular_inertias = false, .only_joint = joint}));
  return result;
}

TEST(LibraryFlops, of_klu_are_exactly_those_of_lu_on_count) {
  for (const Case& c : cases()) {
    const Counted flops = counted("eq14-klu", c, lu);
    EXPECT_EQ(flops.library, flops.count) << c.name;
  }
}

TEST(LibraryFlops, of_cholmod_are_exactly_those_of_ldl_on_count) {
  for (const Case& c : cases()) {
    const Counted flops = counted("eq14-cholmod", c, ldl, true);
    EXPECT_EQ(flops.library, flops.count) << c.name;
  }
}

TEST(LibraryFlops, of_schur_cholmod_are_exactly_those_of_the_formulation_on_count) {
  for (const Case& c : cases()) {
    const FormulationInfo* info = find_formulation("schur-cholmod");
    Evaluator<double> evaluator(c.model);
    Evaluator<Count> counting(c.model);
    const System<double>& system = evaluator.system(c.state, c.loads);
    const System<Count>& counted_system = counting.system(cast<Count>(c.state), cast<Count>(c.loads));
    const auto formulation = info->create_double(c.model);
    const auto on_count = info->create_count(c.model);
    formulation->assemble(system), on_count->assemble(counted_system);
    EXPECT_TRUE(formulation->factorise(system).usable());
    const Tally before = Count::tally();
    EXPECT_TRUE(on_count->factorise(counted_system).usable());
    EXPECT_EQ(formulation->statistics()->factorise_flops, static_cast<double>((Count::tally() - before).flops()));
  }
}

/// UMFPACK skips entries that happen to be zero, such as those of axes along a coordinate, and exact cancellations.
TEST(LibraryFlops, of_umfpack_are_those_of_lu_on_count_less_accidental_zeros) {
  if (!find_formulation("eq14-umfpack")) GTEST_SKIP() << "built without the GPL parts of SuiteSparse";
  for (const Case& c : cases()) {
    const Counted flops = counted("eq14-umfpack", c, lu);
    EXPECT_LE(flops.library, flops.count) << c.name;
    EXPECT_GE(flops.library, flops.count * 0.9) << c.name;
  }
}

/// SPQR's fronts also work on zeros, and it counts a reflection of m rows and n columns as 4 m n and more.
TEST(LibraryFlops, of_spqr_are_at_most_twice_those_of_householder_reflections_on_count) {
  if (!find_formulation("eq14-spqr")) GTEST_SKIP() << "built without the GPL parts of SuiteSparse";
  for (const Case& c : cases()) {
    const Counted flops = counted("eq14-spqr", c, qr);
    EXPECT_LE(flops.library, flops.count * 2) << c.name;
    EXPECT_GE(flops.library, flops.count * 0.9) << c.name;
  }
}

}  // namespace
}  // namespace lanc::test
