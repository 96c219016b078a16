#include "control/dense.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace apc {
namespace {

//! Q R P = A by reflections: column k of `R` below its diagonal holds the k-th reflection's vector.
struct PivotedQr {
  Matrix R;                       // (m, n): the upper triangle, and below it the vectors
  std::vector<double> heads;      // first component of each vector
  std::vector<double> factors;    // 2 / squared norm of each vector, 0 for none
  std::vector<std::size_t> order;  // column of A that stands in each column of R
  std::size_t rank = 0;
};

double squared_below(const Matrix& R, std::size_t k, std::size_t j) {
  double sum = 0.0;
  for (std::size_t i = k; i < R.n_rows; ++i) sum += R(i, j) * R(i, j);
  return sum;
}

//! Apply the k-th reflection to a vector (m,) with a stride.
void reflect(const PivotedQr& qr, std::size_t k, double* x, std::size_t stride) {
  if (qr.factors[k] == 0.0) return;
  const std::size_t m = qr.R.n_rows;
  double along = qr.heads[k] * x[k * stride];
  for (std::size_t i = k + 1; i < m; ++i) along += qr.R(i, k) * x[i * stride];
  along *= qr.factors[k];
  x[k * stride] -= along * qr.heads[k];
  for (std::size_t i = k + 1; i < m; ++i) x[i * stride] -= along * qr.R(i, k);
}

PivotedQr pivoted_qr(const Matrix& A, double smallest) {
  const std::size_t m = A.n_rows, n = A.n_columns, most = std::min(m, n);
  PivotedQr qr{A, std::vector<double>(most), std::vector<double>(most), std::vector<std::size_t>(n), 0};
  std::iota(qr.order.begin(), qr.order.end(), std::size_t{0});
  Matrix& R = qr.R;
  for (std::size_t k = 0; k < most; ++k) {
    std::size_t pivot = k;
    double squares = -1.0;
    for (std::size_t j = k; j < n; ++j) {
      const double left = squared_below(R, k, j);
      if (left > squares) squares = left, pivot = j;
    }
    if (!(std::sqrt(squares) > smallest)) return qr;
    if (pivot != k) {
      for (std::size_t i = 0; i < m; ++i) std::swap(R(i, k), R(i, pivot));
      std::swap(qr.order[k], qr.order[pivot]);
    }
    const double norm = std::copysign(std::sqrt(squares), R(k, k));
    qr.heads[k] = R(k, k) + norm;
    qr.factors[k] = 1.0 / (norm * qr.heads[k]);  // 2 over the squared norm of the vector
    for (std::size_t j = k + 1; j < n; ++j) reflect(qr, k, R.values.data() + j, n);
    R(k, k) = -norm;
    ++qr.rank;
  }
  return qr;
}

}  // namespace

double dot(const double* a, const double* b, std::size_t n) {
  double sum = 0.0;
  for (std::size_t i = 0; i < n; ++i) sum += a[i] * b[i];
  return sum;
}

Matrix transposed(const Matrix& A) {
  Matrix B(A.n_columns, A.n_rows);
  for (std::size_t i = 0; i < A.n_rows; ++i)
    for (std::size_t j = 0; j < A.n_columns; ++j) B(j, i) = A(i, j);
  return B;
}

Matrix product(const Matrix& A, const Matrix& B) {
  Matrix C(A.n_rows, B.n_columns);
  for (std::size_t i = 0; i < A.n_rows; ++i)
    for (std::size_t k = 0; k < A.n_columns; ++k)
      for (std::size_t j = 0; j < B.n_columns; ++j) C(i, j) += A(i, k) * B(k, j);
  return C;
}

double largest_row(const Matrix& A) {
  double squares = 0.0;
  for (std::size_t i = 0; i < A.n_rows; ++i) squares = std::max(squares, dot(A.row(i), A.row(i), A.n_columns));
  return std::sqrt(squares);
}

std::vector<double> least_squares(const Matrix& A, const double* b, double smallest) {
  const std::size_t n = A.n_columns;
  std::vector<double> x(n, 0.0);
  if (A.n_rows == 0 || n == 0) return x;
  const PivotedQr qr = pivoted_qr(A, smallest);
  const std::size_t r = qr.rank;
  if (r == 0) return x;
  std::vector<double> c(b, b + A.n_rows);
  for (std::size_t k = 0; k < r; ++k) reflect(qr, k, c.data(), 1);
  if (r == n) {
    for (std::size_t i = n; i-- > 0;) {
      double left = c[i];
      for (std::size_t j = i + 1; j < n; ++j) left -= qr.R(i, j) * x[qr.order[j]];
      x[qr.order[i]] = left / qr.R(i, i);
    }
    return x;
  }
  // What is left is [R1 R2] y = c in the first r rows. Of these y, that of least norm is in the range of the
  // rows: with Q2 R3 = [R1 R2]^T, y = Q2 R3^-T c.
  Matrix rows(n, r);
  for (std::size_t i = 0; i < r; ++i)
    for (std::size_t j = i; j < n; ++j) rows(j, i) = qr.R(i, j);
  const PivotedQr of_rows = pivoted_qr(rows, 0.0);
  std::vector<double> y(n, 0.0);
  for (std::size_t i = 0; i < of_rows.rank; ++i) {
    double left = c[of_rows.order[i]];
    for (std::size_t k = 0; k < i; ++k) left -= of_rows.R(k, i) * y[k];
    y[i] = left / of_rows.R(i, i);
  }
  for (std::size_t k = of_rows.rank; k-- > 0;) reflect(of_rows, k, y.data(), 1);
  for (std::size_t j = 0; j < n; ++j) x[qr.order[j]] = y[j];
  return x;
}

Matrix null_space(const Matrix& A, double smallest) {
  const std::size_t n = A.n_columns;
  const PivotedQr qr = pivoted_qr(transposed(A), smallest);
  Matrix basis(n, n - qr.rank);
  for (std::size_t j = 0; j < basis.n_columns; ++j) {
    double* column = basis.values.data() + j;
    column[(qr.rank + j) * basis.n_columns] = 1.0;
    for (std::size_t k = qr.rank; k-- > 0;) reflect(qr, k, column, basis.n_columns);
  }
  return basis;
}

}  // namespace apc
