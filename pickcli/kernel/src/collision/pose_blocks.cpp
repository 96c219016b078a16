#include "collision/pose_blocks.hpp"

#include <algorithm>
#include <cmath>

namespace apc {
namespace {

constexpr int kRoll = 3, kTilt = 4;
constexpr double kRounding = 1e-9;  // m, far above that of a distance

struct Cell {
  std::array<double, 6> low, high;

  std::array<double, 6> middle() const {
    std::array<double, 6> at;
    for (std::size_t k = 0; k < 6; ++k) at[k] = (low[k] + high[k]) / 2;
    return at;
  }
};

//! Signed distance of a point from what a frame may not touch, as far as it is less than `least`.
double clearance(const World& world, const Vec3& point, int frame, double least) {
  const auto nearest = [&] { return std::max(least, 0.0); };
  world.tree().visit_near(point, nearest, [&](int i) {
    const Obstacle& obstacle = world.obstacles()[static_cast<std::size_t>(i)];
    if (!(obstacle.ignored >> frame & 1)) least = std::min(least, signed_distance(point, obstacle.solid));
  });
  if (world.ignored_by_cloud() >> frame & 1) return least;
  const Cloud& cloud = *world.cloud();
  cloud.tree().visit_near(point, nearest, [&](int row) {
    const int first = simd8::kLanes * row, last = std::min(first + simd8::kLanes, cloud.size());
    for (int i = first; i < last; ++i) least = std::min(least, signed_distance(point, cloud.solid(i)));
  });
  return least;
}

//! Proof of one block for one sphere.
class SphereProof {
 public:
  SphereProof(const EnvelopeChart& chart, const ToolSphere& sphere, const World& world, const ProofEffort& effort)
      : chart_(chart), sphere_(sphere), world_(world), effort_(effort), reach_(norm(sphere.center)),
        off_axis_(std::hypot(sphere.center.x, sphere.center.y)) {}

  //! Counts cells down; false where a cell is not free, or not proven by what is left.
  bool run(const Cell& block, int& n_left) {
    stack_.assign(1, block);
    while (!stack_.empty()) {
      const Cell cell = stack_.back();
      stack_.pop_back();
      if (!is_in_cone(cell)) continue;
      const std::array<double, 6> at = cell.middle();
      const Vec3 center = chart_.palm(at.data()) * sphere_.center;
      const std::array<double, 6> motion = most_motion(cell);
      double total = 0.0;
      for (double each : motion) total += each;
      const double kept = sphere_.radius + effort_.margin;
      const double free = clearance(world_, center, sphere_.frame, kept + 2.0 * total + kRounding) - kept;
      if (free > total) continue;
      if (total < effort_.smallest || --n_left < 0 || (free < 0.0 && is_in_cone(at))) return false;
      divide(cell, static_cast<std::size_t>(std::max_element(motion.begin(), motion.end()) - motion.begin()));
    }
    return true;
  }

 private:
  //! Whether a cell contains a tilt of the cone.
  bool is_in_cone(const Cell& cell) const {
    double squared = 0.0;
    for (std::size_t k = kTilt; k < 6; ++k) {
      const double nearest = std::max({0.0, cell.low[k], -cell.high[k]});
      squared += nearest * nearest;
    }
    return squared <= chart_.cone * chart_.cone;
  }

  //! Whether a tilt is in the cone; the middle of a cell that only cuts the cone may not be.
  bool is_in_cone(const std::array<double, 6>& at) const {
    return std::hypot(at[kTilt], at[kTilt + 1]) <= chart_.cone;
  }

  //! m that the centre moves at most from the middle of a cell, by each coordinate. Azimuth and elevation turn the
  //! whole tool about the surface's middle; a rotation vector turns it by no more than it changes.
  std::array<double, 6> most_motion(const Cell& cell) const {
    std::array<double, 6> lever;
    lever.fill(reach_);
    const std::size_t n_angles = static_cast<std::size_t>(chart_.surface);
    for (std::size_t k = 0; k < 3; ++k) lever[k] = k < n_angles ? cell.high[2] + reach_ : 1.0;
    lever[kRoll] = off_axis_;
    for (std::size_t k = 0; k < 6; ++k) lever[k] *= (cell.high[k] - cell.low[k]) / 2;
    return lever;
  }

  void divide(const Cell& cell, std::size_t k) {
    Cell first = cell, second = cell;
    first.high[k] = second.low[k] = (cell.low[k] + cell.high[k]) / 2;
    stack_.push_back(first);
    stack_.push_back(second);
  }

  const EnvelopeChart& chart_;
  const ToolSphere& sphere_;
  const World& world_;
  const ProofEffort& effort_;
  const double reach_, off_axis_;
  std::vector<Cell> stack_;
};

}  // namespace

Pose EnvelopeChart::palm(const double* c) const {
  Vec3 normal{0.0, 0.0, 1.0}, point{c[0], c[1], c[2]};
  if (surface == SurfaceKind::cylinder) {
    normal = {std::cos(c[0]), std::sin(c[0]), 0.0};
    point = c[2] * normal + Vec3{0.0, 0.0, c[1]};
  } else if (surface == SurfaceKind::sphere) {
    normal = {std::cos(c[1]) * std::cos(c[0]), std::cos(c[1]) * std::sin(c[0]), std::sin(c[1])};
    point = c[2] * normal;
  }
  normal = T_world_surface.R * normal;
  Vec3 x = wanted - dot(wanted, normal) * normal;
  const double size = norm(x);
  x = size > 1e-9 ? (1.0 / size) * x : cross(normal, T_world_surface.R.column(0));
  const Vec3 y = cross(-1.0 * normal, x);
  const double cosine = std::cos(c[kRoll]), sine = std::sin(c[kRoll]);
  const Mat3 rolled = from_columns(cosine * x + sine * y, cosine * y - sine * x, -1.0 * normal);
  const Vec3 tilt = c[kTilt] * x + c[kTilt + 1] * y;
  const double angle = norm(tilt);
  const Mat3 turned = angle > 1e-12 ? rotation((1.0 / angle) * tilt, angle) * rolled : rolled;
  return {turned * R_nominal, T_world_surface * point};
}

int first_unproven(const EnvelopeChart& chart, const std::vector<ToolSphere>& spheres, const World& world,
                   const double* low, const double* high, const ProofEffort& effort) {
  Cell block;
  std::copy(low, low + 6, block.low.begin());
  std::copy(high, high + 6, block.high.begin());
  int n_left = effort.most_cells;
  for (std::size_t i = 0; i < spheres.size(); ++i)
    if (!SphereProof(chart, spheres[i], world, effort).run(block, n_left)) return static_cast<int>(i);
  return -1;
}

}  // namespace apc
