//! \file
//! Time-optimal pace along a path by reachability analysis, TOPP-RA, in closed form.
//!
//! Pham and Pham, "A New Approach to Time-Optimal Path Parameterization Based on Reachability Analysis",
//! IEEE T-RO 34(3), 2018. With x = (ds/dt)^2 and u = d2s/dt2, constant between gridpoints, every acceleration
//! limit is a strip |u - m x| <= c. All strips contain the origin, so the controllable sets are intervals
//! [0, X] and both passes need no linear programs: each step is a minimum over the strips.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace apc {

//! A path of n joints and its limits at M gridpoints.
struct PathGrid {
  std::size_t M, n;
  const double* s;              //!< (M,) increasing
  const double* dq;             //!< (M, n) dq/ds
  const double* ddq;            //!< (M, n) d2q/ds2
  const double* acceleration;   //!< (M-1, n) limits on each interval
  const double* speed;          //!< (M,) limit of ds/dt
  const double* line_speed;     //!< (M-1,) limit of ds/dt inside each interval, used on lines only
  const std::int32_t* is_line;  //!< (M-1,) whether nothing of the path bends there
  double cruise;                //!< s that the cruise on a line lasts at least
};

//! A motion along the path: ds/dt is linear in t between the points.
struct PaceProfile {
  std::vector<double> t, s, v;
};

//! The fastest motion from rest to rest. Limits are enforced at both ends of each interval; lines are exact
//! (accelerate, cruise, brake) with no gridpoints in between.
PaceProfile fastest_pace(const PathGrid& grid);

//! s and its derivatives by time at even times, each (K,).
struct SmoothPace {
  std::vector<double> s, ds, dds;
};

//! The profile (P points) with its speed averaged over a window of n_window steps, which bounds its jerk: a
//! window and a step longer.
SmoothPace smoothed(const double* t, const double* s, const double* v, std::size_t P, double step,
                    std::size_t n_window);

}  // namespace apc
