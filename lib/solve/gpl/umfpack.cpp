#include "lib/solve/gpl/umfpack.h"

#include <umfpack.h>

#include <new>

namespace lanc {

namespace {

class Umfpack final : public SparseSolver {
 public:
  Umfpack(const SparseView& sample, const SparseOptions& options) : size_(sample.size), wi_(sample.size) {
    umfpack_di_defaults(control_);
    control_[UMFPACK_PRL] = 0;
    if (options.order != EliminationOrder::library) {
      control_[UMFPACK_STRATEGY] = UMFPACK_STRATEGY_SYMMETRIC;
      control_[UMFPACK_SYM_PIVOT_TOLERANCE] = options.pivot_tolerance;
      control_[UMFPACK_ORDERING] =
          options.order == EliminationOrder::as_given ? UMFPACK_ORDERING_NONE : UMFPACK_ORDERING_AMD;
    }
    if (!options.refine) control_[UMFPACK_IRSTEP] = 0;
    w_.resize(options.refine ? 5 * std::size_t(size_) : size_);
    // Without values: the analysis must hold for every state, not for the zeros of the sample.
    void* symbolic = nullptr;
    const int status =
        umfpack_di_symbolic(size_, size_, sample.starts, sample.rows, nullptr, &symbolic, control_, info_);
    symbolic_.reset(symbolic);
    if (status != UMFPACK_OK) throw std::bad_alloc();
  }

  Factorisation factorise(const SparseView& matrix) override {
    numeric_.reset();
    void* numeric = nullptr;
    const int status =
        umfpack_di_numeric(matrix.starts, matrix.rows, matrix.values, symbolic_.get(), &numeric, control_, info_);
    numeric_.reset(numeric);
    if (status == UMFPACK_WARNING_singular_matrix) return {Factorisation::Result::singular, zero_pivot(), {}};
    if (status == UMFPACK_ERROR_out_of_memory) return {Factorisation::Result::failed, -1, "UMFPACK ran out of memory"};
    if (status < UMFPACK_OK) return {Factorisation::Result::failed, -1, "UMFPACK refused the matrix"};
    return {};
  }

  void solve(const SparseView& matrix, std::vector<double>& b, std::vector<double>& x) override {
    umfpack_di_wsolve(UMFPACK_A, matrix.starts, matrix.rows, matrix.values, x.data(), b.data(), numeric_.get(),
                      control_, info_, wi_.data(), w_.data());
  }

  FactorStatistics statistics() const override {
    if (!numeric_) return {};
    FactorStatistics result;
    result.nonzeros = static_cast<std::int64_t>(info_[UMFPACK_LNZ] + info_[UMFPACK_UNZ]) - size_;
    result.bytes = static_cast<std::int64_t>((info_[UMFPACK_NUMERIC_SIZE] + info_[UMFPACK_SYMBOLIC_SIZE]) *
                                             info_[UMFPACK_SIZE_OF_UNIT]);
    result.factorise_flops = info_[UMFPACK_FLOPS];
    if (info_[UMFPACK_SOLVE_FLOPS] > 0) result.solve_flops = info_[UMFPACK_SOLVE_FLOPS];
    return result;
  }

  void elimination(std::vector<int>& rows, std::vector<int>& columns) const override {
    rows.resize(size_), columns.resize(size_);
    int reciprocal = 0;
    umfpack_di_get_numeric(nullptr, nullptr, nullptr, nullptr, nullptr, nullptr, rows.data(), columns.data(), nullptr,
                           &reciprocal, nullptr, numeric_.get());
  }

 private:
  int zero_pivot() const {
    std::vector<int> columns(size_);
    std::vector<double> diagonal(size_);
    int reciprocal = 0;
    umfpack_di_get_numeric(nullptr, nullptr, nullptr, nullptr, nullptr, nullptr, nullptr, columns.data(),
                           diagonal.data(), &reciprocal, nullptr, numeric_.get());
    for (int k = 0; k < size_; ++k)
      if (diagonal[k] == 0) return columns[k];
    return -1;
  }

  struct FreeSymbolic {
    void operator()(void* symbolic) const { umfpack_di_free_symbolic(&symbolic); }
  };
  struct FreeNumeric {
    void operator()(void* numeric) const { umfpack_di_free_numeric(&numeric); }
  };
  int size_;
  double control_[UMFPACK_CONTROL], info_[UMFPACK_INFO] = {};
  std::unique_ptr<void, FreeSymbolic> symbolic_;
  std::unique_ptr<void, FreeNumeric> numeric_;
  std::vector<int> wi_;
  std::vector<double> w_;
};

}  // namespace

std::unique_ptr<SparseSolver> make_umfpack(const SparseView& sample, const SparseOptions& options) {
  return std::make_unique<Umfpack>(sample, options);
}

}  // namespace lanc
