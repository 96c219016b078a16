//! \file
//! Straight lines of the tip: how far poses are off one, configurations that follow one, joint chords near it.
#pragma once

#include <vector>

#include "kinematics/ik.hpp"

namespace apc {

//! How far the tip is off a line, or may be.
struct Deviation {
  double position = 0.0;  //!< m
  double angle = 0.0;     //!< rad
};

inline bool is_within(const Deviation& off, const Deviation& most) {
  return off.position <= most.position && off.angle <= most.angle;
}

//! How far poses leave the straight line from the first to the last at most: by position from the nearest
//! point of it, by angle from how a steady turn about one axis stands there.
Deviation line_deviation(const std::vector<Pose>& poses);

//! Why following a row of targets ended.
enum class FollowEnd : int { done = 0, no_convergence = 1, joint_step = 2, limit = 3, off_line = 4 };

//! Configurations along a row of targets.
struct FollowPath {
  std::vector<Configuration> configurations;  //!< one per target reached
  FollowEnd reason;
  Deviation off;  //!< half-way to the next target, where that was too much
};

//! Target after target, each from the solution before it (the first from q0); ends where a joint would
//! step over max_step (n,), or the tip be off the middle of two poses by over `most` half-way between them.
FollowPath follow(const IkProblem& problem, const std::vector<Pose>& targets, const double* q0,
                  const double* max_step, const Deviation& most);

//! Indices of the rows of Q (N, n), followed through N poses on a line, that are enough: joint chords between
//! them, each as long as halving finds it, hold the tip within `most` of that line.
std::vector<int> longest_chords(const Chain& chain, const Pose& T_last_tip, const double* Q,
                                const std::vector<Pose>& poses, const Deviation& most);

}  // namespace apc
