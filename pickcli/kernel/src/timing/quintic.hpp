//! \file
//! Quintic pieces of a trajectory: how large velocity, acceleration and jerk get on them.
#pragma once

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

}  // namespace apc
