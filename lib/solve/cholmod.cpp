#include "lib/solve/cholmod.h"

#include <cholmod.h>

#include <algorithm>
#include <new>

namespace lanc {

namespace {

class Cholmod final : public CholmodSolver {
 public:
  Cholmod(const SparseView& sample, const SparseOptions& options) {
    common_.supernodal = CHOLMOD_SIMPLICIAL;
    common_.final_ll = 0;
    common_.print = 0;
    common_.quick_return_if_not_posdef = 0;
    if (options.order != EliminationOrder::library) {
      common_.nmethods = 1;
      const bool given = options.order == EliminationOrder::as_given;
      common_.method[0].ordering = given ? CHOLMOD_NATURAL : CHOLMOD_AMD;
      common_.postorder = given ? 0 : 1;
    }
    cholmod_sparse A = wrap(sample);
    factor_.reset(cholmod_analyze(&A, &common_));
    if (!factor_) throw std::bad_alloc();
    // once with the sample, so that everything is allocated; with an order of CHOLMOD's own it may break down
    std::vector<double> b(sample.size, 0.0), x(sample.size);
    factorise(sample);
    if (common_.status == CHOLMOD_OUT_OF_MEMORY) throw std::bad_alloc();
    if (common_.status == CHOLMOD_OK) solve(sample, b, x);
  }

  Factorisation factorise(const SparseView& matrix) override {
    cholmod_sparse A = wrap(matrix);
    cholmod_factorize(&A, factor_.get(), &common_);  // returns TRUE for a zero pivot, too
    if (common_.status == CHOLMOD_OUT_OF_MEMORY)
      return {Factorisation::Result::failed, -1, "CHOLMOD ran out of memory"};
    if (common_.status < CHOLMOD_OK) return {Factorisation::Result::failed, -1, "CHOLMOD refused the matrix"};
    if (factor_->minor < factor_->n)
      return {Factorisation::Result::singular, static_cast<const int*>(factor_->Perm)[factor_->minor], {}};
    return {};
  }

  void solve(const SparseView& matrix, std::vector<double>& b, std::vector<double>& x) override {
    cholmod_dense rhs = wrap(matrix.size, b.data());
    cholmod_solve2(CHOLMOD_A, factor_.get(), &rhs, nullptr, &solution_.value, nullptr, &solution_.y, &solution_.e,
                   &common_);
    std::copy_n(static_cast<const double*>(solution_.value->x), matrix.size, x.begin());
  }

  FactorStatistics statistics() const override {
    FactorStatistics result;
    const int* counts = static_cast<const int*>(factor_->nz);
    for (std::size_t j = 0; counts && j < factor_->n; ++j) result.nonzeros += counts[j];
    result.bytes = static_cast<std::int64_t>(common_.memory_inuse);
    result.factorise_flops = common_.rowfacfl;
    // L z = b and Lᵀ x = z: multiply and add for each entry below the diagonal, twice; and one division by D
    result.solve_flops = 4.0 * static_cast<double>(result.nonzeros - static_cast<std::int64_t>(factor_->n)) +
                         static_cast<double>(factor_->n);
    return result;
  }

  void elimination(std::vector<int>& rows, std::vector<int>& columns) const override {
    const int* order = static_cast<const int*>(factor_->Perm);
    rows.assign(order, order + factor_->n);
    columns = rows;
  }

  LdlFactors factors() const override {
    const std::size_t n = factor_->n;
    return {{static_cast<const int*>(factor_->p), n + 1},
            {static_cast<const int*>(factor_->nz), n},
            {static_cast<const int*>(factor_->Perm), n},
            static_cast<const int*>(factor_->i),
            static_cast<const double*>(factor_->x)};
  }

 private:
  struct Common : cholmod_common {
    Common() { cholmod_start(this); }
    ~Common() { cholmod_finish(this); }
  };
  struct Free {
    cholmod_common* common;
    void operator()(cholmod_factor* factor) const { cholmod_free_factor(&factor, common); }
  };
  struct Vectors {  // kept from solve to solve by cholmod_solve2
    cholmod_common* common;
    cholmod_dense *value = nullptr, *y = nullptr, *e = nullptr;
    explicit Vectors(cholmod_common* c) : common(c) {}
    ~Vectors() {
      for (cholmod_dense* d : {value, y, e}) cholmod_free_dense(&d, common);
    }
  };

  static cholmod_sparse wrap(const SparseView& matrix) {
    cholmod_sparse A{};
    A.nrow = A.ncol = matrix.size;
    A.nzmax = matrix.nonzeros();
    A.p = const_cast<int*>(matrix.starts);  // CHOLMOD has no const, but only reads
    A.i = const_cast<int*>(matrix.rows);
    A.x = const_cast<double*>(matrix.values);
    A.stype = 1;
    A.itype = CHOLMOD_INT;
    A.xtype = CHOLMOD_REAL;
    A.dtype = CHOLMOD_DOUBLE;
    A.sorted = A.packed = 1;
    return A;
  }
  static cholmod_dense wrap(int size, double* values) {
    cholmod_dense d{};
    d.nrow = d.d = d.nzmax = size;
    d.ncol = 1;
    d.x = values;
    d.xtype = CHOLMOD_REAL;
    d.dtype = CHOLMOD_DOUBLE;
    return d;
  }

  Common common_;
  std::unique_ptr<cholmod_factor, Free> factor_{nullptr, Free{&common_}};
  Vectors solution_{&common_};
};

}  // namespace

std::unique_ptr<CholmodSolver> make_cholmod(const SparseView& sample, const SparseOptions& options) {
  return std::make_unique<Cholmod>(sample, options);
}

}  // namespace lanc
