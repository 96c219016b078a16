//! \file
//! A pinhole camera in OpenCV's convention.
#pragma once

#include "geometry/linear.hpp"

namespace apc {

//! x to the right, y down, z along the optical axis. The middle of pixel (u, v) is at u, v exactly.
struct PinholeCamera {
  double fx = 1.0, fy = 1.0, cx = 0.0, cy = 0.0;  //!< px
  int width = 0, height = 0;

  //! Of the ray through a place in the picture, at depth 1.
  double x(double u) const { return (u - cx) / fx; }
  double y(double v) const { return (v - cy) / fy; }
};

}  // namespace apc
