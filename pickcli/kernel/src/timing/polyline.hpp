//! \file
//! Simplification of polylines: waypoints that are repeated, or on the way between others, are dropped.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace apc {

//! Waypoints nearer than `same` count as one, and a path no longer than `nowhere` has no motion; joint units.
struct PointTolerances {
  double same, nowhere;
};

//! Indices, increasing, of the waypoints (N, n) that shape a path: the first, the last and all that are needed.
//! A dropped one lies within its tolerance (N,) of the chord between its kept neighbours. Those between two kept
//! ones advance along their chord, so reversals are kept. After Douglas and Peucker (1973).
std::vector<std::int32_t> simplified(const double* waypoints, std::size_t N, std::size_t n,
                                     const double* tolerance, const PointTolerances& points);

}  // namespace apc
