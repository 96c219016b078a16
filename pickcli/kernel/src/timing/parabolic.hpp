//! \file
//! Parabolic segments: every joint ramps to a speed of its own, keeps it, and ramps to its final speed; and what
//! is made of them. All joints start and end together and are otherwise independent, so only the slowest one
//! needs its limits; the others have time to spare (Hauser and Ng-Thow-Hing 2010, with the speeds of all joints
//! free at both ends). Ramps begin and end on ticks, so a filtered motion never switches between two ticks.
#pragma once

#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

namespace apc {

inline constexpr double kTick = 0.001;  //!< s

//! Positions and velocities of all joints at one time.
struct MotionState {
  std::vector<double> q, v;  //!< (n,) rad or m, and per s
};

//! What each joint may do.
struct ParabolicLimits {
  std::vector<double> velocity, acceleration, jerk;  //!< (n,)
  double pause;  //!< s without acceleration between a ramp up and a ramp down
};

//! One joint of a segment.
struct Ramps {
  double q0, v0, speed, v1;  //!< position and velocity at the start, velocity of the cruise and at the end
  double up, down;           //!< s from the start and before the end in which the velocity changes
  double first = 0.0, last = 0.0;  //!< accelerations of the two ramps
};

class ParabolicSegment {
 public:
  ParabolicSegment(std::vector<Ramps> joints, double duration);

  std::size_t n() const { return joints_.size(); }
  const std::vector<Ramps>& joints() const { return joints_; }
  double duration() const { return duration_; }

  //! Positions, and velocities unless v is null, t s since the segment began.
  void evaluate(double t, double* q, double* v) const;
  MotionState state(double t) const;

  //! At a switch either of its two values.
  double acceleration(std::size_t joint, double t) const;

  ParabolicSegment part(double start, double end) const;

 private:
  std::vector<Ramps> joints_;
  double duration_;
};

using Segments = std::vector<ParabolicSegment>;

//! The segment of least time between two states; none if it takes longer than at_most, or if a joint has no
//! segment of any of the times tried.
std::optional<ParabolicSegment> steer_min_time(const MotionState& start, const MotionState& end,
                                               const ParabolicLimits& limits, double at_most);

//! The segment of a given duration, a whole number of ticks; none if a joint has none.
std::optional<ParabolicSegment> steer_fixed_time(const MotionState& start, const MotionState& end,
                                                 const ParabolicLimits& limits, double duration);

//! Two segments by way of a state in between: every joint takes the first of the middle states for which it has
//! both. None if a joint has no choice.
std::optional<std::pair<ParabolicSegment, ParabolicSegment>> steer_via(
    const MotionState& start, const std::vector<const MotionState*>& middles, const MotionState& end,
    const ParabolicLimits& limits, double there, double back);

//! Chord ends (K, n), each of step s at most, and slack (K - 1, n): on each chord the motion stays within the
//! slack, joint by joint. A curve of acceleration a leaves a chord of h s by a h^2 / 8 at most.
struct Tube {
  std::vector<double> Q, slack;
};
Tube tube(const Segments& segments, double step);

//! Positions (M, n) at increasing times, s since the first segment began.
std::vector<double> positions(const Segments& segments, const double* t, std::size_t M);

//! Accelerations (K, n) during each of K ticks.
std::vector<double> accelerations(const Segments& segments);

//! s over which segments must be averaged to keep the jerk limits: a pause, or up to two. The jerk of an average
//! over w s is the change of acceleration in w s, over w. Over two pauses it keeps the limit whatever the
//! segments do; over one, unless a joint turns from ramp to ramp.
double jerk_window(const Segments& segments, const ParabolicLimits& limits);

//! Segments, one at least, each beginning as the one before it ends; at rest at both ends.
class ParabolicTrajectory {
 public:
  explicit ParabolicTrajectory(Segments segments);

  const Segments& segments() const { return segments_; }
  double duration() const { return starts_.back(); }
  MotionState state(double t) const;

  //! The segments between two times on ticks, cut where the times fall into them.
  Segments between(double start, double end) const;

  //! The trajectory with other segments between two times on ticks.
  ParabolicTrajectory replaced(double start, double end, const Segments& segments) const;

 private:
  Segments segments_;
  std::vector<double> starts_;  //!< (L + 1) s, when each begins, and the end
};

}  // namespace apc
