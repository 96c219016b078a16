//! \file
//! The comparison of simd8_hypothesis.hpp, for one instruction set. The includer defines APC_ARCHITECTURE.
//!
//! A ray that is parallel to a face divides by zero: the infinities of IEEE 754 are then the right answer.
#include "simd/simd8_hypothesis.hpp"
#include "simd/vector8.hpp"

#include <cstddef>
#include <limits>

namespace apc::simd8::APC_ARCHITECTURE {
namespace {

//! Eight rays of one row in the solid's frame, of depth 1, and where they enter it: infinite if they do not.
struct Entering {
  V d[3];
  V depth;
};

APC_INLINE V entry_of_box(const Hypothesis& item, const V (&d)[3]) {
  V near = all(kNearestOfPlace), far = all(std::numeric_limits<float>::infinity());
  for (int i = 0; i < 3; ++i) {
    const V inverse = 1.0f / d[i];
    const V a = (-item.half[i] - item.eye[i]) * inverse, b = (item.half[i] - item.eye[i]) * inverse;
    near = larger(smaller(a, b), near);
    far = smaller(larger(b, a), far);
  }
  return select(not_above(near, far), near, all(std::numeric_limits<float>::infinity()));
}

//! Of a ball, or with two axes of a round cylinder: half a chord before the point nearest to the centre.
template <int kAxes>
APC_INLINE V entry_of_round(const Hypothesis& item, const V (&d)[3]) {
  const V infinite = all(std::numeric_limits<float>::infinity());
  V along{}, length2{};
  for (int i = 0; i < kAxes; ++i) {
    along += item.eye[i] * d[i];
    length2 += d[i] * d[i];
  }
  const Mask is_aslant = above(length2, all(1e-30f));  // to the cylinder's axis
  const V middle = select(is_aslant, -along / length2, V{});
  V distance2{};
  for (int i = 0; i < kAxes; ++i) {
    const V p = item.eye[i] + middle * d[i];
    distance2 += p * p;
  }
  const V inside = item.half[0] * item.half[0] - distance2;
  const V half_chord = square_root(larger(inside, V{}) / length2);
  V near = all(kNearestOfPlace), far = infinite;
  near = select(is_aslant, larger(middle - half_chord, near), near);
  far = select(is_aslant, smaller(middle + half_chord, far), far);
  if (kAxes == 2) {
    const V inverse = 1.0f / d[2];
    const V a = (-item.half[2] - item.eye[2]) * inverse, b = (item.half[2] - item.eye[2]) * inverse;
    near = larger(smaller(b, a), near);
    far = smaller(larger(a, b), far);
  }
  return select(not_above(V{}, inside) & not_above(near, far), near, infinite);
}

APC_INLINE Entering entering(const Hypothesis& item, const float (&base)[3], V x) {
  Entering out;
  for (int i = 0; i < 3; ++i) out.d[i] = base[i] + x * item.right[i];
  out.depth = item.kind == SolidKind::box        ? entry_of_box(item, out.d)
              : item.kind == SolidKind::cylinder ? entry_of_round<2>(item, out.d)
                                                 : entry_of_round<3>(item, out.d);
  return out;
}

//! Cosine between rays and normals where they enter.
APC_INLINE V facing_of(const Hypothesis& item, const Entering& rays, V length) {
  V p[3];
  for (int i = 0; i < 3; ++i) p[i] = item.eye[i] + rays.depth * rays.d[i];
  if (item.kind == SolidKind::sphere)
    return -(p[0] * rays.d[0] + p[1] * rays.d[1] + p[2] * rays.d[2]) / (item.half[0] * length);
  if (item.kind == SolidKind::cylinder) {
    const V across = square_root(p[0] * p[0] + p[1] * p[1]);
    const Mask is_side = above(across - item.half[0], magnitude(p[2]) - item.half[2]);
    const V side = -(p[0] * rays.d[0] + p[1] * rays.d[1]) / (item.half[0] * length);
    return select(is_side, side, magnitude(rays.d[2]) / length);
  }
  V most = magnitude(p[0]) - item.half[0], across = rays.d[0];
  for (int i = 1; i < 3; ++i) {
    const V out = magnitude(p[i]) - item.half[i];
    const Mask is_there = above(out, most);
    most = select(is_there, out, most);
    across = select(is_there, rays.d[i], across);
  }
  return magnitude(across) / length;
}

//! What eight pixels cost that show the item.
APC_INLINE V costs_of(const Hypothesis& item, const PlaceData& place, std::size_t pixel, V depth, V facing) {
  const V step = smaller(larger(facing * static_cast<float>(kFacings), V{}), all(kFacings - 1.0f));
  const Mask k = __builtin_convertvector(step, Mask);
  const V some = gathered(item.some, k);
  V none = gathered(item.none, k);
  const Mask is_unseen = above(depth, load(place.hidden + pixel)) | above(all(place.nearest), depth) |
                         above(depth, all(place.farthest));
  none = select(is_unseen, smaller(none, all(place.unseen)), none);
  const V share = load(place.share + pixel), colour = load(item.colour + pixel);
  const V off = load(place.depth + pixel) - depth;
  const V half_square = 0.5f * off * off * load(place.inverse_variance + pixel);
  const V front = all(place.front);
  const Mask is_before = above(V{}, off);
  const V told = select(is_before, half_square, smaller(half_square, all(place.behind)));
  const V own = place.weight * (share * (some + told) + (1.0f - share) * none + colour);
  // Something else is there: neither its colour nor its answer tell of this surface.
  const V other = place.weight * share * front;
  const V measured = select(is_before & not_above(front, half_square), other, own);
  return select(above(share, V{}), measured, place.weight * (none + colour));
}

APC_INLINE Mask first_lanes(int n) { return n >= kLanes ? ~Mask{} : lanes((1 << n) - 1); }

APC_INLINE void set_base(const Hypothesis& item, float y, float (&base)[3]) {
  for (int i = 0; i < 3; ++i) base[i] = item.forward[i] + y * item.down[i];
}

APC_INLINE Mask before(V depth, V others) {
  return above(others, depth) & above(all(std::numeric_limits<float>::infinity()), others);
}

}  // namespace

Gain cost_before(const Hypothesis& item, const PlaceData& place, const OthersData& others,
                 const Window& window) {
  Doubles sum{};
  int shown = 0;
  for (int v = window.first_v; v < window.last_v; ++v) {
    float base[3];
    set_base(item, place.y[v], base);
    for (int u = window.first_u; u < window.last_u; u += kLanes) {
      const std::size_t pixel = static_cast<std::size_t>(v) * static_cast<std::size_t>(place.width) +
                                static_cast<std::size_t>(u);
      const Entering rays = entering(item, base, load(place.x + u));
      const Mask hit =
          before(rays.depth, load(others.depth + pixel)) & first_lanes(window.last_u - u);
      const int set = bits(hit);
      if (!set) continue;
      const V facing = facing_of(item, rays, load(place.length + pixel));
      const V more = costs_of(item, place, pixel, rays.depth, facing) - load(others.cost + pixel);
      sum += __builtin_convertvector(select(hit, more, V{}), Doubles);
      shown += __builtin_popcount(static_cast<unsigned>(set));
    }
  }
  return {((sum[0] + sum[4]) + (sum[2] + sum[6])) + ((sum[1] + sum[5]) + (sum[3] + sum[7])), shown};
}

int show_row(const Hypothesis& item, const PlaceData& place, const float* others_depth, int row, int first,
             int last, std::int32_t* pixels, float* depths, float* costs) {
  int n = 0;
  float base[3];
  set_base(item, place.y[row], base);
  for (int u = first; u < last; u += kLanes) {
    const std::size_t pixel = static_cast<std::size_t>(row) * static_cast<std::size_t>(place.width) +
                              static_cast<std::size_t>(u);
    const Entering rays = entering(item, base, load(place.x + u));
    const Mask hit = before(rays.depth, load(others_depth + pixel)) & first_lanes(last - u);
    const int set = bits(hit);
    if (!set) continue;
    const V facing = facing_of(item, rays, load(place.length + pixel));
    const V cost = costs_of(item, place, pixel, rays.depth, facing);
    for (int lane = 0; lane < kLanes; ++lane) {
      if (!(set >> lane & 1)) continue;
      pixels[n] = static_cast<std::int32_t>(pixel) + lane;
      depths[n] = rays.depth[lane];
      costs[n++] = cost[lane];
    }
  }
  return n;
}

}  // namespace apc::simd8::APC_ARCHITECTURE
