//! \file
//! A picture of one place, and how well solids in it explain the picture: render and compare.
#pragma once

#include <cstdint>
#include <vector>

#include "geometry/solid.hpp"
#include "rendering/depth_noise.hpp"
#include "rendering/pinhole_camera.hpp"
#include "simd/simd8_hypothesis.hpp"

namespace apc {

//! What a pixel costs. Costs are negative logarithms of likelihoods, up to a constant.
struct PixelCosts {
  double slack = 0.002;  //!< m, added to the noise as independent: errors of models and of the known place
  double front = 4.0;    //!< most that a depth costs that is nearer than what is expected: something hides it
  double behind = 8.0;   //!< most that a depth costs that is farther: it was seen through
  double lost = 0.1;     //!< share of pixels without a depth whatever the surface
  double unseen = 0.7;   //!< most that no depth costs out of range, or where the second eye sees other things
  double weight = 1.0;   //!< of a pixel: neighbours that were left out
};

//! Measured by a camera, of which each pixel may stand for a block of the sensor's pixels.
struct MeasuredPicture {
  PinholeCamera camera;
  std::vector<float> depth;          //!< m, of what came back; anything where nothing did
  std::vector<float> share;          //!< of the block that came back, 0 to 1
  std::vector<std::int32_t> colour;  //!< label of the colour
};

//! What is known to be there: nothing is looked for where there is none of it (NaN).
struct KnownSurface {
  std::vector<float> depth, facing;  //!< m; cosine between ray and normal
  std::vector<Solid> solids;         //!< that items do not reach into, in the camera's frame
};

//! An item as pictures show it.
struct Product {
  SolidKind kind = SolidKind::box;
  Vec3 half;
  double no_return = 0.0;           //!< share from which nothing comes back, by its material
  std::vector<float> colour_costs;  //!< by label
};

//! What a solid shows in the picture, where nothing that is known hides it.
struct Sight {
  std::vector<std::int32_t> pixel;
  std::vector<float> depth, cost;
};

//! Depth and cost of every pixel with some items in the place, and some entries more (simd8_hypothesis.hpp).
struct Composite {
  std::vector<float> depth, cost;
  std::vector<std::int32_t> owner;  //!< which of the items, -1: what is known
};

class PlacePicture {
 public:
  PlacePicture(MeasuredPicture measured, KnownSurface known, const std::vector<float>& known_colour_costs,
               const DepthNoise& noise, const PixelCosts& costs);

  int add(Product product);
  const Product& product(int index) const { return products_[static_cast<std::size_t>(index)].product; }
  int n_products() const { return static_cast<int>(products_.size()); }
  std::size_t n_pixels() const { return measured_.colour.size(); }
  int n_labels() const { return n_labels_; }

  //! Depth and cost of every pixel if only what is known were there; infinite depth where nothing is known.
  const std::vector<float>& known_depth() const { return known_.depth; }
  const std::vector<float>& known_costs() const { return known_costs_; }

  Sight sight(int product, const Pose& T_camera_item) const;

  //! Its cost less that of what it hides; and in how many pixels it does, if that is asked for.
  double cost_before(int product, const Pose& T_camera_item, const Composite& others,
                     int* shown = nullptr) const;

  //! m that it reaches into the known solids.
  double penetration(int product, const Pose& T_camera_item) const;

  Solid solid(int product, const Pose& T_camera_item) const;

  //! In the camera's frame.
  Vec3 point(std::size_t pixel) const;
  bool is_measured(std::size_t pixel) const { return measured_.share[pixel] > 0.0f; }
  float share(std::size_t pixel) const { return measured_.share[pixel]; }
  int width() const { return measured_.camera.width; }
  int height() const { return measured_.camera.height; }
  double colour_cost(int index, std::size_t pixel) const {
    return static_cast<double>(
        product(index).colour_costs[static_cast<std::size_t>(measured_.colour[pixel])]);
  }

 private:
  //! Costs of an answer and of none, by the cosine at which a surface is met.
  struct Returns {
    float some[simd8::kFacings], none[simd8::kFacings];
  };
  struct Entry {
    Product product;
    Returns returns;
    std::vector<float> colour;  //!< cost by pixel
  };

  Returns returns(double no_return) const;

  simd8::Hypothesis hypothesis(const Entry& entry, const Pose& T_camera_item) const;
  simd8::PlaceData data() const;

  //! Length of arrays by pixel of which eight entries are read at once.
  std::size_t padded() const { return n_pixels() + simd8::kLanes; }

  float cost(std::size_t pixel, float depth, float facing, const Returns& returns,
             const std::vector<float>& colour_costs) const;

  MeasuredPicture measured_;
  KnownSurface known_;
  DepthNoise noise_;
  PixelCosts costs_;
  int n_labels_;
  float nearest_, farthest_;             //!< m, depths between which surfaces are surely in range
  std::vector<float> inverse_variance_;  //!< by pixel, of what is measured
  std::vector<float> hidden_;            //!< m, by pixel: beyond, the second eye of a stereo camera sees nothing
  std::vector<float> known_costs_;
  std::vector<float> x_, y_;
  std::vector<float> length_;  //!< by pixel, of its ray up to depth 1
  std::vector<Entry> products_;
};

}  // namespace apc
