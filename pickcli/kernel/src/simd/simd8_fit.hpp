//! \file
//! Sums over points of a fit of a solid to them, eight points side by side.
//!
//! Plain data in single precision, prepared elsewhere in double. Compiled twice (baseline x86-64 and AVX2)
//! from simd8_fit_impl.hpp; both give the same bits. Lengths are in m.
#pragma once

#include "simd/simd8_collision.hpp"

namespace apc::simd8 {

//! Points measured, near the origin of their frame: a float holds 10 nm there. Arrays are read up to
//! kLanes - 1 entries beyond their end.
struct FitPoints {
  const float *x, *y, *z;
  int n;
};

//! A solid; a point is at R p + t in its frame.
struct FitSolid {
  SolidKind kind;
  float half[3];
  float R[3][3], t[3];
  float scale2;  //!< m^2, of the cost of Geman and McClure, d^2 / (scale2 + d^2)
  float reach;   //!< m at which a turn counts as a move
};

//! Sums over all points. Derivatives by moves along the solid's axes and turns about them, in m at its reach.
struct FitSums {
  double cost;
  double gradient[6];
  double H[6][6];  //!< lower triangle
};

using SumFit = void (*)(const FitSolid& solid, const FitPoints& points, FitSums& out);
using SumFitCost = double (*)(const FitSolid& solid, const FitPoints& points);

namespace baseline {
void sum_fit(const FitSolid& solid, const FitPoints& points, FitSums& out);
double sum_fit_cost(const FitSolid& solid, const FitPoints& points);
}  // namespace baseline
namespace avx2 {
void sum_fit(const FitSolid& solid, const FitPoints& points, FitSums& out);
double sum_fit_cost(const FitSolid& solid, const FitPoints& points);
}  // namespace avx2

}  // namespace apc::simd8
