#include "kinematics/chain.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>

namespace apc {
namespace {

void check_joint(Joint& joint, int k) {
  const std::string where = "joint " + std::to_string(k) + ": ";
  if (joint.type == JointKind::fixed) {
    if (joint.q_index != -1) throw std::invalid_argument(where + "a fixed joint must have q_index -1");
    return;
  }
  if (joint.q_index < 0 || joint.q_index >= kMaxJoints)
    throw std::invalid_argument(where + "q_index of a moving joint must be in 0.." +
                                std::to_string(kMaxJoints - 1));
  const double length = norm(joint.axis);
  if (!(length > 1e-9)) throw std::invalid_argument(where + "the axis has no direction");
  joint.axis = (1.0 / length) * joint.axis;
}

}  // namespace

Chain::Chain(std::vector<Joint> joints) : joints_(std::move(joints)) {
  if (joints_.empty() || n_frames() > kMaxFrames)
    throw std::invalid_argument("a chain has 1.." + std::to_string(kMaxFrames) + " joints, not " +
                                std::to_string(n_frames()));
  std::vector<bool> used(kMaxJoints, false);
  for (int k = 0; k < n_frames(); ++k) {
    check_joint(joints_[k], k);
    if (joints_[k].q_index >= 0) used[joints_[k].q_index] = true;
    n_ = std::max(n_, joints_[k].q_index + 1);
  }
  for (int i = 0; i < n_; ++i)
    if (!used[i]) throw std::invalid_argument("q_index: no joint uses entry " + std::to_string(i));
}

void Chain::fk(const double* q, Pose* frames) const {
  Pose parent;
  for (int k = 0; k < n_frames(); ++k) {
    const Joint& joint = joints_[k];
    Pose T = parent * joint.T_parent_joint;
    if (joint.type == JointKind::revolute) T.R = T.R * rotation(joint.axis, q[joint.q_index]);
    if (joint.type == JointKind::prismatic) T.p = T.p + q[joint.q_index] * (T.R * joint.axis);
    frames[k] = parent = T;
  }
}

void Chain::jacobian(const Pose* frames, const Vec3& p_tip, double* J) const {
  std::fill(J, J + 6 * n_, 0.0);
  for (int k = 0; k < n_frames(); ++k) {
    const Joint& joint = joints_[k];
    if (joint.type == JointKind::fixed) continue;
    // A joint's own motion leaves its axis where it is, so the child frame may stand in for the joint frame.
    const Vec3 z = frames[k].R * joint.axis;
    const bool turns = joint.type == JointKind::revolute;
    const Vec3 linear = turns ? cross(z, p_tip - frames[k].p) : z;
    const Vec3 angular = turns ? z : Vec3{};
    const double column[6] = {linear.x, linear.y, linear.z, angular.x, angular.y, angular.z};
    for (int row = 0; row < 6; ++row) J[row * n_ + joint.q_index] += column[row];
  }
}

Motion Chain::tip_motion(const Pose* frames, const Vec3& p_tip, const double* dq, const double* ddq) const {
  std::vector<Motion> motions(joints_.size());
  frame_motions(frames, dq, ddq, motions.data());
  return moved(motions.back(), p_tip - frames[n_frames() - 1].p);
}

void Chain::frame_motions(const Pose* frames, const double* dq, const double* ddq, Motion* motions) const {
  Motion now;
  for (int k = 0; k < n_frames(); ++k) {
    if (k > 0) now = moved(now, frames[k].p - frames[k - 1].p);
    const Joint& joint = joints_[k];
    if (joint.type != JointKind::fixed) {
      const Vec3 z = frames[k].R * joint.axis, first = dq[joint.q_index] * z, second = ddq[joint.q_index] * z;
      const Vec3 turned = cross(now.angular_velocity, first);
      if (joint.type == JointKind::prismatic) {
        now.velocity = now.velocity + first;
        now.acceleration = now.acceleration + second + 2.0 * turned;
      } else {
        now.angular_velocity = now.angular_velocity + first;
        now.angular_acceleration = now.angular_acceleration + second + turned;
      }
    }
    motions[k] = now;
  }
}

}  // namespace apc
