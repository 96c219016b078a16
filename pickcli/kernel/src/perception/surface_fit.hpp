//! \file
//! Poses of solids to points measured on their surfaces: Powell's dogleg on analytic distances.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "geometry/solid.hpp"

namespace apc {

//! How far a point is from the surface of a solid, negative inside, and where that grows fastest.
struct SurfaceDistance {
  double distance = 0.0;
  Vec3 gradient;  //!< of length 1
};

//! Both in the solid's frame. half: of the solid itself; a cylinder's are (r, r, half length).
SurfaceDistance surface_distance(SolidKind kind, const Vec3& half, const Vec3& point);

//! The same distance alone.
inline double distance_to_surface(SolidKind kind, const Vec3& half, const Vec3& point) {
  if (kind == SolidKind::sphere) return norm(point) - half.x;
  if (kind == SolidKind::cylinder) {
    const double across = std::sqrt(point.x * point.x + point.y * point.y);
    const double q = across - half.x, r = std::abs(point.z) - half.z;
    return q <= 0.0 || r <= 0.0 ? std::max(q, r) : std::sqrt(q * q + r * r);
  }
  const Vec3 q{std::abs(point.x) - half.x, std::abs(point.y) - half.y, std::abs(point.z) - half.z};
  const double d = norm(Vec3{std::max(q.x, 0.0), std::max(q.y, 0.0), std::max(q.z, 0.0)});
  return d > 0.0 ? d : std::max({q.x, q.y, q.z});
}

//! What may move in a fit.
enum class Freedom { upright, all };  //!< position and turns about one direction, or all turns

struct FitSettings {
  double scale = 0.006;  //!< m at which a point begins to count as one of something else (Geman and McClure)
  Freedom freedom = Freedom::upright;
  Vec3 up{0.0, 0.0, 1.0};  //!< axis of the turns of an upright fit
  int most_steps = 12;
};

struct SurfaceFit {
  Pose T;
  double cost = 0.0;  //!< mean of d^2 / (scale^2 + d^2) over the points, in [0, 1)
  int steps = 0;
};

//! A local minimum of the cost near a start. Without points: the start.
SurfaceFit fit_surface(SolidKind kind, const Vec3& half, const std::vector<Vec3>& points, const Pose& start,
                       const FitSettings& settings);

}  // namespace apc
