//! \file
//! Least squares of least norm, null spaces, and levels of strict priority.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "control/hierarchical_qp.hpp"
#include "random_cases.hpp"

using apc::Matrix;
using apc::PriorityLevel;
using apc::test::Random;

namespace {

constexpr double kRank = 1e-9;

//! A matrix (m, n) of a rank.
Matrix random_matrix(Random& random, std::size_t m, std::size_t n, std::size_t rank) {
  Matrix left(m, rank), right(rank, n);
  for (double& each : left.values) each = random.between(-1.0, 1.0);
  for (double& each : right.values) each = random.between(-1.0, 1.0);
  return apc::product(left, right);
}

double largest(const Matrix& A) {
  double most = 0.0;
  for (double each : A.values) most = std::max(most, std::abs(each));
  return most;
}

}  // namespace

TEST_CASE("a null space is orthonormal, and all that a matrix maps to nothing") {
  Random random(1);
  for (int k = 0; k < 200; ++k) {
    const std::size_t m = static_cast<std::size_t>(random.below(8)), n = 1 + static_cast<std::size_t>(random.below(8));
    const std::size_t rank = std::min({m, n, static_cast<std::size_t>(random.below(6))});
    const Matrix A = random_matrix(random, m, n, rank), N = apc::null_space(A, kRank);
    CHECK(N.n_columns == n - rank);
    CHECK_LE(largest(apc::product(A, N)), 1e-12);
    Matrix gram = apc::product(apc::transposed(N), N);
    for (std::size_t i = 0; i < gram.n_rows; ++i) gram(i, i) -= 1.0;
    CHECK_LE(largest(gram), 1e-13);
  }
}

TEST_CASE("least squares leave a residual across the range, and nothing in the null space") {
  Random random(2);
  for (int k = 0; k < 200; ++k) {
    const std::size_t m = 1 + static_cast<std::size_t>(random.below(9)), n = 1 + static_cast<std::size_t>(random.below(8));
    const std::size_t rank = std::min({m, n, 1 + static_cast<std::size_t>(random.below(6))});
    const Matrix A = random_matrix(random, m, n, rank);
    Matrix b(m, 1), x(n, 1);
    for (double& each : b.values) each = random.between(-1.0, 1.0);
    x.values = apc::least_squares(A, b.values.data(), kRank);
    Matrix residual = apc::product(A, x);
    for (std::size_t i = 0; i < m; ++i) residual.values[i] -= b.values[i];
    CHECK_LE(largest(apc::product(apc::transposed(A), residual)), 1e-10);
    CHECK_LE(largest(apc::product(apc::transposed(apc::null_space(A, kRank)), x)), 1e-9);
  }
}

TEST_CASE("a hierarchy keeps what its first levels reach") {
  Random random(3);
  for (int k = 0; k < 100; ++k) {
    const std::size_t n = 1 + static_cast<std::size_t>(random.below(8));
    std::vector<PriorityLevel> levels;
    for (int p = 0; p < 4; ++p) {
      const std::size_t m = static_cast<std::size_t>(random.below(7));
      PriorityLevel level{random_matrix(random, m, n, std::min(m, n)), std::vector<double>(m), std::vector<double>(m)};
      for (std::size_t i = 0; i < m; ++i) {
        level.lower[i] = random.between(-1.0, 1.0);
        level.upper[i] = random.below(2) ? level.lower[i] : level.lower[i] + random.between(0.0, 1.0);
      }
      levels.push_back(level);
      const auto found = apc::solve_hierarchy(levels, std::vector<double>(n, 0.0));
      CHECK(found.failure.empty());
      const std::vector<PriorityLevel> before(levels.begin(), levels.end() - 1);
      const auto known = apc::solve_hierarchy(before, std::vector<double>(n, 0.0));
      for (std::size_t i = 0; i < before.size(); ++i)
        for (std::size_t j = 0; j < known.violations[i].size(); ++j)
          CHECK_LE(std::abs(known.violations[i][j] - found.violations[i][j]), 1e-7);
    }
  }
}
