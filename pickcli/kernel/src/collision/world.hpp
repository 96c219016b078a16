// The world: solids in groups, each group under one box.
#pragma once

#include <cstdint>
#include <vector>

#include "simd/simd8_collision.hpp"
#include "geometry/solid.hpp"

namespace apc {

struct Obstacle {
  Solid solid;            // in the world
  int group;              // obstacles of one group stand close together
  std::uint64_t ignored;  // bit f: frame f is never tested against this obstacle
  int index;              // the user's
};

class World {
 public:
  World() = default;
  explicit World(std::vector<Obstacle> obstacles);  // in any order
  World(World&&) = default;  // not copied: the single-precision groups point into it
  World& operator=(World&&) = default;

  const std::vector<Obstacle>& obstacles() const { return obstacles_; }  // sorted by group

  // The same in single precision, for the eight-fold test. Valid as long as this world.
  eight::World single() const;

  // Bound in m on the error of a distance from an obstacle in single precision, for points within reach of
  // the origin.
  double rounding(double reach) const;

 private:
  void add_group(int first, int last);

  std::vector<Obstacle> obstacles_;
  std::vector<eight::Obstacle> single_obstacles_;
  std::vector<eight::EightBounds> bounds_;  // of the obstacles; every group begins a new one
  std::vector<eight::Group> groups_;
  std::vector<eight::EightBounds> group_bounds_;
  double extent_ = 0.0;  // farthest point of any obstacle from the origin
};

}  // namespace apc
