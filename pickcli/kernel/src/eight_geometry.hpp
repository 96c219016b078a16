// Points, places and solids of the hot test, eight lanes wide. Included after APC_ARCHITECTURE is defined.
#pragma once

#include "eight.hpp"
#include "simd.hpp"

namespace apc::eight::APC_ARCHITECTURE {
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

// A solid in eight poses.
struct Placed {
  V R[9];
  V center[3];
  const float* half;
  float rounding;
  SolidKind kind;
};

// A vector of the parent's frame along the axes of a solid (Solid or Placed).
template <typename AnySolid>
APC_INLINE Point turned_into(const AnySolid& solid, const Point& v) {
  return {v.x * solid.R[0] + v.y * solid.R[3] + v.z * solid.R[6], v.x * solid.R[1] + v.y * solid.R[4] + v.z * solid.R[7],
          v.x * solid.R[2] + v.y * solid.R[5] + v.z * solid.R[8]};
}

// Squared distance of a point from the core of a solid (Solid or Placed), zero inside.
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

APC_INLINE Point map(const Place& T, const Ball& s) {
  return {T.p.x + T.R[0] * s.x + T.R[1] * s.y + T.R[2] * s.z, T.p.y + T.R[3] * s.x + T.R[4] * s.y + T.R[5] * s.z,
          T.p.z + T.R[6] * s.x + T.R[7] * s.y + T.R[8] * s.z};
}

APC_INLINE Placed map(const Place& T, const Solid& s) {
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

// A world-aligned box, the same in every lane.
struct Bounds {
  Point low, high;

  // Which of eight obstacles it meets, a bit each.
  APC_INLINE int meets(const EightBounds& boxes) const {
    const Mask apart = above(load(boxes.low[0]), high.x) | above(load(boxes.low[1]), high.y) |
                       above(load(boxes.low[2]), high.z) | above(low.x, load(boxes.high[0])) |
                       above(low.y, load(boxes.high[1])) | above(low.z, load(boxes.high[2]));
    return bits(~apart);
  }
};

}  // namespace
}  // namespace apc::eight::APC_ARCHITECTURE
