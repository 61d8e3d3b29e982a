#include "lib/solve/gpl/spqr.h"

#include <SuiteSparseQR.hpp>
#include <algorithm>
#include <cmath>
#include <new>

namespace lanc {

namespace {

/// Relative to the largest column, which equilibration makes about 1: a column of R below is taken for zero.
constexpr double rank_tolerance = 1e-13;

class Spqr final : public SparseSolver {
 public:
  Spqr(const SparseView& sample, const SparseOptions& options)
      : starts_(sample.starts, sample.starts + sample.size + 1),
        rows_(sample.rows, sample.rows + sample.nonzeros()),
        values_(sample.nonzeros()),
        row_scale_(sample.size),
        column_scale_(sample.size),
        row_max_(sample.size),
        column_max_(sample.size),
        given_scale_(options.scale.empty() ? std::vector<double>(sample.size, 1.0) : options.scale) {
    common_.SPQR_nthreads = 1;
    common_.print = 0;
    cholmod_sparse A = wrap();
    const int order = options.order == EliminationOrder::as_given ? SPQR_ORDERING_FIXED
                      : options.order == EliminationOrder::amd    ? SPQR_ORDERING_AMD
                                                                  : SPQR_ORDERING_DEFAULT;
    factor_.reset(SuiteSparseQR_symbolic<double>(order, 1, &A, &common_));
    if (!factor_) throw std::bad_alloc();
  }

  Factorisation factorise(const SparseView& matrix) override {
    equilibrate(matrix);
    cholmod_sparse A = wrap();
    common_.SPQR_flopcount = 0;
    const int done = SuiteSparseQR_numeric<double>(rank_tolerance, &A, factor_.get(), &common_);
    flops_ = common_.SPQR_flopcount;
    if (!done || common_.status == CHOLMOD_OUT_OF_MEMORY)
      return {Factorisation::Result::failed, -1, "SPQR ran out of memory"};
    if (factor_->rank < matrix.size) return {Factorisation::Result::singular, dead_column(matrix.size), {}};
    return {};
  }

  void solve(const SparseView& matrix, std::vector<double>& b, std::vector<double>& x) override {
    for (int r = 0; r < matrix.size; ++r) b[r] *= row_scale_[r];
    cholmod_dense rhs{};
    rhs.nrow = rhs.d = rhs.nzmax = matrix.size;
    rhs.ncol = 1;
    rhs.x = b.data();
    rhs.xtype = CHOLMOD_REAL;
    rhs.dtype = CHOLMOD_DOUBLE;
    common_.SPQR_flopcount = 0;
    cholmod_dense* y = SuiteSparseQR_qmult<double>(SPQR_QTX, factor_.get(), &rhs, &common_);
    cholmod_dense* z = y ? SuiteSparseQR_solve<double>(SPQR_RETX_EQUALS_B, factor_.get(), y, &common_) : nullptr;
    solve_flops_ = common_.SPQR_flopcount;
    for (int c = 0; c < matrix.size; ++c)
      x[c] = z ? static_cast<const double*>(z->x)[c] * column_scale_[c] : std::nan("");  // no memory: nobody's answer
    cholmod_l_free_dense(&y, &common_);
    cholmod_l_free_dense(&z, &common_);
  }

  FactorStatistics statistics() const override {
    FactorStatistics result;
    result.nonzeros = common_.SPQR_istat[0] + common_.SPQR_istat[1];  // R, and the Householder vectors
    result.bytes = static_cast<std::int64_t>(common_.memory_inuse);
    result.factorise_flops = flops_;
    result.solve_flops = solve_flops_;
    return result;
  }

  void elimination(std::vector<int>& rows, std::vector<int>& columns) const override {
    const int n = static_cast<int>(row_scale_.size());
    rows.resize(n), columns.resize(n);
    for (int k = 0; k < n; ++k) rows[k] = k, columns[k] = column_of(k);
  }

 private:
  struct Common : cholmod_common {
    Common() { cholmod_l_start(this); }
    ~Common() { cholmod_l_finish(this); }
  };
  struct Free {
    cholmod_common* common;
    void operator()(SuiteSparseQR_factorization<double>* factor) const { SuiteSparseQR_free<double>(&factor, common); }
  };

  int column_of(int k) const { return factor_->Q1fill ? static_cast<int>(factor_->Q1fill[k]) : k; }

  int dead_column(int size) const {
    for (int k = 0; k < size; ++k)
      if (factor_->QRnum->Rdead[k]) return column_of(k);
    return -1;
  }

  /// Three sweeps of Ruiz (2001): divide rows and columns by the square root of their largest entry, rounded to a power
  /// of two, so that no digit of the matrix changes.
  void equilibrate(const SparseView& A) {
    std::copy_n(A.values, A.nonzeros(), values_.begin());
    row_scale_ = column_scale_ = given_scale_;
    for (int c = 0; c < A.size; ++c)
      for (int p = A.starts[c]; p < A.starts[c + 1]; ++p) values_[p] *= given_scale_[A.rows[p]] * given_scale_[c];
    for (int sweep = 0; sweep < 3; ++sweep) {
      row_max_.assign(A.size, 0.0), column_max_.assign(A.size, 0.0);
      for (int c = 0; c < A.size; ++c)
        for (int p = A.starts[c]; p < A.starts[c + 1]; ++p) {
          row_max_[A.rows[p]] = std::max(row_max_[A.rows[p]], std::abs(values_[p]));
          column_max_[c] = std::max(column_max_[c], std::abs(values_[p]));
        }
      const auto factor = [](double& m, double& scale) {
        scale *= m = m > 0 ? std::exp2(-std::rint(std::log2(m) / 2)) : 1.0;
      };
      for (int k = 0; k < A.size; ++k) factor(row_max_[k], row_scale_[k]), factor(column_max_[k], column_scale_[k]);
      for (int c = 0; c < A.size; ++c)
        for (int p = A.starts[c]; p < A.starts[c + 1]; ++p) values_[p] *= row_max_[A.rows[p]] * column_max_[c];
    }
  }

  cholmod_sparse wrap() {
    cholmod_sparse A{};
    A.nrow = A.ncol = row_scale_.size();
    A.nzmax = values_.size();
    A.p = starts_.data();
    A.i = rows_.data();
    A.x = values_.data();
    A.itype = CHOLMOD_LONG;
    A.xtype = CHOLMOD_REAL;
    A.dtype = CHOLMOD_DOUBLE;
    A.sorted = A.packed = 1;
    return A;
  }

  Common common_;
  std::vector<SuiteSparse_long> starts_, rows_;
  std::vector<double> values_, row_scale_, column_scale_, row_max_, column_max_, given_scale_;
  std::unique_ptr<SuiteSparseQR_factorization<double>, Free> factor_{nullptr, Free{&common_}};
  double flops_ = std::nan(""), solve_flops_ = std::nan("");
};

}  // namespace

std::unique_ptr<SparseSolver> make_spqr(const SparseView& sample, const SparseOptions& options) {
  return std::make_unique<Spqr>(sample, options);
}

}  // namespace lanc
