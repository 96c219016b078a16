#include "collision/cloud.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

namespace apc {
namespace {

using simd8::kLanes;

//! Everything within radius of the centre, with the user's number of one of the points.
struct Ball {
  Vec3 center;
  double radius;
  int index;
};

Vec3 center_of(const CloudPoints& points, int i) {
  const double* p = points.centers + 3 * static_cast<std::ptrdiff_t>(i);
  return {p[0], p[1], p[2]};
}

//! Which cell of the grid a coordinate is in, in 21 bits.
std::uint64_t cell_along(double coordinate, double width) {
  constexpr double most = 1 << 20;
  const double cell = std::floor(coordinate / width);
  if (!(std::abs(cell) < most)) throw std::invalid_argument("voxel: too small for where the points are");
  return static_cast<std::uint64_t>(cell + most);
}

//! Around the centres of some points.
Ball around(const CloudPoints& points, const std::pair<std::uint64_t, int>* first,
            const std::pair<std::uint64_t, int>* last) {
  Vec3 low = center_of(points, first->second), high = low;
  for (const auto* entry = first; entry != last; ++entry) {
    const Vec3 c = center_of(points, entry->second);
    low = {std::min(low.x, c.x), std::min(low.y, c.y), std::min(low.z, c.z)};
    high = {std::max(high.x, c.x), std::max(high.y, c.y), std::max(high.z, c.z)};
  }
  Ball ball{0.5 * (low + high), 0.0, first->second};
  for (const auto* entry = first; entry != last; ++entry)
    ball.radius = std::max(ball.radius, norm(center_of(points, entry->second) - ball.center));
  return ball;
}

//! One ball for each cell of the grid that has points in it, or for each point.
std::vector<Ball> thinned(const CloudPoints& points) {
  std::vector<Ball> balls;
  if (points.voxel <= 0.0) {
    balls.reserve(static_cast<std::size_t>(points.n));
    for (int i = 0; i < points.n; ++i) balls.push_back({center_of(points, i), 0.0, i});
    return balls;
  }
  std::vector<std::pair<std::uint64_t, int>> by_cell;
  by_cell.reserve(static_cast<std::size_t>(points.n));
  for (int i = 0; i < points.n; ++i) {
    const Vec3 c = center_of(points, i);
    by_cell.emplace_back(cell_along(c.x, points.voxel) << 42 | cell_along(c.y, points.voxel) << 21 |
                             cell_along(c.z, points.voxel),
                         i);
  }
  std::sort(by_cell.begin(), by_cell.end());
  const auto *first = by_cell.data(), *end = first + by_cell.size();
  while (first != end) {
    const auto* last = first + 1;
    while (last != end && last->first == first->first) ++last;
    balls.push_back(around(points, first, last));
    first = last;
  }
  return balls;
}

}  // namespace

Cloud::Cloud(const CloudPoints& points)
    : half_edge_(static_cast<float>(points.half_edge * (1.0 + 2.0 * simd8::kUnitRoundoff))) {
  if (!(points.radius >= 0.0)) throw std::invalid_argument("radius: must not be negative");
  if (!(points.half_edge >= 0.0)) throw std::invalid_argument("edge: must not be negative");
  if (!(points.voxel >= 0.0)) throw std::invalid_argument("voxel: must not be negative");
  const std::vector<Ball> balls = thinned(points);
  std::vector<Vec3> centers;
  centers.reserve(balls.size());
  for (const Ball& ball : balls) {
    centers.push_back(ball.center);
    extent_ = std::max(extent_, norm(ball.center) + ball.radius);
  }
  extent_ += points.radius + 2.0 * points.half_edge;
  const double slop = 32.0 * simd8::kUnitRoundoff * extent_;
  const std::vector<int> order = spatial_order(centers);
  const std::size_t n_rows = (order.size() + kLanes - 1) / kLanes;
  simd8::Points8 nowhere;
  for (int lane = 0; lane < kLanes; ++lane) {
    for (auto& axis : nowhere.center) axis[lane] = std::numeric_limits<float>::infinity();
    nowhere.radius[lane] = 0.0f;
  }
  rows_.assign(n_rows, nowhere);
  constexpr double inf = std::numeric_limits<double>::infinity();
  std::vector<Bounds> bounds(n_rows, {{inf, inf, inf}, {-inf, -inf, -inf}});
  index_.reserve(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    const Ball& ball = balls[static_cast<std::size_t>(order[i])];
    // Rounded such that the ball still holds what it held.
    const double radius = points.radius + ball.radius + 2.0 * simd8::kUnitRoundoff * extent_,
                 reach = radius + points.half_edge;
    const Vec3& c = ball.center;
    simd8::Points8& row = rows_[i / kLanes];
    const std::size_t lane = i % kLanes;
    row.center[0][lane] = static_cast<float>(c.x);
    row.center[1][lane] = static_cast<float>(c.y);
    row.center[2][lane] = static_cast<float>(c.z);
    row.radius[lane] = static_cast<float>(radius);
    bounds[i / kLanes] =
        around(bounds[i / kLanes], {c - Vec3{reach, reach, reach}, c + Vec3{reach, reach, reach}});
    index_.push_back(ball.index);
  }
  tree_ = BoundsTree(bounds, slop);
}

Solid Cloud::solid(int i) const {
  const simd8::Points8& row = rows_[static_cast<std::size_t>(i / kLanes)];
  const int lane = i % kLanes;
  const double half = half_edge_;
  return {{{}, {row.center[0][lane], row.center[1][lane], row.center[2][lane]}},
          {half, half, half},
          row.radius[lane],
          SolidKind::box};
}

simd8::CloudData Cloud::single_precision() const {
  return {tree_.single_precision(), rows_.data(), index_.data(), half_edge_, 0};
}

}  // namespace apc
