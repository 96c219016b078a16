//! \file
//! The world: solids in groups, each group under one box.
#pragma once

#include <cstdint>
#include <vector>

#include "geometry/solid.hpp"
#include "simd/simd8_collision.hpp"

namespace apc {

struct Obstacle {
  Solid solid;            //!< in the world
  int group;              //!< obstacles of one group stand close together
  std::uint64_t ignored;  //!< bit f: frame f is never tested against this obstacle
  int index;              //!< the user's
};

class World {
 public:
  World() = default;
  explicit World(std::vector<Obstacle> obstacles);  //!< in any order
  World(World&&) = default;                         //!< not copied: the single-precision groups point into it
  World& operator=(World&&) = default;

  const std::vector<Obstacle>& obstacles() const { return obstacles_; }  //!< sorted by group

  //! The same in single precision, for the batch test. Valid as long as this world.
  simd8::WorldData single_precision() const;

  //! Bound in m on the error of a distance from an obstacle in single precision, for points within reach of
  //! the origin.
  double rounding(double reach) const;

 private:
  void add_group(int first, int last);

  std::vector<Obstacle> obstacles_;
  std::vector<simd8::ObstacleData> obstacles_single_;
  std::vector<simd8::Bounds8> bounds_;  //!< of the obstacles; every group begins a new one
  std::vector<simd8::Group> groups_;
  std::vector<simd8::Bounds8> group_bounds_;
  double extent_ = 0.0;  //!< farthest point of any obstacle from the origin
};

}  // namespace apc
