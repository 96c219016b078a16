//! \file
//! Points, places and solids of the batch test, eight lanes wide. Included after APC_ARCHITECTURE is defined.
#pragma once

#include "simd/simd8_collision.hpp"
#include "simd/vector8.hpp"

namespace apc::simd8::APC_ARCHITECTURE {
namespace {

struct Point {
  V x, y, z;
};

struct Place {  // of a body in the world, R row-major
  V R[9];
  Point p;
};

APC_INLINE V square(V a) { return a * a; }
APC_INLINE V norm2(const Point& a) { return square(a.x) + square(a.y) + square(a.z); }
APC_INLINE V distance2(const Point& a, const Point& b) { return norm2({a.x - b.x, a.y - b.y, a.z - b.z}); }

//! A solid in eight poses.
struct Placed {
  V R[9];
  V center[3];
  const float* half;
  float rounding;
  SolidKind kind;
  static constexpr bool is_square = false;
};

//! A vector of the parent's frame along the axes of a solid (SolidData or Placed).
template <typename AnySolid>
APC_INLINE Point turned_into(const AnySolid& solid, const Point& v) {
  if (solid.is_square) return v;
  return {v.x * solid.R[0] + v.y * solid.R[3] + v.z * solid.R[6],
          v.x * solid.R[1] + v.y * solid.R[4] + v.z * solid.R[7],
          v.x * solid.R[2] + v.y * solid.R[5] + v.z * solid.R[8]};
}

//! Squared distance of a point from the core of a solid (SolidData or Placed), zero inside.
template <typename AnySolid>
APC_INLINE V distance2(const Point& point, const AnySolid& solid) {
  const float* half = solid.half;
  const V zero{};
  const Point p =
      turned_into(solid, {point.x - solid.center[0], point.y - solid.center[1], point.z - solid.center[2]});
  const V dz = larger(magnitude(p.z) - half[2], zero);
  if (solid.kind == SolidKind::cylinder)
    return square(larger(square_root(square(p.x) + square(p.y)) - half[0], zero)) + square(dz);
  return norm2({larger(magnitude(p.x) - half[0], zero), larger(magnitude(p.y) - half[1], zero), dz});
}

APC_INLINE Point map(const Place& T, float x, float y, float z) {
  return {T.p.x + T.R[0] * x + T.R[1] * y + T.R[2] * z, T.p.y + T.R[3] * x + T.R[4] * y + T.R[5] * z,
          T.p.z + T.R[6] * x + T.R[7] * y + T.R[8] * z};
}

//! How far a box with these half extents, turned with a body, reaches along an axis of the world.
APC_INLINE V extent_along(const V* row, const float* half) {
  return magnitude(row[0]) * half[0] + magnitude(row[1]) * half[1] + magnitude(row[2]) * half[2];
}

APC_INLINE Placed map(const Place& T, const SolidData& s) {
  const float *R = s.R, *c = s.center;
  Placed out{{}, {}, s.half, s.rounding, s.kind};
  const V p[3] = {T.p.x, T.p.y, T.p.z};
  for (int i = 0; i < 3; ++i) {
    const V* r = T.R + 3 * i;
    for (int j = 0; j < 3; ++j) out.R[3 * i + j] = r[0] * R[j] + r[1] * R[3 + j] + r[2] * R[6 + j];
    out.center[i] = p[i] + (r[0] * c[0] + r[1] * c[1] + r[2] * c[2]);
  }
  return out;
}

//! World-aligned bounds.
struct Bounds {
  Point low, high;

  //! Which bounds of eight things these bounds meet, one bit each; these are the same in every lane.
  APC_INLINE int meets(const Bounds& things) const {
    const Mask apart = above(things.low.x, high.x) | above(things.low.y, high.y) |
                       above(things.low.z, high.z) | above(low.x, things.high.x) |
                       above(low.y, things.high.y) | above(low.z, things.high.z);
    return bits(~apart);
  }
};

//! Of eight things.
APC_INLINE Bounds bounds_of(const Bounds8& things) {
  return {{load(things.low[0]), load(things.low[1]), load(things.low[2])},
          {load(things.high[0]), load(things.high[1]), load(things.high[2])}};
}

APC_INLINE Bounds bounds_of(const Points8& points, float half_edge) {
  const V reach = load(points.radius) + half_edge;
  const V x = load(points.center[0]), y = load(points.center[1]), z = load(points.center[2]);
  return {{x - reach, y - reach, z - reach}, {x + reach, y + reach, z + reach}};
}

//! Of one of eight things, in every lane.
APC_INLINE Bounds bounds_of(const Bounds8& things, int i) {
  return {{all(things.low[0][i]), all(things.low[1][i]), all(things.low[2][i])},
          {all(things.high[0][i]), all(things.high[1][i]), all(things.high[2][i])}};
}

//! One of eight points, as a solid.
APC_INLINE SolidData solid_of(const Points8& points, int i, float half_edge) {
  return {{1.0f, 0.0f, 0.0f, 0.0f, 1.0f, 0.0f, 0.0f, 0.0f, 1.0f},
          {points.center[0][i], points.center[1][i], points.center[2][i]},
          {half_edge, half_edge, half_edge},
          points.radius[i],
          half_edge > 0.0f ? SolidKind::box : SolidKind::sphere,
          true};
}

//! Of a solid along the world's axes, in every lane.
APC_INLINE Bounds bounds_around(const SolidData& cube) {
  const V reach = all(cube.half[0] + cube.rounding);
  const V x = all(cube.center[0]), y = all(cube.center[1]), z = all(cube.center[2]);
  return {{x - reach, y - reach, z - reach}, {x + reach, y + reach, z + reach}};
}

//! A ball in every lane.
struct AnyBall {
  Point center;
  V radius;
};

constexpr float kCorner = 1.7320509f;  //!< of a cube: distance of a corner from the centre, over half an edge

//! Around bounds that are the same in every lane.
APC_INLINE AnyBall ball_around(const Bounds& box) {
  const Point half{0.5f * (box.high.x - box.low.x), 0.5f * (box.high.y - box.low.y),
                   0.5f * (box.high.z - box.low.z)};
  return {{box.low.x + half.x, box.low.y + half.y, box.low.z + half.z},
          kCorner * larger(larger(half.x, half.y), half.z)};
}

APC_INLINE V distance2(const Bounds& a, const Bounds& b) {
  const V zero{};
  return norm2({larger(larger(a.low.x - b.high.x, b.low.x - a.high.x), zero),
                larger(larger(a.low.y - b.high.y, b.low.y - a.high.y), zero),
                larger(larger(a.low.z - b.high.z, b.low.z - a.high.z), zero)});
}

}  // namespace
}  // namespace apc::simd8::APC_ARCHITECTURE
