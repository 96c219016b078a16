#include "geometry/solid.hpp"

#include <algorithm>
#include <limits>
#include <stdexcept>

namespace apc {
namespace {

constexpr double kTouching = 1e-12;  //!< m between two cores
constexpr double kExact = 1e-10;     //!< m between what is proven and what is found
constexpr int kMostSteps = 1000;

//! The directions of faces and edges.
struct Axes {
  explicit Axes(const Solid& solid) {
    for (int i = solid.kind == SolidKind::box ? 0 : solid.kind == SolidKind::cylinder ? 2 : 3; i < 3; ++i)
      axes[n++] = solid.T.R.column(i);
  }
  const Vec3* begin() const { return axes; }
  const Vec3* end() const { return axes + n; }

  Vec3 axes[3];
  int n = 0;
};

//! A lower bound of the distance of two cores: the width of the slab across a direction that separates them,
//! negative if it does not. The largest over all directions is the distance.
double gap(const Solid& a, const Solid& b, const Vec3& direction) {
  const double length = norm(direction);
  if (!(length > 1e-9)) return -std::numeric_limits<double>::infinity();
  return (std::abs(dot(direction, a.T.p - b.T.p)) - support(a, direction) - support(b, direction)) / length;
}

}  // namespace

Solid make_solid(const Pose& T, const Vec3& half, SolidKind kind, double rounding) {
  if (!(half.x >= 0.0 && half.y >= 0.0 && half.z >= 0.0))
    throw std::invalid_argument("half extents " + std::to_string(half.x) + ", " + std::to_string(half.y) +
                                ", " + std::to_string(half.z) + " m: must be at least 0");
  if (!(rounding >= 0.0))
    throw std::invalid_argument("rounding " + std::to_string(rounding) + " m: must be at least 0");
  if ((kind != SolidKind::box && half.x != half.y) || (kind == SolidKind::sphere && half.y != half.z))
    throw std::invalid_argument("the half extents of a round solid must be its radius where it is round");
  if (kind == SolidKind::sphere) return {T, {}, half.x + rounding, kind};
  return {T, half, rounding, kind};
}

simd8::SolidData to_single(const Solid& solid) {
  simd8::SolidData single{};
  for (int i = 0; i < 9; ++i) single.R[i] = static_cast<float>(solid.T.R.m[i]);
  const Vec3 &c = solid.T.p, &h = solid.half;
  for (int i = 0; i < 3; ++i) {
    single.center[i] = static_cast<float>(i == 0 ? c.x : i == 1 ? c.y : c.z);
    single.half[i] = static_cast<float>(i == 0 ? h.x : i == 1 ? h.y : h.z);
  }
  single.rounding = static_cast<float>(solid.rounding);
  single.kind = solid.kind;
  single.is_square = solid.T.R.m == Mat3{}.m;
  return single;
}

double support(const Solid& solid, const Vec3& direction) {
  const Vec3 d = transposed(solid.T.R) * direction, &h = solid.half;
  const double along = std::abs(d.z) * h.z;
  if (solid.kind == SolidKind::cylinder) return along + h.x * std::sqrt(d.x * d.x + d.y * d.y);
  return along + std::abs(d.x) * h.x + std::abs(d.y) * h.y;
}

Vec3 nearest(const Solid& solid, const Vec3& point) {
  Vec3 p = transposed(solid.T.R) * (point - solid.T.p);
  const Vec3& h = solid.half;
  if (solid.kind == SolidKind::cylinder) {
    const double across = std::sqrt(p.x * p.x + p.y * p.y), scale = across > h.x ? h.x / across : 1.0;
    p.x *= scale;
    p.y *= scale;
  } else {
    p.x = std::clamp(p.x, -h.x, h.x);
    p.y = std::clamp(p.y, -h.y, h.y);
  }
  p.z = std::clamp(p.z, -h.z, h.z);
  return solid.T * p;
}

double signed_distance(const Vec3& point, const Solid& solid) {
  const Vec3 p = transposed(solid.T.R) * (point - solid.T.p), &h = solid.half;
  Vec3 d{std::abs(p.x) - h.x, std::abs(p.y) - h.y, std::abs(p.z) - h.z};
  if (solid.kind == SolidKind::cylinder) d.x = d.y = std::sqrt(p.x * p.x + p.y * p.y) - h.x;
  const double across = solid.kind == SolidKind::cylinder ? 0.0 : std::max(d.y, 0.0);
  const double outside = norm({std::max(d.x, 0.0), across, std::max(d.z, 0.0)});
  return (outside > 0.0 ? outside : std::max({d.x, d.y, d.z})) - solid.rounding;
}

double distance_bound(const Solid& a, const Solid& b, double enough) {
  const double rounding = a.rounding + b.rounding;
  const Axes of_a(a), of_b(b);
  const Vec3 between = a.T.p - b.T.p;
  double widest = gap(a, b, between) - rounding;
  const auto is_enough = [&](const Vec3& direction) {
    widest = std::max(widest, gap(a, b, direction) - rounding);
    return widest > enough;
  };
  if (widest > enough) return widest;
  for (const Axes* own : {&of_a, &of_b})
    for (const Vec3& axis : *own)
      if (is_enough(axis) || is_enough(between - dot(between, axis) * axis)) return widest;
  for (const Vec3& x : of_a)
    for (const Vec3& y : of_b)
      if (is_enough(cross(x, y))) return widest;
  return widest;
}

//! From one core to the nearest point of the other and back (von Neumann), each time from a little farther
//! along (Nesterov): the points found bound the distance from above, the slab between them from below.
double signed_distance(const Solid& a, const Solid& b, double bound, double enough, double too_near) {
  const double rounding = a.rounding + b.rounding;
  const bool are_boxes = a.kind == SolidKind::box && b.kind == SolidKind::box;
  if (are_boxes && bound < -rounding) return bound;  // faces and edges tell the depth of two boxes
  double proven = bound + rounding;
  Vec3 from = a.T.p, before = from;
  for (int i = 0; i < kMostSteps && proven - rounding < enough; ++i) {
    const Vec3 on_b = nearest(b, from), on_a = nearest(a, on_b), between = on_a - on_b;
    const double found = norm(between);
    if (found < kTouching || found - rounding <= too_near) break;
    proven = std::max(proven, gap(a, b, between));
    if (found - proven < kExact) break;
    from = on_a + (i / (i + 3.0)) * (on_a - before);
    before = on_a;
  }
  return proven - rounding;
}

}  // namespace apc
