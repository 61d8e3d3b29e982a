// Range and kernel of closure rows: dense and sparse are two witnesses.
#include "lib/closure/row_space.h"

#include <gtest/gtest.h>

#include "lib/closure/scaling.h"
#include "lib/io/mechanism.h"
#include "lib/system/closure_jacobian.h"
#include "lib/system/evaluator.h"
#include "tests/support/loop_cases.h"
#include "tests/support/tolerance.h"

namespace lanc::test {
namespace {

/// Scaled Gᵀ of a mechanism, all rows.
Eigen::SparseMatrix<double> transposed_rows(const Model& model, const State<double>& state) {
  Evaluator<double> evaluator(model);
  ClosureJacobian<double> jacobian(model);
  jacobian.evaluate(evaluator.system(state));
  const ClosureScaling scaling(model);
  Eigen::SparseMatrix<double> result(model.nv(), jacobian.rows());
  std::vector<Eigen::Triplet<double>> entries;
  for (int k = 0; k < jacobian.rows(); ++k)
    for (int p = jacobian.starts()[k]; p < jacobian.starts()[k + 1]; ++p) {
      const int c = jacobian.columns()[p];
      entries.emplace_back(c, k, jacobian.values()[p] * scaling.row[k] * scaling.column[c]);
    }
  result.setFromTriplets(entries.begin(), entries.end());
  return result;
}

void expect_alike(const std::string& name, const Eigen::SparseMatrix<double>& Gt) {
  SCOPED_TRACE(name);
  const auto dense = RowSpace::create_dense(), sparse = RowSpace::create_sparse();
  dense->decompose(Gt), sparse->decompose(Gt);
  const double unit = std::max(1.0, dense->sigma()[0]);
  const int rank = static_cast<int>((dense->sigma().array() > 1e-8 * unit).count());
  const auto by = [&](const RowSpace& space) {
    return static_cast<int>((space.sigma().array() > 1e-8 * unit).count());
  };
  ASSERT_EQ(by(*sparse), rank);
  dense->set_rank(rank), sparse->set_rank(rank);
  EXPECT_NEAR(sparse->sigma()[0], dense->sigma()[0], 0.3 * dense->sigma()[0]);
  if (rank > 0)
    EXPECT_LE(sparse->sigma()[rank - 1], 2 * dense->sigma()[rank - 1]) << "of a part of the rows only, from above";
  Eigen::VectorXd x(Gt.cols()), xi(Gt.rows());
  for (Eigen::Index k = 0; k < x.size(); ++k) x[k] = std::sin(3.0 * static_cast<double>(k) + 1);
  for (Eigen::Index k = 0; k < xi.size(); ++k) xi[k] = std::cos(5.0 * static_cast<double>(k) + 2);
  EXPECT_TRUE(within_relative("outside the range", (dense->outside(x) - sparse->outside(x)).norm(), 1e-9, x.norm()));
  EXPECT_TRUE(within_relative("in the kernel", (dense->in_kernel(xi) - sparse->in_kernel(xi)).norm(), 1e-9, xi.norm()));
  EXPECT_TRUE(within("no velocity", (Gt.transpose() * sparse->in_kernel(xi)).norm(), 100, xi.norm()));
  EXPECT_TRUE(within("no work", (Gt * sparse->outside(x)).norm(), 100, x.norm()));
  const std::vector<int> rows = sparse->independent();
  ASSERT_EQ(static_cast<int>(rows.size()), rank);
  Eigen::MatrixXd chosen(Gt.rows(), rank);
  for (int k = 0; k < rank; ++k) chosen.col(k) = Gt.col(rows[k]);
  const auto alone = RowSpace::create_dense();
  alone->decompose(chosen.sparseView());
  if (rank == 0) return;
  EXPECT_GT(alone->sigma()[rank - 1], 1e-3 * dense->sigma()[rank - 1]);
  EXPECT_GE(sparse->sigma()[rank - 1], alone->sigma()[rank - 1] * (1 - 1e-6)) << "inverse iteration comes from above";
  EXPECT_LE(sparse->sigma()[rank - 1], 2 * alone->sigma()[rank - 1]);
}

TEST(RowSpace, sparse_and_dense_agree_on_loops_of_all_kinds) {
  for (const Case& c : closed_loops()) expect_alike(c.name, transposed_rows(c.model, c.state));
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Case c = tangle(seed, 1 + static_cast<int>(seed) % 6);
    expect_alike(c.name, transposed_rows(c.model, c.state));
  }
  for (const char* name : {"random-loops:8:redundant=any", "random-loops:6:redundant=bennett",
                           "four-bar-nest:20:cut=hinge", "polygon:40:cut=weld", "four-bar-ladder:50:cut=hinge"}) {
    const Mechanism m = load_mechanism(name);
    expect_alike(name, transposed_rows(m.model, m.state));
  }
}

TEST(RowSpace, a_rank_that_is_not_clear_is_seen_by_both) {
  const Mechanism m = load_mechanism("four-bar-ladder:4:cut=point:angle=1.57079632");  // 7e-9 from the flat position
  const Eigen::SparseMatrix<double> Gt = transposed_rows(m.model, m.state);
  for (const auto& space : {RowSpace::create_dense(), RowSpace::create_sparse()}) {
    space->decompose(Gt);
    const auto unclear = [](double s) { return s > 1e-10 && s < 1e-7; };
    EXPECT_TRUE(std::any_of(space->sigma().begin(), space->sigma().end(), unclear));
  }
}

}  // namespace
}  // namespace lanc::test
