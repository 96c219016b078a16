//! \file
//! Inequalities on the pose of a tool relative to an object: of them envelopes of grasps are made.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "geometry/linear.hpp"

namespace apc {

//! From what the distance of the tool's origin is measured, and what its outward normal there is of.
enum class ReferenceKind : int { plane = 0, line = 1, point = 2 };

//! A plane through `origin` with the normal `axis`, a line through it along `axis`, or the point itself.
struct Reference {
  ReferenceKind kind;
  Vec3 origin, axis;  //!< m in the object frame; unit
};

//! What a constraint bounds. With the tool's origin o and rotation R in the object frame, d(o) the distance from
//! the reference (signed for a plane), n(o) the unit normal there, which points away from it:
enum class PoseConstraintKind : int {
  distance_at_most = 0,   //!< d(o) - bound
  distance_at_least = 1,  //!< bound - d(o)
  tool_to_fixed = 2,      //!< bound - (R tool) . fixed: an angle of at most acos(bound) between both
  tool_to_normal = 3,     //!< bound - (R tool) . n(o)
  normal_to_fixed = 4,    //!< bound - n(o) . fixed
};

//! e(T) <= 0 for a pose T of the tool in the object frame. Krug et al., RA-L 2016, section III-A, with distances
//! instead of squared ones, whose gradient vanishes on the axis.
struct PoseConstraint {
  PoseConstraintKind kind;
  Reference reference;
  Vec3 tool, fixed;  //!< unit, in the tool's and the object's frame
  double bound;      //!< m, or a cosine

  //! e(T) in m, or as a difference of cosines.
  double value(const Pose& T) const;

  //! Derivatives (6) of e by the velocity of the tool's origin and by its angular velocity, in the object frame.
  std::array<double, 6> gradient(const Pose& T) const;
};

}  // namespace apc
