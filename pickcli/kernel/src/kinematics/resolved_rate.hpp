//! \file
//! Resolved motion rate control: joint velocities of least norm that move the tip as wanted, and where they lead.
//! Whitney, "Resolved motion rate control of manipulators and human prostheses", IEEE Trans. Man-Machine
//! Systems 10(2), 1969.
#pragma once

#include <vector>

#include "kinematics/chain.hpp"
#include "kinematics/spd6.hpp"

namespace apc {

//! Joint velocities for one arm and tip. Those of each joint are measured by its limit.
class ResolvedRate {
 public:
  //! velocity: (n,) limits, > 0, kept by the caller.
  ResolvedRate(const Chain& chain, const Pose& T_last_tip, const double* velocity)
      : chain_(chain), T_last_tip_(T_last_tip), velocity_(velocity) {}

  int n() const { return chain_.n(); }

  //! Velocities dq (n,) at q (n,) that give the tip a twist (6,): own (n,), and what is missing of the twist by
  //! the least further ones. In a singular configuration they give another twist, or are not finite.
  void rate(const double* q, const double* own, const double* twist, double* dq);

  //! Moves q (n,) by one step of least norm towards the tip's pose.
  void correct(const Pose& T_world_tip, double* q);

 private:
  //! Frames, tip and Jacobian at q.
  void place(const double* q);
  //! The least further velocities, added to dq (n,).
  void add_least(Vec6 twist, double* dq) const;

  const Chain& chain_;
  Pose T_last_tip_;
  const double* velocity_;
  Pose tip_;
  Pose frames_[kMaxFrames];
  double J_[6 * kMaxJoints];
};

//! What the arm and its tip are to do at N times.
struct WantedMotion {
  std::vector<double> times;     //!< (N,) s, increasing
  std::vector<Pose> poses;       //!< of the tip
  const double* own;             //!< (N, n) velocities that the joints have besides
  const double* twists;          //!< (N, 6) of the tip
  const double* own_between;     //!< (N-1, n) half-way between the times
  const double* twists_between;  //!< (N-1, 6)
};

//! How tracking ended.
enum class TrackEnd : int { done = 0, singular = 1, limit = 2 };

//! Configurations along a wanted motion.
struct TrackedPath {
  std::vector<double> Q;  //!< (N, n); only those that were reached are meant
  TrackEnd end = TrackEnd::done;
  int at = 0;     //!< index of the time that was not reached
  int joint = 0;  //!< that is farthest beyond its limit there
};

//! What no configuration may exceed.
struct TrackLimits {
  const double *lower, *upper;  //!< (n,) rad or m
  double fastest;               //!< times the limit of a joint's velocity, from which on the arm counts as singular
};

//! From the configuration q_met (n,) at one of the times to all later and all earlier ones: steps by Runge and
//! Kutta of the fourth order, each followed by one of least norm onto the pose.
TrackedPath track(ResolvedRate& arm, const double* velocity, const WantedMotion& wanted, int met,
                  const double* q_met, const TrackLimits& limits);

}  // namespace apc
