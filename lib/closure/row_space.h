// What the rows of G span: its rank, a well-conditioned set of rows, and projections on its range and kernel.
// Private to lib/closure.
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <memory>
#include <vector>

namespace lanc {

/// The scaled rows of loops that hang together (lib/closure/components.h). Up to 40 rows or velocities by dense
/// singular values, beyond by sparse QR of Gᵀ with Heath's treatment of dependent columns (1982, SIAM J. Sci. Stat.
/// Comput. 3, 223-237), whose singular values are estimates: the smallest by inverse iteration, so that a rank that is
/// not clear is seen. Tested by tests/lib/row_space_test.cpp.
class RowSpace {
 public:
  static std::unique_ptr<RowSpace> create(Eigen::Index rows, Eigen::Index columns);
  static std::unique_ptr<RowSpace> create_dense();
  static std::unique_ptr<RowSpace> create_sparse();
  virtual ~RowSpace() = default;

  /// Of Gᵀ, one column per row of G. O(rows · columns · min) dense; sparse, what fill-in makes of it.
  virtual void decompose(const Eigen::SparseMatrix<double>& transposed) = 0;
  /// Singular values, descending, as many as rows or columns, whichever are fewer.
  const Eigen::VectorXd& sigma() const { return sigma_; }
  /// To be called after decompose(); singular values beyond count as zero. Sparse: at most what decompose() found.
  virtual void set_rank(int rank) = 0;
  int rank() const { return rank_; }

  /// `rank` rows that are far from dependent.
  virtual std::vector<int> independent() const = 0;
  /// The part of x, one number a row, that is orthogonal to the range of G: what no velocities can bring about.
  virtual Eigen::VectorXd outside(const Eigen::VectorXd& x) const = 0;
  /// The part of ξ, one number a velocity, in the kernel of G.
  virtual Eigen::VectorXd in_kernel(const Eigen::VectorXd& xi) const = 0;

 protected:
  Eigen::VectorXd sigma_;
  int rank_ = 0;
};

}  // namespace lanc
