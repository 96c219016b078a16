//! \file
//! An item at a pose against what a camera measured of a place, eight pixels of a row side by side.
//!
//! Plain data in single precision, prepared elsewhere in double. Compiled twice (baseline x86-64 and AVX2)
//! from simd8_hypothesis_impl.hpp; both give the same bits. Lengths are in m.
#pragma once

#include <cstdint>

#include "simd/simd8_collision.hpp"

namespace apc::simd8 {

inline constexpr int kFacings = 64;              //!< steps of the cosine between ray and normal
inline constexpr float kNearestOfPlace = 0.02f;  //!< no item is that near to the camera

//! A solid as a camera sees it. The point of a ray at depth t is eye + t (x right + y down + forward).
struct Hypothesis {
  SolidKind kind;
  float half[3], eye[3];
  float right[3], down[3], forward[3];  //!< the camera's axes in the solid's frame
  const float *some, *none;             //!< (kFacings,) costs of an answer and of none, by how it is met
  const float* colour;                  //!< by pixel, of its colour on this item
};

//! A picture. Arrays by pixel, and x, may be read up to kLanes - 1 entries beyond their end.
struct PlaceData {
  const float *x, *y;              //!< of the rays at depth 1, by column and by row
  const float* length;             //!< by pixel, of its ray up to depth 1
  const float* depth;              //!< measured, by pixel
  const float* share;              //!< of the pixel that was measured
  const float* inverse_variance;   //!< of its depth
  const float* hidden;             //!< beyond, the second eye of a stereo camera sees nothing
  int width;                       //!< of a row, px
  float nearest, farthest;         //!< depths between which surfaces are surely within the sensor's range
  float front, behind, unseen;     //!< most that depths before and behind, and none where none is due, cost
  float weight;                    //!< of a pixel
};

//! What is in the picture without the item. Depths are infinite where nothing is looked for.
struct OthersData {
  const float *depth, *cost;  //!< by pixel
};

struct Window {
  int first_u, last_u, first_v, last_v;  //!< last ones excluded
};

struct Gain {
  double cost;  //!< of the item, less that of what it hides
  int shown;    //!< px
};

//! What an item costs beside what it hides.
using CostBefore = Gain (*)(const Hypothesis& item, const PlaceData& place, const OthersData& others,
                            const Window& window);

//! Pixels of part of a row in which an item is before others: how many, with depths and costs.
//! Each output holds last - first + kLanes entries.
using ShowRow = int (*)(const Hypothesis& item, const PlaceData& place, const float* others_depth, int row,
                        int first, int last, std::int32_t* pixel, float* depth, float* cost);

namespace baseline {
Gain cost_before(const Hypothesis& item, const PlaceData& place, const OthersData& others,
                 const Window& window);
int show_row(const Hypothesis& item, const PlaceData& place, const float* others_depth, int row, int first,
             int last, std::int32_t* pixel, float* depth, float* cost);
}  // namespace baseline
namespace avx2 {
Gain cost_before(const Hypothesis& item, const PlaceData& place, const OthersData& others,
                 const Window& window);
int show_row(const Hypothesis& item, const PlaceData& place, const float* others_depth, int row, int first,
             int last, std::int32_t* pixel, float* depth, float* cost);
}  // namespace avx2

}  // namespace apc::simd8
