// Points, places and boxes of the hot test, eight lanes wide. Included after APC_ARCHITECTURE is defined.
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

// Squared distance of a point from a box, zero inside.
APC_INLINE V distance2(const Point& point, const Box& box) {
  const V x = point.x - box.center[0], y = point.y - box.center[1], z = point.z - box.center[2];
  const V zero{};
  const V dx = larger(magnitude(x * box.R[0] + y * box.R[3] + z * box.R[6]) - box.half[0], zero);
  const V dy = larger(magnitude(x * box.R[1] + y * box.R[4] + z * box.R[7]) - box.half[1], zero);
  const V dz = larger(magnitude(x * box.R[2] + y * box.R[5] + z * box.R[8]) - box.half[2], zero);
  return norm2({dx, dy, dz});
}

APC_INLINE Point map(const Place& T, const Ball& s) {
  return {T.p.x + T.R[0] * s.x + T.R[1] * s.y + T.R[2] * s.z, T.p.y + T.R[3] * s.x + T.R[4] * s.y + T.R[5] * s.z,
          T.p.z + T.R[6] * s.x + T.R[7] * s.y + T.R[8] * s.z};
}

// A world-aligned box, the same in every lane.
struct Bounds {
  Point low, high;

  // Which of eight boxes it meets, a bit each.
  APC_INLINE int meets(const EightBounds& boxes) const {
    const Mask apart = above(load(boxes.low[0]), high.x) | above(load(boxes.low[1]), high.y) |
                       above(load(boxes.low[2]), high.z) | above(low.x, load(boxes.high[0])) |
                       above(low.y, load(boxes.high[1])) | above(low.z, load(boxes.high[2]));
    return bits(~apart);
  }
};

}  // namespace
}  // namespace apc::eight::APC_ARCHITECTURE
