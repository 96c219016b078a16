#include "world.hpp"

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <string>

namespace apc {
namespace {

eight::Box to_single(const Box& box) {
  eight::Box single{};
  for (int i = 0; i < 9; ++i) single.R[i] = static_cast<float>(box.T_world_box.R.m[i]);
  const Vec3 &c = box.T_world_box.p, &h = box.half;
  for (int i = 0; i < 3; ++i) {
    single.center[i] = static_cast<float>(i == 0 ? c.x : i == 1 ? c.y : c.z);
    single.half[i] = static_cast<float>(i == 0 ? h.x : i == 1 ? h.y : h.z);
  }
  single.ignored = box.ignored;
  single.index = box.index;
  return single;
}

// The box with the orientation R around the boxes [first, last).
Box around(const Mat3& R, const Box* first, const Box* last) {
  const double inf = std::numeric_limits<double>::infinity();
  Vec3 low{inf, inf, inf}, high{-inf, -inf, -inf};
  for (const Box* box = first; box != last; ++box) {
    const Mat3 M = transposed(R) * box->T_world_box.R;
    const Vec3 c = transposed(R) * box->T_world_box.p;
    const auto half = [&](int i) {
      return std::abs(M(i, 0)) * box->half.x + std::abs(M(i, 1)) * box->half.y + std::abs(M(i, 2)) * box->half.z;
    };
    const Vec3 h{half(0), half(1), half(2)};
    low = {std::min(low.x, c.x - h.x), std::min(low.y, c.y - h.y), std::min(low.z, c.z - h.z)};
    high = {std::max(high.x, c.x + h.x), std::max(high.y, c.y + h.y), std::max(high.z, c.z + h.z)};
  }
  return {{R, R * (0.5 * (low + high))}, 0.5 * (high - low), first->group, ~std::uint64_t{0}, -1};
}

// Appends the i-th bounds to a row of eights; aligned: a world-aligned box.
void add_bounds(std::vector<eight::EightBounds>& eights, int i, const Box& aligned, double slop) {
  const int lane = i % eight::kLanes;
  if (lane == 0) {
    const float inf = std::numeric_limits<float>::infinity();
    eights.emplace_back();
    for (int axis = 0; axis < 3; ++axis) {
      std::fill_n(eights.back().low[axis], eight::kLanes, inf);
      std::fill_n(eights.back().high[axis], eight::kLanes, -inf);
    }
  }
  const Vec3 low = aligned.T_world_box.p - aligned.half, high = aligned.T_world_box.p + aligned.half;
  const double lows[3] = {low.x, low.y, low.z}, highs[3] = {high.x, high.y, high.z};
  for (int axis = 0; axis < 3; ++axis) {
    eights.back().low[axis][lane] = static_cast<float>(lows[axis] - slop);
    eights.back().high[axis][lane] = static_cast<float>(highs[axis] + slop);
  }
}

double volume(const Box& box) { return box.half.x * box.half.y * box.half.z; }

}  // namespace

double signed_distance(const Vec3& point, const Box& box) {
  const Vec3 p = transposed(box.T_world_box.R) * (point - box.T_world_box.p);
  const Vec3 d{std::abs(p.x) - box.half.x, std::abs(p.y) - box.half.y, std::abs(p.z) - box.half.z};
  const double outside = norm({std::max(d.x, 0.0), std::max(d.y, 0.0), std::max(d.z, 0.0)});
  return outside > 0.0 ? outside : std::max({d.x, d.y, d.z});
}

World::World(std::vector<Box> boxes) : boxes_(std::move(boxes)) {
  for (const Box& box : boxes_) {
    if (!(box.half.x >= 0.0 && box.half.y >= 0.0 && box.half.z >= 0.0))
      throw std::invalid_argument("box " + std::to_string(box.index) + ": negative half extent");
    extent_ = std::max(extent_, norm(box.T_world_box.p) + norm(box.half));
  }
  std::stable_sort(boxes_.begin(), boxes_.end(), [](const Box& a, const Box& b) { return a.group < b.group; });
  for (const Box& box : boxes_) single_boxes_.push_back(to_single(box));
  box_bounds_.reserve(boxes_.size());  // at most one per box: pointers into it stay valid
  for (int first = 0, n = static_cast<int>(boxes_.size()); first < n;) {
    int last = first;
    while (last < n && boxes_[last].group == boxes_[first].group) ++last;
    add_group(first, last);
    first = last;
  }
}

// The group's own box takes the best of its members' orientations.
void World::add_group(int first, int last) {
  const Box *begin = boxes_.data() + first, *end = boxes_.data() + last;
  const std::size_t first_bounds = box_bounds_.size();
  const double slop = 32.0 * eight::kUnitRoundoff * extent_;
  for (const Box* box = begin; box != end; ++box)
    add_bounds(box_bounds_, static_cast<int>(box - begin), around(Mat3{}, box, box + 1), slop);
  Box best = around(Mat3{}, begin, end);
  add_bounds(group_bounds_, static_cast<int>(groups_.size()), best, slop);
  for (const Box* box = begin; box != end; ++box) {
    const Box candidate = around(box->T_world_box.R, begin, end);
    if (volume(candidate) < volume(best)) best = candidate;
  }
  for (const Box* box = begin; box != end; ++box) best.ignored &= box->ignored;
  best.half = best.half + Vec3{slop, slop, slop};
  groups_.push_back({to_single(best), &single_boxes_[first], &box_bounds_[first_bounds], last - first});
}

eight::World World::single() const {
  return {groups_.data(), group_bounds_.data(), static_cast<int>(groups_.size())};
}

// Difference from the centre (2 u of both lengths), product with the rotation (6 u), squares and their
// sum, and the squared threshold (4 u).
double World::rounding(double reach) const { return 12.0 * eight::kUnitRoundoff * (reach + extent_); }

}  // namespace apc
