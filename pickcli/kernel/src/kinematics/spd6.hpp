//! \file
//! Symmetric positive definite systems of six equations, one for each freedom of a rigid body.
#pragma once

#include <array>
#include <cmath>

namespace apc {

using Vec6 = std::array<double, 6>;

//! Solves the symmetric positive definite system A x = b in place of b (Cholesky); reads and overwrites the
//! lower triangle of A. What is not positive definite comes out as not finite.
inline void solve_spd(double A[6][6], Vec6& b) {
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j <= i; ++j) {
      double sum = A[i][j];
      for (int k = 0; k < j; ++k) sum -= A[i][k] * A[j][k];
      A[i][j] = i == j ? std::sqrt(sum) : sum / A[j][j];
    }
  }
  for (int i = 0; i < 6; ++i) {
    for (int k = 0; k < i; ++k) b[i] -= A[i][k] * b[k];
    b[i] /= A[i][i];
  }
  for (int i = 5; i >= 0; --i) {
    for (int k = i + 1; k < 6; ++k) b[i] -= A[k][i] * b[k];
    b[i] /= A[i][i];
  }
}

}  // namespace apc
