//! \file
//! Lower bounds of the distance of two solids, eight lanes wide.
//!
//! Across any direction, the slab between two convex solids is no wider than their distance: whatever
//! direction is tried, what it gives is a proof, and rounding of the direction itself does no harm. Only how
//! sharp the bound is depends on the choice. Faces, pairs of edges and a few steps towards the nearest points
//! are tried.
#pragma once

#include "simd/simd8_geometry.hpp"

namespace apc::simd8::APC_ARCHITECTURE {
namespace {

class DistanceBound {
 public:
  //! moving and standing in one frame.
  DistanceBound(const Placed& moving, const SolidData& standing) : moving_(moving), standing_(standing) {
    // The moving one as seen from the standing one.
    for (int j = 0; j < 3; ++j)
      axes_[j] = turned_into(standing, {moving.R[j], moving.R[3 + j], moving.R[6 + j]});
    between_ =
        turned_into(standing, {moving.center[0] - standing.center[0], moving.center[1] - standing.center[1],
                               moving.center[2] - standing.center[2]});
  }

  //! Of the cores, at least zero. Ends as soon as it is known in all of the lanes live whether it is above near and
  //! above far: points of the two that are nearer than that tell, too.
  V widest(V near, V far, int live) {
    near_ = near, far_ = far, live_ = live;
    try_faces();
    if (is_known()) return widest_;
    const bool is_round = moving_.kind == SolidKind::cylinder || standing_.kind == SolidKind::cylinder;
    const int n_steps = is_round ? kMostSteps : kSteps;
    if (try_nearest_points(true, kSteps) || try_nearest_points(false, n_steps)) return widest_;
    try_edges();
    return widest_;
  }

 private:
  //! m, far above the rounding of points and slabs.
  static constexpr float kPointError = 1e-5f;

  static constexpr int kSteps = 6;  //!< from one solid to the other and back
  //! The same for cylinders: the direction between a rim and an edge is none of a face or of two edges.
  static constexpr int kMostSteps = 24;

  static int first_axis(SolidKind kind) {
    return kind == SolidKind::box ? 0 : kind == SolidKind::cylinder ? 2 : 3;
  }

  void try_faces() {
    for (int i = first_axis(standing_.kind); i < 3; ++i)
      try_direction(
          {V{} + (i == 0 ? 1.0f : 0.0f), V{} + (i == 1 ? 1.0f : 0.0f), V{} + (i == 2 ? 1.0f : 0.0f)});
    for (int j = first_axis(moving_.kind); j < 3; ++j) try_direction(axes_[j]);
    if (standing_.kind == SolidKind::cylinder) try_direction({between_.x, between_.y, V{}});
    if (moving_.kind == SolidKind::cylinder) {
      const Point& a = axes_[2];
      const V along = inner(between_, a);
      try_direction({between_.x - along * a.x, between_.y - along * a.y, between_.z - along * a.z});
    }
  }

  void try_edges() {
    for (int j = first_axis(moving_.kind); j < 3; ++j) {
      const Point& a = axes_[j];
      for (int i = first_axis(standing_.kind); i < 3; ++i)
        try_direction(i == 0   ? Point{V{}, -a.z, a.y}
                      : i == 1 ? Point{a.z, V{}, -a.x}
                               : Point{-a.y, a.x, V{}});
    }
  }

  //! From the middle of one core to the nearest point of the other and back (von Neumann), again and again,
  //! each time from a little farther along (Nesterov). True: all is known.
  bool try_nearest_points(bool from_moving, int n_steps) {
    Point from = from_moving ? between_ : Point{V{}, V{}, V{}}, before = from;
    for (int i = 0; i < n_steps; ++i) {
      const Point there = from_moving ? nearest_of_standing(from) : nearest_of_moving(from);
      const Point here = from_moving ? nearest_of_moving(there) : nearest_of_standing(there);
      const Point apart{here.x - there.x, here.y - there.y, here.z - there.z};
      try_direction(apart);
      const V found2 = norm2(apart);
      found2_ = select(above(found2_, found2), found2, found2_);
      if (is_known()) return true;
      const float on = static_cast<float>(i) / static_cast<float>(i + 3);
      from = {here.x + (here.x - before.x) * on, here.y + (here.y - before.y) * on,
              here.z + (here.z - before.z) * on};
      before = here;
    }
    return false;
  }

  bool is_known() const {
    const auto is_found_within = [&](V d) { return bits(above(square(larger(d - kPointError, V{})), found2_)); };
    const int beyond_near = bits(above(widest_, near_)), beyond_far = bits(above(widest_, far_));
    return (~(beyond_far | is_found_within(near_) | (beyond_near & is_found_within(far_))) & live_) == 0;
  }

  void try_direction(const Point& d) {
    const Point along{inner(d, axes_[0]), inner(d, axes_[1]), inner(d, axes_[2])};
    const V width = magnitude(inner(d, between_)) -
                    (support(moving_.kind, moving_.half, along) + support(standing_.kind, standing_.half, d));
    widest_ = larger(width / larger(square_root(norm2(d)), V{} + 1e-15f), widest_);  // of a NaN: unchanged
  }

  Point nearest_of_standing(const Point& point) const {
    return nearest(standing_.kind, standing_.half, point);
  }

  Point nearest_of_moving(const Point& point) const {
    const Point p{point.x - between_.x, point.y - between_.y, point.z - between_.z};
    const Point n =
        nearest(moving_.kind, moving_.half, {inner(p, axes_[0]), inner(p, axes_[1]), inner(p, axes_[2])});
    return {between_.x + (axes_[0].x * n.x + axes_[1].x * n.y + axes_[2].x * n.z),
            between_.y + (axes_[0].y * n.x + axes_[1].y * n.y + axes_[2].y * n.z),
            between_.z + (axes_[0].z * n.x + axes_[1].z * n.y + axes_[2].z * n.z)};
  }

  //! In the solid's own frame: how far the core reaches along d, times the length of d.
  static V support(SolidKind kind, const float* half, const Point& d) {
    const V along = magnitude(d.z) * half[2];
    if (kind == SolidKind::cylinder) return along + square_root(square(d.x) + square(d.y)) * half[0];
    return along + (magnitude(d.x) * half[0] + magnitude(d.y) * half[1]);
  }

  //! In the solid's own frame: the point of the core nearest to p.
  static Point nearest(SolidKind kind, const float* half, const Point& p) {
    const V z = clamped(p.z, half[2]);
    if (kind != SolidKind::cylinder) return {clamped(p.x, half[0]), clamped(p.y, half[1]), z};
    const V across = larger(square_root(square(p.x) + square(p.y)), V{} + (half[0] + 1e-15f));
    const V scale = half[0] / across;
    return {p.x * scale, p.y * scale, z};
  }

  static V clamped(V a, float most) { return larger(-larger(-a, V{} - most), V{} - most); }
  static V inner(const Point& a, const Point& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

  const Placed& moving_;
  const SolidData& standing_;
  Point axes_[3], between_;
  V widest_{}, near_{}, far_{};
  V found2_ = V{} + __builtin_inff();  //!< squared distance of two points, one of each
  int live_ = 0;
};

}  // namespace
}  // namespace apc::simd8::APC_ARCHITECTURE
