// Bodies of the templates of dense_algebra.h, and one macro that compiles them for a scalar. Private to lib/solve.
#pragma once

#include <Eigen/Cholesky>

#include "lib/solve/dense_algebra.h"

namespace lanc {
namespace dense_algebra {

template <class S>
auto lower(const DenseMatrix<S>& L) {
  return L.template triangularView<Eigen::Lower>();
}

template <class S>
auto upper(const DenseMatrix<S>& R) {
  return R.template triangularView<Eigen::Upper>();
}

}  // namespace dense_algebra

template <class S>
DenseMatrix<S> product(const DenseMatrix<S>& A, const DenseMatrix<S>& B) {
  return A * B;
}

template <class S>
DenseVector<S> product(const DenseMatrix<S>& A, VectorArgument<S> x) {
  return A * x;
}

template <class S>
DenseMatrix<S> transposed_product(const DenseMatrix<S>& A, const DenseMatrix<S>& B) {
  return A.transpose() * B;
}

template <class S>
DenseVector<S> transposed_product(const DenseMatrix<S>& A, VectorArgument<S> x) {
  return A.transpose() * x;
}

template <class S>
DenseMatrix<S> projected(const DenseMatrix<S>& A, const DenseMatrix<S>& Z) {
  return product(transposed_product(Z, A), Z);
}

template <class S>
void add_product(const DenseMatrix<S>& A, VectorArgument<S> x, DenseVector<S>& y) {
  y.noalias() += A * x;
}

template <class S>
void subtract_product(const DenseMatrix<S>& A, VectorArgument<S> x, DenseVector<S>& y) {
  y.noalias() -= A * x;
}

template <class S>
void add_transposed_product(const DenseMatrix<S>& A, VectorArgument<S> x, DenseVector<S>& y) {
  y.noalias() += A.transpose() * x;
}

template <class S>
void subtract_transposed_product(const DenseMatrix<S>& A, VectorArgument<S> x, DenseVector<S>& y) {
  y.noalias() -= A.transpose() * x;
}

template <class S>
void scale_both_sides(const DenseVector<S>& d, DenseMatrix<S>& A) {
  for (Eigen::Index c = 0; c < A.cols(); ++c)
    for (Eigen::Index r = 0; r < A.rows(); ++r) A(r, c) = d[r] * A(r, c) * d[c];
}

template <class S>
DenseMatrix<S> solve_lower(const DenseMatrix<S>& L, const DenseMatrix<S>& B) {
  DenseMatrix<S> X = B;
  dense_algebra::lower(L).solveInPlace(X);
  return X;
}

template <class S>
DenseVector<S> solve_lower(const DenseMatrix<S>& L, VectorArgument<S> b) {
  DenseVector<S> x = b;
  dense_algebra::lower(L).solveInPlace(x);
  return x;
}

template <class S>
DenseVector<S> solve_lower_transposed(const DenseMatrix<S>& L, VectorArgument<S> b) {
  DenseVector<S> x = b;
  L.transpose().template triangularView<Eigen::Upper>().solveInPlace(x);
  return x;
}

template <class S>
DenseVector<S> solve_upper(const DenseMatrix<S>& R, VectorArgument<S> b) {
  DenseVector<S> x = b;
  dense_algebra::upper(R).solveInPlace(x);
  return x;
}

template <class S>
DenseVector<S> solve_upper_transposed(const DenseMatrix<S>& R, VectorArgument<S> b) {
  DenseVector<S> x = b;
  R.transpose().template triangularView<Eigen::Lower>().solveInPlace(x);
  return x;
}

template <class S>
bool cholesky_in_place(DenseMatrix<S>& A) {
  return Eigen::LLT<Eigen::Ref<DenseMatrix<S>>>(A).info() == Eigen::Success;
}

template <class S>
void solve_cholesky_in_place(const DenseMatrix<S>& L, Eigen::Ref<DenseVector<S>> b) {
  dense_algebra::lower(L).solveInPlace(b);
  L.transpose().template triangularView<Eigen::Upper>().solveInPlace(b);
}

template <class S>
bool Cholesky<S>::compute(DenseMatrix<S> A) {
  L_ = std::move(A);
  return cholesky_in_place(L_);
}

template <class S>
DenseVector<S> Cholesky<S>::solve(DenseVector<S> b) const {
  solve_cholesky_in_place<S>(L_, b);
  return b;
}

template <class S>
void Lu<S>::compute(const DenseMatrix<S>& A) {
  lu_.compute(A);
}

template <class S>
DenseMatrix<S> Lu<S>::solve(const DenseMatrix<S>& B) const {
  return lu_.solve(B);
}

template <class S>
DenseVector<S> Lu<S>::solve(const DenseVector<S>& b) const {
  return lu_.solve(b);
}

template <class S>
DenseVector<S> Lu<S>::solve_transposed(const DenseVector<S>& b) const {
  return lu_.transpose().solve(b);
}

template <class S>
void Qr<S>::compute(const DenseMatrix<S>& A) {
  qr_.compute(A);
}

template <class S>
DenseMatrix<S> Qr<S>::Q() const {
  return qr_.householderQ();
}

template <class S>
DenseMatrix<S> Qr<S>::Q(Eigen::Index r) const {
  DenseMatrix<S> Q = DenseMatrix<S>::Identity(qr_.rows(), r);
  Q.applyOnTheLeft(qr_.householderQ());
  return Q;
}

template <class S>
DenseMatrix<S> Qr<S>::R(Eigen::Index r) const {
  return qr_.matrixQR().topRows(r).template triangularView<Eigen::Upper>();
}

template <class S>
DenseVector<S> Qr<S>::times_Q(const DenseVector<S>& x) const {
  return qr_.householderQ() * x;
}

template <class S>
void PivotedQr<S>::compute(const DenseMatrix<S>& A) {
  qr_.compute(A);
}

template <class S>
DenseMatrix<S> PivotedQr<S>::Q(Eigen::Index r) const {
  DenseMatrix<S> Q = DenseMatrix<S>::Identity(qr_.rows(), r);
  Q.applyOnTheLeft(qr_.householderQ());
  return Q;
}

template <class S>
DenseVector<S> chosen(const DenseVector<S>& x, const std::vector<int>& which) {
  DenseVector<S> result(which.size());
  for (std::size_t k = 0; k < which.size(); ++k) result[k] = x[which[k]];
  return result;
}

template <class S>
DenseMatrix<S> chosen_columns(const DenseMatrix<S>& A, const std::vector<int>& which) {
  DenseMatrix<S> result(A.rows(), which.size());
  for (std::size_t k = 0; k < which.size(); ++k)
    for (Eigen::Index r = 0; r < A.rows(); ++r) result(r, k) = A(r, which[k]);
  return result;
}

template <class S>
DenseMatrix<S> chosen_rows(const DenseMatrix<S>& A, const std::vector<int>& which) {
  DenseMatrix<S> result(which.size(), A.cols());
  for (Eigen::Index c = 0; c < A.cols(); ++c)
    for (std::size_t k = 0; k < which.size(); ++k) result(k, c) = A(which[k], c);
  return result;
}

template <class S>
void put(VectorArgument<S> x, const std::vector<int>& which, DenseVector<S>& y) {
  for (std::size_t k = 0; k < which.size(); ++k) y[which[k]] = x[k];
}

}  // namespace lanc

/// Everything for one scalar, once in the library.
#define LANC_DENSE_ALGEBRA(S)                                                                           \
  template DenseMatrix<S> product(const DenseMatrix<S>&, const DenseMatrix<S>&);                        \
  template DenseVector<S> product(const DenseMatrix<S>&, VectorArgument<S>);                            \
  template DenseMatrix<S> transposed_product(const DenseMatrix<S>&, const DenseMatrix<S>&);             \
  template DenseVector<S> transposed_product(const DenseMatrix<S>&, VectorArgument<S>);                 \
  template DenseMatrix<S> projected(const DenseMatrix<S>&, const DenseMatrix<S>&);                      \
  template void add_product(const DenseMatrix<S>&, VectorArgument<S>, DenseVector<S>&);                 \
  template void subtract_product(const DenseMatrix<S>&, VectorArgument<S>, DenseVector<S>&);            \
  template void add_transposed_product(const DenseMatrix<S>&, VectorArgument<S>, DenseVector<S>&);      \
  template void subtract_transposed_product(const DenseMatrix<S>&, VectorArgument<S>, DenseVector<S>&); \
  template void scale_both_sides(const DenseVector<S>&, DenseMatrix<S>&);                               \
  template DenseMatrix<S> solve_lower(const DenseMatrix<S>&, const DenseMatrix<S>&);                    \
  template DenseVector<S> solve_lower(const DenseMatrix<S>&, VectorArgument<S>);                        \
  template DenseVector<S> solve_lower_transposed(const DenseMatrix<S>&, VectorArgument<S>);             \
  template DenseVector<S> solve_upper(const DenseMatrix<S>&, VectorArgument<S>);                        \
  template DenseVector<S> solve_upper_transposed(const DenseMatrix<S>&, VectorArgument<S>);             \
  template bool cholesky_in_place(DenseMatrix<S>&);                                                     \
  template void solve_cholesky_in_place(const DenseMatrix<S>&, Eigen::Ref<DenseVector<S>>);             \
  template DenseVector<S> chosen(const DenseVector<S>&, const std::vector<int>&);                       \
  template DenseMatrix<S> chosen_columns(const DenseMatrix<S>&, const std::vector<int>&);               \
  template DenseMatrix<S> chosen_rows(const DenseMatrix<S>&, const std::vector<int>&);                  \
  template void put(VectorArgument<S>, const std::vector<int>&, DenseVector<S>&);                       \
  template class Cholesky<S>;                                                                           \
  template class Lu<S>;                                                                                 \
  template class Qr<S>;                                                                                 \
  template class PivotedQr<S>;
