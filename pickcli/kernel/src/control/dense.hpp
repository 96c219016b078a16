//! \file
//! Small dense matrices: Householder QR with column pivoting, least squares of least norm, and null spaces.
#pragma once

#include <cstddef>
#include <vector>

namespace apc {

//! A matrix, row-major.
struct Matrix {
  std::size_t n_rows = 0, n_columns = 0;
  std::vector<double> values;

  Matrix() = default;
  Matrix(std::size_t rows, std::size_t columns) : n_rows(rows), n_columns(columns), values(rows * columns) {}

  double* row(std::size_t i) { return values.data() + i * n_columns; }
  const double* row(std::size_t i) const { return values.data() + i * n_columns; }
  double& operator()(std::size_t i, std::size_t j) { return values[i * n_columns + j]; }
  double operator()(std::size_t i, std::size_t j) const { return values[i * n_columns + j]; }

  //! Append a row (n_columns,).
  void append(const double* from) {
    values.insert(values.end(), from, from + n_columns);
    ++n_rows;
  }
};

double dot(const double* a, const double* b, std::size_t n);
Matrix transposed(const Matrix& A);
Matrix product(const Matrix& A, const Matrix& B);

//! The x (n,) of least norm among those that minimize the norm of A x - b, b (m,).
//! Directions in which A is not over `smallest` count as its null space.
//! After Golub and Van Loan, Matrix Computations, 4th edition, section 5.5.
std::vector<double> least_squares(const Matrix& A, const double* b, double smallest);

//! An orthonormal basis (n, n - rank) of the null space of A (m, n), of directions in which it is not over `smallest`.
Matrix null_space(const Matrix& A, double smallest);

//! The largest norm of a row.
double largest_row(const Matrix& A);

}  // namespace apc
