//! \file
//! Rays of a camera against one solid, eight pixels of a row side by side.
//!
//! Plain data in single precision, prepared elsewhere in double. Compiled twice (baseline x86-64 and AVX2)
//! from simd8_rays_impl.hpp; both give the same bits. Lengths are in m.
#pragma once

#include <cstdint>

#include "simd/simd8_collision.hpp"

namespace apc::simd8 {

//! A half-space: all points p with normal . p <= offset, in the frame of its solid.
struct PlaneData {
  float normal[3], offset;
  float clearance;  //!< offset - normal . eye
};

//! A solid as a camera sees it. The point of a ray at depth t is eye + t (x right + y down + forward).
struct SeenSolid {
  float eye[3];                         //!< the camera's centre in the solid's frame
  float right[3], down[3], forward[3];  //!< the camera's axes in the solid's frame
  float half[3];                        //!< half extents
  SolidKind kind;
  const PlaneData* planes;  //!< by which it is cut to a convex piece
  int n_planes;
  std::int32_t index;
  float nearest;                  //!< a lower bound of its depth, at least kNearest
  int first_row, last_row;        //!< of the pixels that may see it; last ones excluded
  int first_column, last_column;  //!< multiples of kLanes
};

//! What is nearer to the camera's plane is not seen.
inline constexpr float kNearest = 1e-6f;

//! A picture under way. Rows have `stride` entries, a multiple of kLanes.
struct DepthData {
  const float *x, *y;   //!< of the rays at depth 1, by column and by row
  float* depth;         //!< infinite where nothing was seen
  std::int32_t* index;  //!< of the solid that was seen
  int stride;
};

//! Put the solid into the picture where it is nearer than what is there.
using Cast = void (*)(const SeenSolid& solid, const DepthData& picture);

namespace baseline {
void cast(const SeenSolid& solid, const DepthData& picture);
}
namespace avx2 {
void cast(const SeenSolid& solid, const DepthData& picture);
}

}  // namespace apc::simd8
