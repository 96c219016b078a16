#include "collision/world.hpp"

#include <algorithm>
#include <limits>

namespace apc {
namespace {

struct Bounds {
  Vec3 low, high;
};

//! World-aligned bounds of the obstacles [first, last).
Bounds around(const Obstacle* first, const Obstacle* last) {
  const double inf = std::numeric_limits<double>::infinity();
  Bounds out{{inf, inf, inf}, {-inf, -inf, -inf}};
  for (const Obstacle* obstacle = first; obstacle != last; ++obstacle) {
    const auto& [solid, group, ignored, index] = *obstacle;
    const auto half = [&s = solid](const Vec3& axis) { return support(s, axis) + s.rounding; };
    const Vec3 c = solid.T.p, h{half({1, 0, 0}), half({0, 1, 0}), half({0, 0, 1})};
    out.low = {std::min(out.low.x, c.x - h.x), std::min(out.low.y, c.y - h.y),
               std::min(out.low.z, c.z - h.z)};
    out.high = {std::max(out.high.x, c.x + h.x), std::max(out.high.y, c.y + h.y),
                std::max(out.high.z, c.z + h.z)};
  }
  return out;
}

//! Sets the i-th bounds, eight of which make a row; appends a row where one begins.
void add_bounds(std::vector<simd8::Bounds8>& rows, int i, const Bounds& bounds, double slop) {
  const int lane = i % simd8::kLanes;
  if (lane == 0) {
    const float inf = std::numeric_limits<float>::infinity();
    rows.emplace_back();
    for (int axis = 0; axis < 3; ++axis) {
      std::fill_n(rows.back().low[axis], simd8::kLanes, inf);
      std::fill_n(rows.back().high[axis], simd8::kLanes, -inf);
    }
  }
  const auto& [low, high] = bounds;
  const double lows[3] = {low.x, low.y, low.z}, highs[3] = {high.x, high.y, high.z};
  for (int axis = 0; axis < 3; ++axis) {
    rows.back().low[axis][lane] = static_cast<float>(lows[axis] - slop);
    rows.back().high[axis][lane] = static_cast<float>(highs[axis] + slop);
  }
}

}  // namespace

World::World(std::vector<Obstacle> obstacles) : obstacles_(std::move(obstacles)) {
  for (const auto& [solid, group, ignored, index] : obstacles_)
    extent_ = std::max(extent_, norm(solid.T.p) + norm(solid.half) + solid.rounding);
  std::stable_sort(obstacles_.begin(), obstacles_.end(),
                   [](const Obstacle& a, const Obstacle& b) { return a.group < b.group; });
  for (const auto& [solid, group, ignored, index] : obstacles_)
    obstacles_single_.push_back({to_single(solid), ignored, index});
  bounds_.reserve(obstacles_.size());  // at most one per obstacle: pointers into it stay valid
  for (int first = 0, n = static_cast<int>(obstacles_.size()); first < n;) {
    int last = first;
    while (last < n && obstacles_[last].group == obstacles_[first].group) ++last;
    add_group(first, last);
    first = last;
  }
}

void World::add_group(int first, int last) {
  const Obstacle *begin = obstacles_.data() + first, *end = obstacles_.data() + last;
  const std::size_t first_bounds = bounds_.size();
  const double slop = 32.0 * simd8::kUnitRoundoff * extent_;
  for (const Obstacle* o = begin; o != end; ++o)
    add_bounds(bounds_, static_cast<int>(o - begin), around(o, o + 1), slop);
  add_bounds(group_bounds_, static_cast<int>(groups_.size()), around(begin, end), slop);
  std::uint64_t ignored = ~std::uint64_t{0};
  for (const Obstacle* o = begin; o != end; ++o) ignored &= o->ignored;
  groups_.push_back({ignored, &obstacles_single_[first], &bounds_[first_bounds], last - first});
}

simd8::WorldData World::single_precision() const {
  return {groups_.data(), group_bounds_.data(), static_cast<int>(groups_.size())};
}

//! In units of u times both lengths: rounding of the obstacle and the difference from its centre (3), into
//! its frame and, for the held item, its axes likewise (7 each), roots, squares and sums of lengths (6 for a
//! point, 10 for a slab), and the threshold (4).
double World::rounding(double reach) const { return 32.0 * simd8::kUnitRoundoff * (reach + extent_); }

}  // namespace apc
