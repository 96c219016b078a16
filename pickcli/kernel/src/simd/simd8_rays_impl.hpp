//! \file
//! The rays of simd8_rays.hpp, for one instruction set. The includer defines APC_ARCHITECTURE.
//!
//! A ray that is parallel to a face divides by zero: the infinities of IEEE 754 are then the right answer.
#include "simd/simd8_rays.hpp"
#include "simd/vector8.hpp"

#include <limits>

namespace apc::simd8::APC_ARCHITECTURE {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

struct Rays {
  V d[3];  //!< in the solid's frame, of depth 1
};

//! Depths between which rays are inside.
struct Span {
  V near = all(-kInfinity), far = all(kInfinity);
};

//! In a face, 0 * infinity is a NaN; it comes second below, and leaves the span as it was.
APC_INLINE void cut_by_slab(Span& span, V direction, float eye, float half) {
  const V inverse = 1.0f / direction;
  const V low = (-half - eye) * inverse, high = (half - eye) * inverse;
  span.near = larger(smaller(high, low), span.near);
  span.far = smaller(larger(low, high), span.far);
}

APC_INLINE void cut_by_plane(Span& span, const Rays& rays, const PlaneData& plane) {
  const V rate = plane.normal[0] * rays.d[0] + plane.normal[1] * rays.d[1] + plane.normal[2] * rays.d[2];
  const V depth = plane.clearance / rate;
  const Mask enters = above(V{}, rate), leaves = above(rate, V{});
  span.near = select(enters, larger(depth, span.near), span.near);
  span.far = select(leaves, smaller(depth, span.far), span.far);
  if (plane.clearance < 0.0f) span.far = select(enters | leaves, span.far, all(-kInfinity));  // parallel
}

//! Where rays are inside of a ball, or with two axes of a round cylinder: half a chord to both sides of the
//! point nearest to the centre. From there, and not from the eye, the radius is no small difference of large
//! numbers.
template <int kAxes>
APC_INLINE void cut_by_round(Span& span, const Rays& rays, const SeenSolid& solid) {
  V length2{}, along{};
  for (int i = 0; i < kAxes; ++i) {
    length2 += rays.d[i] * rays.d[i];
    along += solid.eye[i] * rays.d[i];
  }
  const Mask is_parallel = not_above(length2, all(1e-30f));  // to the cylinder's axis
  const V inverse = 1.0f / length2, middle = select(is_parallel, V{}, -along * inverse);
  V distance2{};
  for (int i = 0; i < kAxes; ++i) {
    const V p = solid.eye[i] + middle * rays.d[i];
    distance2 += p * p;
  }
  const V inside = solid.half[0] * solid.half[0] - distance2;
  const Mask misses = not_above(inside, V{});
  const V half_chord = square_root(larger(inside, V{}) * inverse);
  span.near = larger(middle - half_chord, span.near);
  span.far = select(misses, all(-kInfinity), smaller(middle + half_chord, span.far));
}

APC_INLINE Span span_of(const SeenSolid& solid, const Rays& rays) {
  Span span;
  if (solid.kind == SolidKind::sphere) {
    cut_by_round<3>(span, rays, solid);
    return span;
  }
  cut_by_slab(span, rays.d[2], solid.eye[2], solid.half[2]);
  if (solid.kind == SolidKind::cylinder) {
    cut_by_round<2>(span, rays, solid);
    return span;
  }
  cut_by_slab(span, rays.d[0], solid.eye[0], solid.half[0]);
  cut_by_slab(span, rays.d[1], solid.eye[1], solid.half[1]);
  for (int k = 0; k < solid.n_planes; ++k) cut_by_plane(span, rays, solid.planes[k]);
  return span;
}

}  // namespace

void cast(const SeenSolid& solid, const DepthData& picture) {
  for (int row = solid.first_row; row < solid.last_row; ++row) {
    float base[3];
    for (int i = 0; i < 3; ++i) base[i] = solid.forward[i] + picture.y[row] * solid.down[i];
    for (int column = solid.first_column; column < solid.last_column; column += kLanes) {
      float* depth = picture.depth + static_cast<std::ptrdiff_t>(row) * picture.stride + column;
      const V before = load(depth);
      if (!bits(above(before, all(solid.nearest)))) continue;
      const V x = load(picture.x + column);
      Rays rays;
      for (int i = 0; i < 3; ++i) rays.d[i] = base[i] + x * solid.right[i];
      const Span span = span_of(solid, rays);
      const Mask hit =
          not_above(span.near, span.far) & above(span.near, all(kNearest)) & above(before, span.near);
      if (!bits(hit)) continue;
      const V after = select(hit, span.near, before);
      __builtin_memcpy(depth, &after, sizeof after);
      std::int32_t* index = picture.index + (depth - picture.depth);
      Mask seen;
      __builtin_memcpy(&seen, index, sizeof seen);
      seen = (seen & ~hit) | (solid.index & hit);
      __builtin_memcpy(index, &seen, sizeof seen);
    }
  }
}

}  // namespace apc::simd8::APC_ARCHITECTURE
