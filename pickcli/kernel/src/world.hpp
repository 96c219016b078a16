// The world: oriented boxes in groups, each group under one box.
#pragma once

#include <cstdint>
#include <vector>

#include "eight.hpp"
#include "linear.hpp"

namespace apc {

struct Box {
  Pose T_world_box;
  Vec3 half;              // half extents, m
  int group;              // boxes of one group stand close together
  std::uint64_t ignored;  // bit f: frame f is never tested against this box
  int index;              // the user's
};

// Signed distance of a point from a box: negative inside, minus the depth below the nearest face.
double signed_distance(const Vec3& point, const Box& box);

class World {
 public:
  World() = default;
  explicit World(std::vector<Box> boxes);  // in any order
  World(World&&) = default;  // not copied: the single-precision groups point into it
  World& operator=(World&&) = default;

  const std::vector<Box>& boxes() const { return boxes_; }  // sorted by group

  // The same in single precision, for the eight-fold test. Valid as long as this world.
  eight::World single() const;

  // Bound in m on the error of a box distance in single precision, for points within reach of the origin.
  double rounding(double reach) const;

 private:
  void add_group(int first, int last);

  std::vector<Box> boxes_;
  std::vector<eight::Box> single_boxes_;
  std::vector<eight::EightBounds> box_bounds_;    // every group begins a new one
  std::vector<eight::Group> groups_;
  std::vector<eight::EightBounds> group_bounds_;
  double extent_ = 0.0;  // farthest point of any box from the origin
};

}  // namespace apc
