//! \file
//! A serial chain of revolute, prismatic and fixed joints: forward kinematics, Jacobian, motion of the tip.
#pragma once

#include <vector>

#include "geometry/linear.hpp"

namespace apc {

inline constexpr int kMaxJoints = 32;  //!< moving ones, i.e. entries of a configuration
inline constexpr int kMaxFrames = 63;  //!< bit 63 of an ignored mask is left for the held item

//! How a joint moves its child: about its axis, along it, or not at all.
enum class JointKind : int { revolute = 0, prismatic = 1, fixed = 2 };

//! A joint of the chain.
struct Joint {
  JointKind type;
  Pose T_parent_joint;  //!< m, joint frame in the parent frame, at position 0
  Vec3 axis;            //!< unit, in the joint frame
  int q_index;          //!< entry of q that moves it, -1 if fixed
};

//! How a frame moves, in world axes, per unit of whatever the joints' derivatives are by.
struct Motion {
  Vec3 velocity, angular_velocity;          //!< of its origin in m, of the frame in rad
  Vec3 acceleration, angular_acceleration;  //!< their derivatives by the same unit
};

//! Motion of the point at an arm from a frame's origin, of the same rigid body.
inline Motion moved(const Motion& frame, const Vec3& arm) {
  const Vec3 swing = cross(frame.angular_velocity, arm);
  Motion point = frame;
  point.velocity = frame.velocity + swing;
  point.acceleration =
      frame.acceleration + cross(frame.angular_acceleration, arm) + cross(frame.angular_velocity, swing);
  return point;
}

//! Frame k is the child link of joint k; the parent of joint k is frame k-1, of joint 0 the world.
class Chain {
 public:
  //! Normalises the axes. Throws std::invalid_argument for what is not a chain.
  explicit Chain(std::vector<Joint> joints);

  //! Length of a configuration.
  int n() const { return n_; }
  int n_frames() const { return static_cast<int>(joints_.size()); }
  const std::vector<Joint>& joints() const { return joints_; }

  //! Poses (n_frames) of all frames in the world at q (n), in rad or m.
  void fk(const double* q, Pose* frames) const;

  //! J (6, n) row-major at T_world_tip: linear rows, then angular rows, world-aligned. frames: fk of q.
  void jacobian(const Pose* frames, const Vec3& p_tip, double* J) const;

  //! Motions (n_frames) of all frames for first and second derivatives (n) of the joints; frames: fk of q. The
  //! outward recursion of Luh, Walker and Paul, "On-line computational scheme for mechanical manipulators", J.
  //! Dyn. Sys. 102(2), 1980.
  void frame_motions(const Pose* frames, const double* dq, const double* ddq, Motion* motions) const;

  //! Motion of the tip for first and second derivatives (n) of the joints; frames: fk of q.
  Motion tip_motion(const Pose* frames, const Vec3& p_tip, const double* dq, const double* ddq) const;

 private:
  std::vector<Joint> joints_;
  int n_ = 0;
};

}  // namespace apc
