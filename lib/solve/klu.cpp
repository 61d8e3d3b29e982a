#include "lib/solve/klu.h"

#include <klu.h>

#include <algorithm>
#include <new>
#include <type_traits>

namespace lanc {

namespace {

class Klu final : public SparseSolver {
 public:
  Klu(const SparseView& sample, const SparseOptions& options) : reuse_pivots_(options.pivot_tolerance == 0) {
    klu_defaults(&common_);
    common_.tol = options.pivot_tolerance;
    if (options.order != EliminationOrder::library) {
      common_.btf = 0;
      common_.scale = -1;  // none; also skips a check of the input at every call
    }
    common_.initmem = 1.2;  // the default of 10 asks for ten times the matrix when the order is given
    common_.initmem_amd = 1.2;
    // klu_analyze* take int*, but only read
    int* starts = const_cast<int*>(sample.starts);
    int* rows = const_cast<int*>(sample.rows);
    symbolic_.reset(options.order == EliminationOrder::as_given
                        ? klu_analyze_given(sample.size, starts, rows, nullptr, nullptr, &common_)
                        : klu_analyze(sample.size, starts, rows, &common_));
    if (!symbolic_) throw std::bad_alloc();
    if (reuse_pivots_) {
      // Pivots are chosen by place, not by size, so those of the sample are those of every state.
      common_.halt_if_singular = 0;
      factor(sample);
      if (!numeric_) throw std::bad_alloc();
      common_.halt_if_singular = 1;
    }
  }

  Factorisation factorise(const SparseView& matrix) override {
    if (reuse_pivots_)
      klu_refactor(const_cast<int*>(matrix.starts), const_cast<int*>(matrix.rows), const_cast<double*>(matrix.values),
                   symbolic_.get(), numeric_.get(), &common_);
    else
      factor(matrix);
    if (common_.status == KLU_SINGULAR) return {Factorisation::Result::singular, common_.singular_col, {}};
    if (common_.status == KLU_OUT_OF_MEMORY) return {Factorisation::Result::failed, -1, "KLU ran out of memory"};
    if (common_.status < KLU_OK) return {Factorisation::Result::failed, -1, "KLU refused the matrix"};
    return {};
  }

  void solve(const SparseView&, std::vector<double>& b, std::vector<double>& x) override {
    std::copy(b.begin(), b.end(), x.begin());
    klu_solve(symbolic_.get(), numeric_.get(), symbolic_->n, 1, x.data(), &common_);
  }

  FactorStatistics statistics() const override {
    if (!numeric_) return {};
    FactorStatistics result;
    // L and U of the diagonal blocks with one diagonal, and what is outside the blocks
    result.nonzeros = std::int64_t(numeric_->lnz) + numeric_->unz - symbolic_->n + numeric_->nzoff;
    result.bytes = static_cast<std::int64_t>(common_.memusage);
    klu_flops(symbolic_.get(), numeric_.get(), &common_);
    result.factorise_flops = common_.flops;
    // a multiplication and a subtraction for each entry, a division for each pivot; scaling apart
    result.solve_flops = 2.0 * static_cast<double>(result.nonzeros) - symbolic_->n;
    return result;
  }

  void elimination(std::vector<int>& rows, std::vector<int>& columns) const override {
    rows.assign(numeric_->Pnum, numeric_->Pnum + symbolic_->n);
    columns.assign(symbolic_->Q, symbolic_->Q + symbolic_->n);
  }

 private:
  void factor(const SparseView& matrix) {
    numeric_.reset();
    numeric_.reset(klu_factor(const_cast<int*>(matrix.starts), const_cast<int*>(matrix.rows),
                              const_cast<double*>(matrix.values), symbolic_.get(), &common_));
  }

  struct Free {
    klu_common* common;
    void operator()(klu_symbolic* symbolic) const { klu_free_symbolic(&symbolic, common); }
    void operator()(klu_numeric* numeric) const { klu_free_numeric(&numeric, common); }
  };
  bool reuse_pivots_;
  mutable klu_common common_;
  std::unique_ptr<klu_symbolic, Free> symbolic_{nullptr, Free{&common_}};
  std::unique_ptr<klu_numeric, Free> numeric_{nullptr, Free{&common_}};
};

}  // namespace

std::unique_ptr<SparseSolver> make_klu(const SparseView& sample, const SparseOptions& options) {
  return std::make_unique<Klu>(sample, options);
}

}  // namespace lanc
