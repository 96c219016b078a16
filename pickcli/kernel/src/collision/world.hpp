//! \file
//! The world: solids and a cloud, each under a tree of bounds.
#pragma once

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "collision/bounds_tree.hpp"
#include "collision/cloud.hpp"
#include "geometry/solid.hpp"
#include "simd/simd8_collision.hpp"

namespace apc {

struct Obstacle {
  Solid solid;            //!< in the world
  std::uint64_t ignored;  //!< bit f: frame f is never tested against this obstacle
  int index;              //!< the user's
};

class World {
 public:
  World() = default;
  explicit World(std::vector<Obstacle> obstacles) { set_obstacles(std::move(obstacles)); }  //!< in any order

  void set_obstacles(std::vector<Obstacle> obstacles);
  //! Frame f, of bit f, is never tested against the cloud.
  void set_cloud(std::shared_ptr<const Cloud> cloud, std::uint64_t ignored) {
    cloud_ = std::move(cloud);
    ignored_by_cloud_ = ignored;
  }

  const std::vector<Obstacle>& obstacles() const { return obstacles_; }  //!< in the order of their tree
  const BoundsTree& tree() const { return tree_; }
  const std::shared_ptr<const Cloud>& cloud() const { return cloud_; }
  std::uint64_t ignored_by_cloud() const { return ignored_by_cloud_; }

  //! Obstacles and cloud in single precision, for the batch test. Valid until the world is changed.
  simd8::WorldData single_precision() const;

  //! Bound in m on the error of a distance from an obstacle or a point of the cloud in single precision, for
  //! points within reach of the origin.
  double rounding(double reach) const;

 private:
  std::vector<Obstacle> obstacles_;
  std::vector<simd8::ObstacleData> obstacles_single_;
  BoundsTree tree_;
  std::shared_ptr<const Cloud> cloud_ = std::make_shared<const Cloud>();
  std::uint64_t ignored_by_cloud_ = 0;
  double extent_ = 0.0;  //!< farthest point of any obstacle from the origin
};

}  // namespace apc
