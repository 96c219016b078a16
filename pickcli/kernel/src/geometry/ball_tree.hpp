//! \file
//! Balls around balls around the spheres of one frame.
#pragma once

#include <vector>

#include "geometry/linear.hpp"

namespace apc {

struct Sphere {
  Vec3 center;
  double radius;
};

//! Nodes stand in depth-first order, the root first: what follows a node up to `next` lies inside it.
struct BallNode {
  Sphere ball;
  int next;        //!< index of the first node that is not below this one
  bool is_sphere;  //!< a sphere of the frame itself, with nothing below
};

std::vector<BallNode> build_ball_tree(std::vector<Sphere> spheres);

//! A small ball that contains all spheres (at least one).
Sphere ball_around(const Sphere* first, const Sphere* last);

}  // namespace apc
