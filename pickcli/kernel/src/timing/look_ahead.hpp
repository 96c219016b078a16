//! \file
//! About how long a polyline takes: the look-ahead of machine tools.
#pragma once

#include <cstddef>

namespace apc {

//! A polyline of N vertices, row-major, and what the joints may do.
struct Polyline {
  std::size_t N, n;
  const double* waypoints;      //!< (N, n)
  const double* velocity;       //!< (n,) per s
  const double* acceleration;   //!< (n,) per s^2
  double corner_deviation;      //!< by how much a blend may leave its corner, in joint units
};

//! Seconds from rest to rest along a polyline with blended corners. On each edge the speed is bounded by the
//! slowest joint, in each corner by the acceleration that a blend needs; a pass backwards and one forwards make
//! the speeds reachable; each edge then takes its trapezoid. Jerk is left out.
double estimated_duration(const Polyline& line);

}  // namespace apc
