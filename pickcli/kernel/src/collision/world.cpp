#include "collision/world.hpp"

#include <algorithm>

namespace apc {
namespace {

Bounds bounds_of(const Solid& solid) {
  const auto half = [&](const Vec3& axis) { return support(solid, axis) + solid.rounding; };
  const Vec3 h{half({1, 0, 0}), half({0, 1, 0}), half({0, 0, 1})};
  return {solid.T.p - h, solid.T.p + h};
}

}  // namespace

void World::set_obstacles(std::vector<Obstacle> obstacles) {
  std::vector<Vec3> centers;
  extent_ = 0.0;
  for (const auto& [solid, ignored, index] : obstacles) {
    centers.push_back(solid.T.p);
    extent_ = std::max(extent_, norm(solid.T.p) + norm(solid.half) + solid.rounding);
  }
  std::vector<Bounds> bounds;
  obstacles_.clear();
  obstacles_single_.clear();
  for (int i : spatial_order(centers)) {
    const Obstacle& obstacle = obstacles[static_cast<std::size_t>(i)];
    obstacles_.push_back(obstacle);
    obstacles_single_.push_back({to_single(obstacle.solid), obstacle.ignored, obstacle.index});
    bounds.push_back(bounds_of(obstacle.solid));
  }
  tree_ = BoundsTree(bounds, 32.0 * simd8::kUnitRoundoff * extent_);
}

simd8::WorldData World::single_precision() const {
  simd8::CloudData cloud = cloud_->single_precision();
  cloud.ignored = ignored_by_cloud_;
  return {tree_.single_precision(), obstacles_single_.data(), cloud};
}

//! In units of u times both lengths: rounding of the obstacle and the difference from its centre (3), into
//! its frame and, for the held item, its axes likewise (7 each), roots, squares and sums of lengths (6 for a
//! point, 10 for a slab), and the threshold (4).
double World::rounding(double reach) const {
  return 32.0 * simd8::kUnitRoundoff * (reach + std::max(extent_, cloud_->extent()));
}

}  // namespace apc
