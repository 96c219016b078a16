//! \file
//! Proof that a tool without its arm is free at every pose of a block of an envelope.
#pragma once

#include <array>
#include <vector>

#include "collision/world.hpp"
#include "geometry/linear.hpp"

namespace apc {

//! What the palm of a tool is about, with its coordinates: x, y, z in m; azimuth, height, distance; azimuth,
//! elevation, distance.
enum class SurfaceKind : int { plane = 0, cylinder = 1, sphere = 2 };

//! Poses of the palm by six coordinates: three of the surface, the roll about the approach, and a rotation vector
//! across the inward normal. Angles in rad.
struct EnvelopeChart {
  SurfaceKind surface;
  Pose T_world_surface;
  Vec3 wanted;     //!< in the world: what of it is across the normal is where roll is measured from; about a round
                   //!< surface its z axis, so that azimuth and elevation turn the tool as a whole
  Mat3 R_nominal;  //!< the tool in the frame of that axis and the approach
  double cone;     //!< half of the opening of the approach's cone: tilts beyond it are in no envelope

  Pose palm(const double* coordinates) const;
};

//! A sphere of the tool, in the frame of the palm.
struct ToolSphere {
  Vec3 center;
  double radius;
  int frame;  //!< of the world's ignored bits
};

//! How far a proof goes.
struct ProofEffort {
  double margin;    //!< m, kept from everything
  double smallest;  //!< m of clearance beyond it that is not looked for: cells that move a sphere less are not divided
  int most_cells;   //!< of one block
};

//! Index of a sphere that is not proven free at every pose between coordinates low and high (6); -1 if all are. A
//! pose is free if each sphere is, so every sphere is proven by itself, in cells that are halved until its clearance
//! at the middle is more than it moves within the cell.
int first_unproven(const EnvelopeChart& chart, const std::vector<ToolSphere>& spheres, const World& world,
                       const double* low, const double* high, const ProofEffort& effort);

}  // namespace apc
