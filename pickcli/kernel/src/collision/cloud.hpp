//! \file
//! A cloud: points, or the cubes of an occupancy grid, by the hundred thousand.
#pragma once

#include <cstdint>
#include <vector>

#include "collision/bounds_tree.hpp"
#include "geometry/solid.hpp"

namespace apc {

//! What a sensor saw.
struct CloudPoints {
  const double* centers;  //!< (n, 3) in the world, m
  int n = 0;
  double radius = 0.0;     //!< m around each that counts as it
  double half_edge = 0.0;  //!< m, of a cube along the axes of the world around each; 0: points
  double voxel = 0.0;      //!< m: what is in one cell of a grid this wide becomes one ball around it, if not 0
};

class Cloud {
 public:
  Cloud() = default;
  explicit Cloud(const CloudPoints& points);

  int size() const { return static_cast<int>(index_.size()); }

  //! The i-th, with all that it stands for, and the user's number of the first of those.
  Solid solid(int i) const;
  int index(int i) const { return index_[static_cast<std::size_t>(i)]; }

  const BoundsTree& tree() const { return tree_; }  //!< over rows of eight
  double extent() const { return extent_; }         //!< m, farthest point from the world's origin

  //! In single precision, for the batch test, without frames that are ignored. Valid as long as this cloud.
  simd8::CloudData single_precision() const;

 private:
  std::vector<simd8::Points8> rows_;
  std::vector<int> index_;
  float half_edge_ = 0.0f;
  BoundsTree tree_;
  double extent_ = 0.0;
};

}  // namespace apc
