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
  for (int first = 0, n = static_cast<int>(boxes_.size()); first < n;) {
    int last = first;
    while (last < n && boxes_[last].group == boxes_[first].group) ++last;
    add_group(first, last);
    first = last;
  }
}

// The group's own box takes the best of its members' orientations.
void World::add_group(int first, int last) {
  Box best = around(Mat3{}, &boxes_[first], &boxes_[0] + last);
  for (int i = first; i < last; ++i) {
    const Box candidate = around(boxes_[i].T_world_box.R, &boxes_[first], &boxes_[0] + last);
    if (volume(candidate) < volume(best)) best = candidate;
  }
  for (int i = first; i < last; ++i) best.ignored &= boxes_[i].ignored;
  const double slop = 32.0 * eight::kUnitRoundoff * extent_;
  best.half = best.half + Vec3{slop, slop, slop};
  groups_.push_back({to_single(best), first, last - first});
}

// Difference from the centre (2 u of both lengths), product with the rotation (6 u), squares and their
// sum, and the squared threshold (4 u).
double World::rounding(double reach) const { return 12.0 * eight::kUnitRoundoff * (reach + extent_); }

}  // namespace apc
