#include "kinematics/inverse_dynamics.hpp"

#include <stdexcept>
#include <utility>

namespace apc {

InverseDynamics::InverseDynamics(const Chain& chain, std::vector<RigidBody> bodies)
    : chain_(chain), bodies_(std::move(bodies)), frames_(bodies_.size()), motions_(bodies_.size()) {
  if (bodies_.size() != chain.joints().size())
    throw std::invalid_argument("inverse dynamics needs one body for each frame");
}

void InverseDynamics::efforts(const double* q, const double* dq, const double* ddq, double gravity,
                              double* out) {
  chain_.fk(q, frames_.data());
  chain_.frame_motions(frames_.data(), dq, ddq, motions_.data());
  Vec3 force, torque;  // that joint k exerts on all that follows it, the torque about the origin of frame k
  for (int k = chain_.n_frames() - 1; k >= 0; --k) {
    const RigidBody& body = bodies_[static_cast<std::size_t>(k)];
    const Pose& frame = frames_[static_cast<std::size_t>(k)];
    const Motion& motion = motions_[static_cast<std::size_t>(k)];
    if (body.mass > 0.0) {
      const Vec3 arm = frame.R * body.centre;
      const Vec3 push = body.mass * (moved(motion, arm).acceleration + Vec3{0.0, 0.0, gravity});
      const Mat3 R_frame_world = transposed(frame.R);
      const Vec3 omega = R_frame_world * motion.angular_velocity;
      const Vec3 alpha = R_frame_world * motion.angular_acceleration;
      const Vec3 spin = body.inertia * alpha + cross(omega, body.inertia * omega);
      force = force + push;
      torque = torque + cross(arm, push) + frame.R * spin;
    }
    const Joint& joint = chain_.joints()[static_cast<std::size_t>(k)];
    if (joint.type != JointKind::fixed)
      out[joint.q_index] = dot(frame.R * joint.axis, joint.type == JointKind::prismatic ? force : torque);
    if (k > 0) torque = torque + cross(frame.p - frames_[static_cast<std::size_t>(k - 1)].p, force);
  }
}

}  // namespace apc
