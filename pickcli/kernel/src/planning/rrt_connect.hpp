//! \file
//! RRT-Connect (Kuffner and LaValle 2000) in dynamic domains (Yershova, Jaillet, Simeon and LaValle 2005), begun
//! anew with shorter edges where it takes long: two trees of proven edges that grow towards each other.
#pragma once

#include <cstdint>
#include <vector>

#include "collision/checker.hpp"

namespace apc {

struct ConnectQuery {
  const double* start;  //!< (n)
  const double* goals;  //!< (n_goals, n), all of them roots of the second tree
  int n_goals;
  const double *lower, *upper;  //!< (n), between which configurations are drawn
  double step;                  //!< longest edge of a tree, Euclidean in joint space
  double margin, resolution;    //!< of check_edge
  std::uint64_t seed;
  int max_iterations;
};

//! Waypoints (K, n) from the start to one of the goals, every edge proven in the direction of the path; empty
//! where none was found. The same query gives the same bits.
std::vector<double> rrt_connect(const Checker& checker, const ConnectQuery& query);

}  // namespace apc
