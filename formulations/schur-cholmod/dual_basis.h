// Orthonormal complement and dual basis of a few columns, by Householder reflections.
#pragma once

#include <array>

#include "lib/scalar/scalar.h"

namespace lanc {

/// Of f <= N independent columns C of length N: K (N × (N − f)) with Cᵀ K = 0, Kᵀ K = 1, and P = C (CᵀC)⁻¹ with
/// Cᵀ P = 1. Source: Golub & Van Loan, Matrix Computations, section 5.2.
template <class S, int N>
struct DualBasis {
  using Column = std::array<S, N>;
  std::array<Column, N> K, P;  // columns

  DualBasis(std::array<Column, N> C, int f) {
    std::array<Column, N> Q;  // columns of the product of the reflections
    for (int c = 0; c < N; ++c)
      for (int r = 0; r < N; ++r) Q[c][r] = S(r == c ? 1.0 : 0.0);
    for (int k = 0; k < f; ++k) {
      S square(0.0);
      for (int r = k; r < N; ++r) square += C[k][r] * C[k][r];
      const S norm = sqrt(square);
      const S alpha = C[k][k] > S(0.0) ? -norm : norm;
      Column v{};  // zero above k
      for (int r = k; r < N; ++r) v[r] = C[k][r];
      v[k] -= alpha;
      const S beta = S(-1.0) / (alpha * v[k]);  // 2 / vᵀv
      C[k][k] = alpha;
      for (int c = k + 1; c < f; ++c) {
        S along(0.0);
        for (int r = k; r < N; ++r) along += v[r] * C[c][r];
        along *= beta;
        for (int r = k; r < N; ++r) C[c][r] -= along * v[r];
      }
      for (int r = 0; r < N; ++r) {
        S along(0.0);
        for (int c = k; c < N; ++c) along += Q[c][r] * v[c];
        along *= beta;
        for (int c = k; c < N; ++c) Q[c][r] -= along * v[c];
      }
    }
    for (int c = f; c < N; ++c) K[c - f] = Q[c];
    for (int j = f - 1; j >= 0; --j) {  // P Rᵀ = the first f columns of Q
      P[j] = Q[j];
      for (int l = j + 1; l < f; ++l)
        for (int r = 0; r < N; ++r) P[j][r] -= P[l][r] * C[l][j];
      for (int r = 0; r < N; ++r) P[j][r] /= C[j][j];
    }
  }
};

}  // namespace lanc
