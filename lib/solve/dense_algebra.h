// Dense algebra on the scalars formulations run on: products, triangular solutions and factorisations of whole
// matrices, by Eigen and compiled once. The same written as Eigen's expressions costs every file that does it 10 to 60
// s of compilation, three scalars each (README, Decisions). Private to the library and its formulations.
//
// Operations (on Count) are those of Eigen's expressions named in the comments. Sizes are Eigen's affair: assertions in
// debug builds. Tested by tests/lib/dense_algebra_test.cpp.
#pragma once

#include <Eigen/Core>
#include <Eigen/LU>
#include <Eigen/QR>
#include <type_traits>
#include <vector>

#include "lib/scalar/count_eigen.h"

namespace lanc {

template <class S>
using DenseMatrix = Eigen::Matrix<S, Eigen::Dynamic, Eigen::Dynamic>;
template <class S>
using DenseVector = Eigen::Matrix<S, Eigen::Dynamic, 1>;
/// An argument that may be any expression of vectors; S comes from the matrix beside it.
template <class S>
using VectorArgument = const std::type_identity_t<DenseVector<S>>&;

/// A B and A x.
template <class S>
DenseMatrix<S> product(const DenseMatrix<S>& A, const DenseMatrix<S>& B);
template <class S>
DenseVector<S> product(const DenseMatrix<S>& A, VectorArgument<S> x);
/// Aᵀ B and Aᵀ x.
template <class S>
DenseMatrix<S> transposed_product(const DenseMatrix<S>& A, const DenseMatrix<S>& B);
template <class S>
DenseVector<S> transposed_product(const DenseMatrix<S>& A, VectorArgument<S> x);
/// Zᵀ A Z.
template <class S>
DenseMatrix<S> projected(const DenseMatrix<S>& A, const DenseMatrix<S>& Z);
/// y += A x, y −= A x, y += Aᵀ x, y −= Aᵀ x, without a vector between.
template <class S>
void add_product(const DenseMatrix<S>& A, VectorArgument<S> x, DenseVector<S>& y);
template <class S>
void subtract_product(const DenseMatrix<S>& A, VectorArgument<S> x, DenseVector<S>& y);
template <class S>
void add_transposed_product(const DenseMatrix<S>& A, VectorArgument<S> x, DenseVector<S>& y);
template <class S>
void subtract_transposed_product(const DenseMatrix<S>& A, VectorArgument<S> x, DenseVector<S>& y);
/// D A D, D = diag(d), in place.
template <class S>
void scale_both_sides(const DenseVector<S>& d, DenseMatrix<S>& A);

/// L⁻¹ B, L⁻¹ b and L⁻ᵀ b; the upper triangle of L is not read.
template <class S>
DenseMatrix<S> solve_lower(const DenseMatrix<S>& L, const DenseMatrix<S>& B);
template <class S>
DenseVector<S> solve_lower(const DenseMatrix<S>& L, VectorArgument<S> b);
template <class S>
DenseVector<S> solve_lower_transposed(const DenseMatrix<S>& L, VectorArgument<S> b);
/// R⁻¹ b and R⁻ᵀ b; the lower triangle of R is not read.
template <class S>
DenseVector<S> solve_upper(const DenseMatrix<S>& R, VectorArgument<S> b);
template <class S>
DenseVector<S> solve_upper_transposed(const DenseMatrix<S>& R, VectorArgument<S> b);

/// The lower triangle of a symmetric matrix becomes that of its Cholesky factor L. False when it is not positive
/// definite. Allocates nothing.
template <class S>
[[nodiscard]] bool cholesky_in_place(DenseMatrix<S>& A);
/// b becomes (L Lᵀ)⁻¹ b. Allocates nothing.
template <class S>
void solve_cholesky_in_place(const DenseMatrix<S>& L, Eigen::Ref<DenseVector<S>> b);

/// A = L Lᵀ.
template <class S>
class Cholesky {
 public:
  /// False when A is not positive definite. O(n³ / 3).
  [[nodiscard]] bool compute(DenseMatrix<S> A);
  DenseVector<S> solve(DenseVector<S> b) const;

 private:
  DenseMatrix<S> L_;
};

/// P A = L U, with partial pivoting.
template <class S>
class Lu {
 public:
  void compute(const DenseMatrix<S>& A);
  DenseMatrix<S> solve(const DenseMatrix<S>& B) const;
  DenseVector<S> solve(const DenseVector<S>& b) const;
  DenseVector<S> solve_transposed(const DenseVector<S>& b) const;

 private:
  Eigen::PartialPivLU<DenseMatrix<S>> lu_;
};

/// A = Q R by reflections, Q square.
template <class S>
class Qr {
 public:
  void compute(const DenseMatrix<S>& A);
  DenseMatrix<S> Q() const;
  /// Its first r columns.
  DenseMatrix<S> Q(Eigen::Index r) const;
  /// The first r rows of R, square.
  DenseMatrix<S> R(Eigen::Index r) const;
  DenseVector<S> times_Q(const DenseVector<S>& x) const;

 private:
  Eigen::HouseholderQR<DenseMatrix<S>> qr_;
};

/// A P = Q R, the column of the largest remainder first.
template <class S>
class PivotedQr {
 public:
  void compute(const DenseMatrix<S>& A);
  /// The first r columns of Q.
  DenseMatrix<S> Q(Eigen::Index r) const;

 private:
  Eigen::ColPivHouseholderQR<DenseMatrix<S>> qr_;
};

/// x_k for the k in `which`, and columns of A.
template <class S>
DenseVector<S> chosen(const DenseVector<S>& x, const std::vector<int>& which);
template <class S>
DenseMatrix<S> chosen_columns(const DenseMatrix<S>& A, const std::vector<int>& which);
template <class S>
DenseMatrix<S> chosen_rows(const DenseMatrix<S>& A, const std::vector<int>& which);
/// y_k = x for the k in `which`; others stay.
template <class S>
void put(VectorArgument<S> x, const std::vector<int>& which, DenseVector<S>& y);

extern template class Cholesky<double>;
extern template class Cholesky<long double>;
extern template class Cholesky<Count>;
extern template class Lu<double>;
extern template class Lu<long double>;
extern template class Lu<Count>;
extern template class Qr<double>;
extern template class Qr<long double>;
extern template class Qr<Count>;
extern template class PivotedQr<double>;
extern template class PivotedQr<long double>;
extern template class PivotedQr<Count>;

}  // namespace lanc
