#include "lib/closure/row_space.h"

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseQR>
#include <algorithm>
#include <cmath>

#include "lib/closure/rank.h"
#include "lib/solve/dense.h"

namespace lanc {
namespace {

using Eigen::Index, Eigen::VectorXd;
using Sparse = Eigen::SparseMatrix<double>;

class DenseRowSpace final : public RowSpace {
 public:
  void decompose(const Sparse& transposed) override {
    G_ = transposed.transpose();
    SingularValues svd = left_singular_values(G_, SingularVectors::full);
    U_ = std::move(svd.U), sigma_ = std::move(svd.sigma);
  }

  void set_rank(int rank) override { rank_ = rank; }

  std::vector<int> independent() const override {
    std::vector<int> order = pivot_order(G_.transpose());
    order.resize(rank_);
    return order;
  }

  VectorXd outside(const VectorXd& x) const override {
    const auto U0 = U_.rightCols(U_.cols() - rank_);
    return U0 * (U0.transpose() * x);
  }

  /// ξ − V_r V_rᵀ ξ with V_r = Gᵀ U_r Σ_r⁻¹.
  VectorXd in_kernel(const VectorXd& xi) const override {
    VectorXd part = xi;
    const auto U = U_.leftCols(rank_);
    const VectorXd inverse = sigma_.head(rank_).cwiseInverse().cwiseAbs2();
    for (int twice = 0; twice < 2; ++twice)
      part -= G_.transpose() * (U * inverse.cwiseProduct(U.transpose() * (G_ * part)));
    return part;
  }

 private:
  Eigen::MatrixXd G_, U_;
};

/// Gᵀ P = Q [R₁₁ R₁₂; 0 0]: the first columns of Gᵀ P are independent, and N = P [−R₁₁⁻¹ R₁₂; 1] spans the left kernel.
class SparseRowSpace final : public RowSpace {
 public:
  void decompose(const Sparse& transposed) override {
    Gt_ = transposed;
    const double largest = largest_singular_value();
    const double unit = std::max(1.0, largest);
    qr_.setPivotThreshold(std::sqrt(zero_singular_value * clear_singular_value) * unit);
    qr_.compute(Gt_);
    const Eigen::SparseMatrix<double, Eigen::RowMajor> by_rows = qr_.matrixR();  // there and back: sorted
    R_ = by_rows;
    find_left_kernel(static_cast<int>(qr_.rank()));
    sigma_ = VectorXd::Zero(std::min(Gt_.rows(), Gt_.cols()));
    for (int k = 0; k < rank_; ++k) sigma_[k] = std::min(std::abs(R_.coeff(k, k)), largest);
    std::sort(sigma_.data(), sigma_.data() + rank_, std::greater<>());
    if (rank_ > 0) {
      sigma_[0] = largest;
      // never so small that the rank would be taken for lower than that of R₁₁: then it is not clear, and said so
      const double smallest = std::max(smallest_singular_value(), 2 * zero_singular_value * unit);
      sigma_[rank_ - 1] = std::min(sigma_[rank_ - 1], smallest);
    }
    if (rank_ < sigma_.size()) sigma_[rank_] = largest_remainder();
  }

  void set_rank(int rank) override {
    rank = std::min(rank, static_cast<int>(qr_.rank()));
    if (rank != rank_) find_left_kernel(rank);  // mostly it is the one decompose() found
  }

  std::vector<int> independent() const override {
    const auto& order = qr_.colsPermutation().indices();
    return {order.data(), order.data() + rank_};
  }

  VectorXd outside(const VectorXd& x) const override {
    if (N_.cols() == 0) return VectorXd::Zero(x.size());
    return N_ * gram_.solve(N_.transpose() * x);
  }

  /// ξ − G₁ᵀ (G₁ G₁ᵀ)⁻¹ G₁ ξ with the independent rows G₁ = R₁₁ᵀ Q₁ᵀ.
  VectorXd in_kernel(const VectorXd& xi) const override {
    VectorXd part = xi;
    for (int twice = 0; twice < 2; ++twice) {
      const VectorXd all = Gt_.transpose() * part;
      VectorXd y(rank_), spread = VectorXd::Zero(Gt_.cols());
      for (int k = 0; k < rank_; ++k) y[k] = all[row(k)];
      solve_gram(y);
      for (int k = 0; k < rank_; ++k) spread[row(k)] = y[k];
      part -= Gt_ * spread;
    }
    return part;
  }

 private:
  void find_left_kernel(int rank) {
    rank_ = rank;
    const Index dependent = Gt_.cols() - rank_;
    R11_ = R_.topLeftCorner(rank_, rank_);
    Sparse X = R_.topRows(rank_).rightCols(dependent);
    R11_.triangularView<Eigen::Upper>().solveInPlace(X);
    std::vector<Eigen::Triplet<double>> entries;
    for (Index c = 0; c < dependent; ++c) {
      for (Sparse::InnerIterator i(X, c); i; ++i) entries.emplace_back(row(i.row()), c, -i.value());
      entries.emplace_back(row(rank_ + c), c, 1.0);
    }
    N_.resize(Gt_.cols(), dependent);
    N_.setFromTriplets(entries.begin(), entries.end());
    if (dependent > 0) gram_.compute(N_.transpose() * N_);
  }

  int row(Index k) const { return qr_.colsPermutation().indices()[k]; }

  /// (R₁₁ᵀ R₁₁)⁻¹ y.
  void solve_gram(VectorXd& y) const {
    R11_.transpose().triangularView<Eigen::Lower>().solveInPlace(y);
    R11_.triangularView<Eigen::Upper>().solveInPlace(y);
  }

  static VectorXd any_vector(Index size) {
    VectorXd x(size);
    for (Index k = 0; k < size; ++k) x[k] = std::sin(1.0 + 0.7 * static_cast<double>(k * k));
    return x.normalized();
  }

  double largest_singular_value() const {
    VectorXd x = any_vector(Gt_.cols());
    double sigma = 0;
    for (int step = 0; step < 8; ++step) {
      x = Gt_.transpose() * (Gt_ * x);
      const double norm = x.norm();
      if (norm == 0) break;
      sigma = std::sqrt(norm), x /= norm;
    }
    return sigma;
  }

  double smallest_singular_value() const {
    VectorXd x = any_vector(rank_);
    double sigma = 0;
    for (int step = 0; step < 8; ++step) {
      solve_gram(x);
      const double norm = x.norm();
      if (!(norm > 0) || !std::isfinite(norm)) return 0;
      sigma = 1 / std::sqrt(norm), x /= norm;
    }
    return sigma;
  }

  /// How far the vectors of N are from the left kernel.
  double largest_remainder() const {
    const Sparse rest = Gt_ * N_;
    double result = 0;
    for (Index c = 0; c < rest.cols(); ++c) result = std::max(result, rest.col(c).norm() / N_.col(c).norm());
    return result;
  }

  Sparse Gt_, R_, R11_, N_;
  Eigen::SparseQR<Sparse, Eigen::COLAMDOrdering<int>> qr_;
  Eigen::SimplicialLLT<Sparse> gram_;  // NᵀN
};

}  // namespace

std::unique_ptr<RowSpace> RowSpace::create_dense() { return std::make_unique<DenseRowSpace>(); }
std::unique_ptr<RowSpace> RowSpace::create_sparse() { return std::make_unique<SparseRowSpace>(); }

std::unique_ptr<RowSpace> RowSpace::create(Index rows, Index columns) {
  constexpr Index most_dense = 40;  // there sparse QR becomes faster, on ladders of four-bars
  return std::min(rows, columns) <= most_dense ? create_dense() : create_sparse();
}

}  // namespace lanc
