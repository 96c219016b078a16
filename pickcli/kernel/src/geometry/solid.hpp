//! \file
//! Solids in double precision: boxes, cylinders and spheres, each with everything within a rounding of it.
#pragma once

#include <limits>
#include <string>

#include "geometry/linear.hpp"
#include "simd/simd8_collision.hpp"

namespace apc {

using simd8::SolidKind;

//! A core (a box, a cylinder about its z, or a point) and everything within rounding of it. All cores are
//! convex and symmetric about their centre.
struct Solid {
  Pose T;     //!< in the parent's frame
  Vec3 half;  //!< half extents of the core, m
  double rounding = 0.0;
  SolidKind kind = SolidKind::box;
};

//! From the half extents of the solid itself: a cylinder's are (r, r, half length), a sphere's (r, r, r).
//! Throws std::invalid_argument for what is none.
Solid make_solid(const Pose& T, const Vec3& half, SolidKind kind, double rounding);

//! A solid in single precision.
simd8::SolidData to_single(const Solid& solid);

//! How far the core reaches from its centre along a vector of the parent's frame, times the vector's length.
double support(const Solid& solid, const Vec3& direction);

//! The point of the core nearest to a point.
Vec3 nearest(const Solid& solid, const Vec3& point);

//! Negative inside: minus the depth below the surface.
double signed_distance(const Vec3& point, const Solid& solid);

//! A lower bound of the signed distance, from the slabs across faces, pairs of edges and lines of centres; where it
//! is above enough, perhaps not the best of these.
double distance_bound(const Solid& a, const Solid& b, double enough);

//! Exact for solids whose cores are apart. For others minus a depth: exact for two boxes, never too small
//! where there is a cylinder. What is not below enough, or not above too_near, is only found to be so. bound: their
//! distance_bound.
double signed_distance(const Solid& a, const Solid& b, double bound, double enough, double too_near);
inline double signed_distance(const Solid& a, const Solid& b, double enough) {
  return signed_distance(a, b, distance_bound(a, b, enough), enough, -std::numeric_limits<double>::infinity());
}

}  // namespace apc
