//! \file
//! Least squares with equalities and inequalities in levels of strict priority.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "control/dense.hpp"

namespace apc {

//! Rows lower <= A x <= upper of one priority: equalities where both bounds are the same, which may be infinite.
struct PriorityLevel {
  Matrix rows;
  std::vector<double> lower, upper;

  //! How far (m,) an x (n,) is above the upper bounds, or, negative, below the lower ones.
  std::vector<double> violation(const std::vector<double>& x) const;
};

//! What a hierarchy of levels has in common.
struct HierarchySolution {
  std::vector<double> x;                        // (n,)
  std::vector<std::vector<double>> violations;  // of each level, as of PriorityLevel::violation
  std::size_t n_iterations = 0;                 // of the active sets of all levels
  std::string failure;                          // "" if it is solved, else which level is not, and why
};

//! Minimize lexicographically the norms of the levels' violations, those of the first one first.
//!
//! Level by level a primal active set is sought: violated rows of the level are least squares, rows of levels
//! before are constraints that keep what is reached there. Where the least norms do not determine x, the
//! solution stays as near to `start` (n,) as a step of least norm leads. O. Kanoun, F. Lamiraux, P.-B. Wieber,
//! "Kinematic control of redundant manipulators: generalizing the task-priority framework to inequality
//! tasks", IEEE T-RO 27(4), 2011; A. Escande, N. Mansard, P.-B. Wieber, "Hierarchical quadratic programming",
//! IJRR 33(7), 2014. After the last level all of them are evaluated anew.
HierarchySolution solve_hierarchy(const std::vector<PriorityLevel>& levels, std::vector<double> start);

}  // namespace apc
