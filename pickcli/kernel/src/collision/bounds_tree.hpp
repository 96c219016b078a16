//! \file
//! Bounds around bounds, eight to a row: what of many things comes near is found in a few looks.
#pragma once

#include <vector>

#include "geometry/linear.hpp"
#include "simd/simd8_collision.hpp"

namespace apc {

//! World-aligned, m.
struct Bounds {
  Vec3 low, high;
};

Bounds around(const Bounds& a, const Bounds& b);

//! The order in which things with these centres stand in a tree: every 8, 64, 512, ... from a multiple of
//! that on lie close together, as halves across the longest side are taken again and again.
std::vector<int> spatial_order(const std::vector<Vec3>& centers);

//! A tree over things that stand in spatial order: row r of a level bounds what is in rows 8r..8r+7 of the
//! level below, or of the lowest level things 8r..8r+7.
class BoundsTree {
 public:
  BoundsTree() = default;
  BoundsTree(const std::vector<Bounds>& things, double slop);  //!< slop in m is added on all sides

  //! In single precision, for the batch test. Valid as long as this tree.
  simd8::TreeData single_precision() const;

  //! Calls visit(i) for every thing whose bounds come as near to a point as nearest(), which may shrink
  //! meanwhile, in the order of the tree.
  template <typename Nearest, typename Visit>
  void visit_near(const Vec3& point, const Nearest& nearest, const Visit& visit) const {
    if (levels_.empty()) return;
    const int top = static_cast<int>(levels_.size()) - 1;
    for (std::size_t row = 0; row < levels_.back().size(); ++row)
      visit_row(top, static_cast<int>(row), point, nearest, visit);
  }

 private:
  template <typename Nearest, typename Visit>
  void visit_row(int level, int row, const Vec3& point, const Nearest& nearest, const Visit& visit) const {
    for (int i = 0; i < simd8::kLanes; ++i) {
      if (!(distance(levels_[level][row], i, point) <= nearest())) continue;
      const int child = simd8::kLanes * row + i;
      if (level == 0)
        visit(child);
      else
        visit_row(level - 1, child, point, nearest, visit);
    }
  }

  //! Of a point from bounds; to those of nothing infinite.
  static double distance(const simd8::Bounds8& boxes, int i, const Vec3& point);

  std::vector<std::vector<simd8::Bounds8>> levels_;  //!< the lowest first
};

}  // namespace apc
