//! \file
//! Making a proven polyline cheaper without ever leaving what is proven.
#pragma once

#include <vector>

#include "collision/checker.hpp"

namespace apc {

//! What an edge dq costs: the largest |dq_j| / velocity_j, and calm times the length of dq / velocity.
struct EdgeCost {
  const double* velocity;  //!< (n)
  double calm;
  double operator()(const double* from, const double* to, int n) const;
};

struct ShortenQuery {
  const double* Q;  //!< (n_rows, n), its edges taken as proven
  int n_rows;
  const double* shortcuts;  //!< (n_shortcuts, 2): where each begins and ends, as shares of the cost of what
                            //!< is there then
  int n_shortcuts;
  EdgeCost cost;
  double worthwhile;          //!< share of the whole cost that a shortcut must save
  double margin, resolution;  //!< of check_edge
};

//! A polyline (K, n) with the same ends that costs no more; every new edge is proven, also what is left of a
//! cut one.
std::vector<double> shorten(const Checker& checker, const ShortenQuery& query);

}  // namespace apc
