//! \file
//! Depth pictures as sensors give them: noise, and where nothing comes back.
#pragma once

#include <cstdint>
#include <vector>

#include "rendering/raycasting_scene.hpp"

namespace apc {

//! Coefficients of a sensor. The error of a depth z has the standard deviation
//!   constant + quadratic (z - from)^2 + disparity_error z^2 / (f baseline)
//! and, where a surface is met at an angle t beyond oblique_from, oblique / sqrt(z) t^2 / (pi/2 - t)^2 more:
//! the first and the last are those of Nguyen, Izadi and Lovell 2012 for structured light, the third that of
//! stereo.
struct DepthNoise {
  double constant = 0.0, quadratic = 0.0, from = 0.0;  //!< m, 1/m, m
  double oblique = 0.0, oblique_from = 0.0;            //!< m^1.5, rad
  double disparity_error = 0.0,
         disparity_step = 0.0;  //!< px; disparities are whole steps, if there is a step
  double baseline = 0.0;        //!< m, to the second eye, on the camera's x; 0 without one
  double correlation = 0.0;     //!< px, of neighbouring errors: the width of a Gaussian filter; 0 or 0.5 to 2
  double lateral = 0.0,
         lateral_oblique = 0.0;  //!< px by which edges are off: lateral + lateral_oblique t / (pi/2 - t)
  bool mixes_edges = false;      //!< time of flight: at an edge, depths between those of both surfaces
  double least = 0.0, greatest = 0.0;  //!< m, range
  double incidence_from = 0.0,
         incidence_to = 0.0;  //!< rad: all comes back up to the first, nothing from the second on
};

//! No return within whole blots of this many pixels, where a material answers only in part.
inline constexpr int kBlot = 4;

//! Throws std::invalid_argument for coefficients that no sensor can have.
void check(const DepthNoise& noise);

//! Depth in m, NaN where nothing comes back. no_return: by solid, in which share of blots it does not answer.
//! Equal seeds give equal bytes.
std::vector<float> measured_depth(const RaycastingScene& scene, const PinholeCamera& camera,
                                  const Pose& T_world_camera, const DepthNoise& noise,
                                  const std::vector<float>& no_return, std::uint64_t seed);

}  // namespace apc
