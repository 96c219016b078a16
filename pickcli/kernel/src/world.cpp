#include "world.hpp"

#include <algorithm>
#include <limits>

namespace apc {
namespace {

// The box with the orientation R around the obstacles [first, last).
Solid around(const Mat3& R, const Obstacle* first, const Obstacle* last) {
  const double inf = std::numeric_limits<double>::infinity();
  Vec3 low{inf, inf, inf}, high{-inf, -inf, -inf};
  for (const Obstacle* obstacle = first; obstacle != last; ++obstacle) {
    const Solid& solid = obstacle->solid;
    const auto half = [&](int axis) { return support(solid, R.column(axis)) + solid.rounding; };
    const Vec3 c = transposed(R) * solid.T.p, h{half(0), half(1), half(2)};
    low = {std::min(low.x, c.x - h.x), std::min(low.y, c.y - h.y), std::min(low.z, c.z - h.z)};
    high = {std::max(high.x, c.x + h.x), std::max(high.y, c.y + h.y), std::max(high.z, c.z + h.z)};
  }
  return {{R, R * (0.5 * (low + high))}, 0.5 * (high - low)};
}

// Appends the i-th bounds to a row of eights; aligned: a world-aligned box.
void add_bounds(std::vector<eight::EightBounds>& eights, int i, const Solid& aligned, double slop) {
  const int lane = i % eight::kLanes;
  if (lane == 0) {
    const float inf = std::numeric_limits<float>::infinity();
    eights.emplace_back();
    for (int axis = 0; axis < 3; ++axis) {
      std::fill_n(eights.back().low[axis], eight::kLanes, inf);
      std::fill_n(eights.back().high[axis], eight::kLanes, -inf);
    }
  }
  const Vec3 low = aligned.T.p - aligned.half, high = aligned.T.p + aligned.half;
  const double lows[3] = {low.x, low.y, low.z}, highs[3] = {high.x, high.y, high.z};
  for (int axis = 0; axis < 3; ++axis) {
    eights.back().low[axis][lane] = static_cast<float>(lows[axis] - slop);
    eights.back().high[axis][lane] = static_cast<float>(highs[axis] + slop);
  }
}

double volume(const Solid& box) { return box.half.x * box.half.y * box.half.z; }

}  // namespace

World::World(std::vector<Obstacle> obstacles) : obstacles_(std::move(obstacles)) {
  for (const auto& [solid, group, ignored, index] : obstacles_)
    extent_ = std::max(extent_, norm(solid.T.p) + norm(solid.half) + solid.rounding);
  std::stable_sort(obstacles_.begin(), obstacles_.end(),
                   [](const Obstacle& a, const Obstacle& b) { return a.group < b.group; });
  for (const auto& [solid, group, ignored, index] : obstacles_)
    single_obstacles_.push_back({to_single(solid), ignored, index});
  bounds_.reserve(obstacles_.size());  // at most one per obstacle: pointers into it stay valid
  for (int first = 0, n = static_cast<int>(obstacles_.size()); first < n;) {
    int last = first;
    while (last < n && obstacles_[last].group == obstacles_[first].group) ++last;
    add_group(first, last);
    first = last;
  }
}

// The group's own box takes the best of its members' orientations.
void World::add_group(int first, int last) {
  const Obstacle *begin = obstacles_.data() + first, *end = obstacles_.data() + last;
  const std::size_t first_bounds = bounds_.size();
  const double slop = 32.0 * eight::kUnitRoundoff * extent_;
  for (const Obstacle* o = begin; o != end; ++o)
    add_bounds(bounds_, static_cast<int>(o - begin), around(Mat3{}, o, o + 1), slop);
  Solid best = around(Mat3{}, begin, end);
  add_bounds(group_bounds_, static_cast<int>(groups_.size()), best, slop);
  std::uint64_t ignored = ~std::uint64_t{0};
  for (const Obstacle* o = begin; o != end; ++o) {
    const Solid candidate = around(o->solid.T.R, begin, end);
    if (volume(candidate) < volume(best)) best = candidate;
    ignored &= o->ignored;
  }
  best.half = best.half + Vec3{slop, slop, slop};
  groups_.push_back({{to_single(best), ignored, -1}, &single_obstacles_[first], &bounds_[first_bounds], last - first});
}

eight::World World::single() const {
  return {groups_.data(), group_bounds_.data(), static_cast<int>(groups_.size())};
}

// In units of u times both lengths: rounding of the obstacle and the difference from its centre (3), into its
// frame and, for the held item, its axes likewise (7 each), roots, squares and sums of lengths (6 for a point,
// 10 for a slab), and the threshold (4).
double World::rounding(double reach) const { return 32.0 * eight::kUnitRoundoff * (reach + extent_); }

}  // namespace apc
