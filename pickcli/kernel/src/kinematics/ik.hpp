//! \file
//! Inverse kinematics by damped least squares (Levenberg-Marquardt) within joint limits.
#pragma once

#include <vector>

#include "kinematics/chain.hpp"

namespace apc {

using Configuration = std::vector<double>;  //!< (n,) rad or m

//! What a configuration is searched for, and between which limits.
struct IkProblem {
  const Chain& chain;
  Pose T_last_tip;
  const double* lower;    //!< (n,) rad or m
  const double* upper;    //!< (n,) rad or m
  const double* weights;  //!< (n,) > 0: what moving a joint costs, relative to the others
  int max_iterations = 60;
  double position_tolerance = 1e-5;  //!< m
  double rotation_tolerance = 1e-4;  //!< rad
};

//! How a search for one configuration ended.
enum class IkResult { converged, not_converged, at_limit };

//! Moves q (n,) until the tip stands at T_world_target. at_limit: stuck with a joint pressed against a limit.
IkResult solve(const IkProblem& problem, const Pose& T_world_target, double* q);

//! Every solution reached from seeds (n_seeds, n), in seed order, without those that differ from an
//! earlier one by at most `distinct` in every joint.
std::vector<Configuration> solve_all(const IkProblem& problem, const Pose& T_world_target,
                                     const double* seeds, int n_seeds, double distinct);

//! How far the tip is off a line, or may be.
struct Deviation {
  double position = 0.0;  //!< m
  double angle = 0.0;     //!< rad
};

inline bool is_within(const Deviation& off, const Deviation& most) {
  return off.position <= most.position && off.angle <= most.angle;
}

//! How far poses leave the straight line from the first to the last at most: by position from the nearest point
//! of it, by angle from how a steady turn about one axis stands there.
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
