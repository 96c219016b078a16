//! \file
//! Forces and torques of the joints that move rigid links as required.
#pragma once

#include <vector>

#include "kinematics/chain.hpp"

namespace apc {

//! A rigid body fixed to a frame.
struct RigidBody {
  double mass;   //!< kg
  Vec3 centre;   //!< m, centre of mass in the frame
  Mat3 inertia;  //!< kg m^2 about the centre of mass, in the axes of the frame
};

//! Newton-Euler inverse dynamics of a chain (Luh, Walker and Paul, J. Dyn. Sys. 102(2), 1980).
class InverseDynamics {
 public:
  //! bodies: one for each frame of the chain, which must outlive this.
  InverseDynamics(const Chain& chain, std::vector<RigidBody> bodies);

  //! Efforts (n) in Nm, or N of prismatic joints, at q (n) for its derivatives dq and ddq (n) against a gravity
  //! in m/s^2 along -z of the world.
  void efforts(const double* q, const double* dq, const double* ddq, double gravity, double* out);

 private:
  const Chain& chain_;
  std::vector<RigidBody> bodies_;
  std::vector<Pose> frames_;
  std::vector<Motion> motions_;
};

}  // namespace apc
