//! \file
//! Quintic pieces of a trajectory: how large velocity, acceleration and jerk get on them.
#pragma once

#include <cstddef>

namespace apc {

//! Position, velocity and acceleration of one joint.
struct JointState {
  double p, v, a;
};

//! Largest absolute values over a piece: of the velocity an upper bound, of the others exact.
struct Peaks {
  double velocity = 0.0, acceleration = 0.0, jerk = 0.0;
};

//! Of the quintic that leads from one state to another in h > 0 seconds. What is surely below its floor may come
//! out as 0: that costs less to see.
Peaks quintic_peaks(const JointState& start, const JointState& end, double h, const Peaks& floor = {});

//! Points of a trajectory of n joints, row-major, with quintics in between.
struct QuinticPoints {
  std::size_t N, n;     //!< N at least 2
  const double* times;  //!< (N,) s, increasing
  const double *positions, *velocities, *accelerations;  //!< (N, n)
};

//! Positions, velocities and accelerations, as far as `highest` (0 to 2) says, at t (M,), clamped to the ends:
//! out (highest + 1, M, n).
void quintic_states(const QuinticPoints& points, const double* t, std::size_t M, int highest, double* out);

}  // namespace apc
