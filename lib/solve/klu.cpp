#include "lib/solve/klu.h"

#include <klu.h>

#include <algorithm>
#include <new>
#include <span>
#include <type_traits>

namespace lanc {

namespace {

/// KLU exists twice. With 64-bit indices the innermost loop of Debian's has ten instructions instead of eleven, and
/// chains of 100 and 1000 bodies are refactored in 0.87 and 0.8 of the time (Zen 4); from 10 000 bodies on, memory
/// decides.
struct Indices32 {
  using Index = int;
  using Common = klu_common;
  using Symbolic = klu_symbolic;
  using Numeric = klu_numeric;
  static constexpr auto defaults = klu_defaults;
  static constexpr auto analyze = klu_analyze;
  static constexpr auto analyze_given = klu_analyze_given;
  static constexpr auto factor = klu_factor;
  static constexpr auto refactor = klu_refactor;
  static constexpr auto solve = klu_solve;
  static constexpr auto tsolve = klu_tsolve;
  static constexpr auto flops = klu_flops;
  static constexpr auto free_symbolic = klu_free_symbolic;
  static constexpr auto free_numeric = klu_free_numeric;
};
struct Indices64 {
  using Index = SuiteSparse_long;
  using Common = klu_l_common;
  using Symbolic = klu_l_symbolic;
  using Numeric = klu_l_numeric;
  static constexpr auto defaults = klu_l_defaults;
  static constexpr auto analyze = klu_l_analyze;
  static constexpr auto analyze_given = klu_l_analyze_given;
  static constexpr auto factor = klu_l_factor;
  static constexpr auto refactor = klu_l_refactor;
  static constexpr auto solve = klu_l_solve;
  static constexpr auto tsolve = klu_l_tsolve;
  static constexpr auto flops = klu_l_flops;
  static constexpr auto free_symbolic = klu_l_free_symbolic;
  static constexpr auto free_numeric = klu_l_free_numeric;
};

/// KLU takes pointers to non-const, but only reads. Its indices are those of the matrix, or a copy of them.
template <class Index>
class Indices {
 public:
  explicit Indices(std::span<const int> values) : given_(values) {
    if constexpr (!std::is_same_v<Index, int>) copy_.assign(values.begin(), values.end());
  }
  Index* data() {
    if constexpr (std::is_same_v<Index, int>)
      return const_cast<int*>(given_.data());
    else
      return copy_.data();
  }

 private:
  std::span<const int> given_;
  std::vector<Index> copy_;
};

template <class Library>
class Klu final : public SparseSolver {
  using Index = typename Library::Index;

 public:
  Klu(const SparseView& sample, const SparseOptions& options)
      : reuse_pivots_(options.pivot_tolerance == 0),
        symmetric_(options.symmetric),
        starts_({sample.starts, static_cast<std::size_t>(sample.size) + 1}),
        rows_({sample.rows, static_cast<std::size_t>(sample.nonzeros())}) {
    Library::defaults(&common_);
    common_.tol = options.pivot_tolerance;
    if (options.order != EliminationOrder::library) {
      common_.btf = 0;
      common_.scale = -1;  // none; also skips a check of the input at every call
    }
    common_.initmem = 1.2;  // the default of 10 asks for ten times the matrix when the order is given
    common_.initmem_amd = 1.2;
    if (options.order == EliminationOrder::as_given) {
      Indices<Index> rows(options.pivot_rows), columns(options.pivot_columns);
      const bool listed = !options.pivot_rows.empty();
      symbolic_.reset(Library::analyze_given(sample.size, starts_.data(), rows_.data(), listed ? rows.data() : nullptr,
                                             listed ? columns.data() : nullptr, &common_));
    } else {
      symbolic_.reset(Library::analyze(sample.size, starts_.data(), rows_.data(), &common_));
    }
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
      Library::refactor(starts_.data(), rows_.data(), values(matrix), symbolic_.get(), numeric_.get(), &common_);
    else
      factor(matrix);
    if (common_.status == KLU_SINGULAR)
      return {Factorisation::Result::singular, static_cast<int>(common_.singular_col), {}};
    if (common_.status == KLU_OUT_OF_MEMORY) return {Factorisation::Result::failed, -1, "KLU ran out of memory"};
    if (common_.status < KLU_OK) return {Factorisation::Result::failed, -1, "KLU refused the matrix"};
    return {};
  }

  void solve(const SparseView&, std::vector<double>& b, std::vector<double>& x) override {
    std::swap(b, x);
    // A column is then a sum kept in a register; klu_solve adds to memory product by product: 1.3 times the time.
    if (symmetric_)
      Library::tsolve(symbolic_.get(), numeric_.get(), symbolic_->n, 1, x.data(), &common_);
    else
      Library::solve(symbolic_.get(), numeric_.get(), symbolic_->n, 1, x.data(), &common_);
  }

  FactorStatistics statistics() const override {
    if (!numeric_) return {};
    FactorStatistics result;
    // L and U of the diagonal blocks with one diagonal, and what is outside the blocks
    result.nonzeros = std::int64_t(numeric_->lnz) + numeric_->unz - symbolic_->n + numeric_->nzoff;
    result.bytes = static_cast<std::int64_t>(common_.memusage);
    Library::flops(symbolic_.get(), numeric_.get(), &common_);
    result.factorise_flops = common_.flops;
    // a multiplication and a subtraction for each entry, a division for each pivot; scaling apart
    result.solve_flops = 2.0 * static_cast<double>(result.nonzeros) - static_cast<double>(symbolic_->n);
    return result;
  }

  void elimination(std::vector<int>& rows, std::vector<int>& columns) const override {
    rows.assign(numeric_->Pnum, numeric_->Pnum + symbolic_->n);
    columns.assign(symbolic_->Q, symbolic_->Q + symbolic_->n);
  }

 private:
  static double* values(const SparseView& matrix) { return const_cast<double*>(matrix.values); }
  void factor(const SparseView& matrix) {
    numeric_.reset();
    numeric_.reset(Library::factor(starts_.data(), rows_.data(), values(matrix), symbolic_.get(), &common_));
  }

  struct Free {
    typename Library::Common* common;
    void operator()(typename Library::Symbolic* symbolic) const { Library::free_symbolic(&symbolic, common); }
    void operator()(typename Library::Numeric* numeric) const { Library::free_numeric(&numeric, common); }
  };
  bool reuse_pivots_, symmetric_;
  Indices<Index> starts_, rows_;
  mutable typename Library::Common common_;
  std::unique_ptr<typename Library::Symbolic, Free> symbolic_{nullptr, Free{&common_}};
  std::unique_ptr<typename Library::Numeric, Free> numeric_{nullptr, Free{&common_}};
};

}  // namespace

std::unique_ptr<SparseSolver> make_klu(const SparseView& sample, const SparseOptions& options) {
  constexpr int in_cache = 1 << 15;  // unknowns: 2500 bodies, factors of 6 MB
  if (sample.size < in_cache) return std::make_unique<Klu<Indices64>>(sample, options);
  return std::make_unique<Klu<Indices32>>(sample, options);
}

}  // namespace lanc
