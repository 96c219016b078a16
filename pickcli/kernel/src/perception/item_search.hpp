//! \file
//! Where items of a place may be: fits from many starts, and local searches on how well they explain the
//! picture; then all items of the place together.
#pragma once

#include <cstdint>
#include <vector>

#include "perception/place_picture.hpp"
#include "perception/surface_fit.hpp"

namespace apc {

struct PlacedProduct {
  int product = 0;
  Pose T;  //!< in the camera's frame
};

struct SearchSettings {
  double allowed_penetration = 0.004;  //!< m into known solids, or into another item
  double penetration_cost = 100.0;     //!< per mm beyond that
  std::vector<double> steps;           //!< m, of the local search, falling; turns by step / reach, at least
  double turn_per_step = 0.5;          //!< rad that a step of 0.1 m turns by
  Freedom freedom = Freedom::upright;
  Vec3 up{0.0, 0.0, 1.0};
  bool tries_turns = false;  //!< of refined boxes: also with exchanged axes
  int most_rounds = 4;       //!< at each step size
};

//! An option of an item, with its cost beside what is only known; negative: it explains the picture better.
struct Option {
  Pose T;
  double cost = 0.0;
};

//! Cost of one item in front of a composite of all others, without penalties.
double cost_before(const Sight& sight, const Composite& others);

Composite known_only(const PlacePicture& picture);
void add(Composite& composite, const Sight& sight, std::int32_t owner);
Composite composed(const PlacePicture& picture, const std::vector<PlacedProduct>& placed, int except);

//! One item moved step by step while that explains the picture better, with others in their places.
Option searched(const PlacePicture& picture, const PlacedProduct& start, const Composite& others,
                const std::vector<PlacedProduct>& neighbours, const SearchSettings& settings);

struct CandidateSettings {
  double near_surface = 0.025;               //!< m: points that far from a start's surface are fitted
  std::vector<double> scales{0.012, 0.006};  //!< of the fits, one after another
  int point_stride = 2;                      //!< every so manieth pixel of a row and of a column is fitted
  double apart = 0.012;                      //!< m, or
  double apart_angle = 0.2;                  //!< rad, between candidates of one item
  double place = 0.04;                       //!< m around a candidate in which
  int most_there = 3;   //!< so many are kept: what is large elsewhere must not crowd out all others
  int least_shown = 8;  //!< px: what is hidden is not looked for
  int n_searched = 24, n_kept = 12;
  double explained = 0.006;  //!< m around placed surfaces in which points are not fitted to
};

//! The best places of one product among others that are placed already, best first.
std::vector<Option> candidates(const PlacePicture& picture, int product, const std::vector<Pose>& starts,
                               const std::vector<PlacedProduct>& placed, const CandidateSettings& settings,
                               const SearchSettings& search);

//! What was chosen for an item.
struct Choice {
  int option = -1;      //!< -1: none explains the picture better than nothing
  double gain = 0.0;    //!< by which the picture is explained better with it, others in their places
  double margin = 0.0;  //!< by which it explains it better than the item's next place
};

//! The choice for all items that explains the picture best: greedily, then items one by one and in pairs
//! while that gets better. Each gain is at least least_gain.
std::vector<Choice> choose(const PlacePicture& picture, const std::vector<int>& products,
                           const std::vector<std::vector<Pose>>& options, double least_gain,
                           const SearchSettings& settings);

//! All items moved in turn, and fitted with all turns to the points that they explain; n rounds.
std::vector<Pose> refined(const PlacePicture& picture, std::vector<PlacedProduct> placed, int n_rounds,
                          const SearchSettings& settings);

//! What a picture says of placed items.
struct Evidence {
  int expected = 0;     //!< pixels that an item would fill, if nothing but what is known were before it
  int shown = 0;        //!< of these, not behind other items
  int supported = 0;    //!< of these, where its surface was measured
  int through = 0;      //!< of these, where something behind it was measured
  int before = 0;       //!< of these, where something before it was measured
  double gain = 0.0;    //!< by which the picture is explained better with it than without
  double colour = 0.0;  //!< mean cost of the colours of supported pixels
};

std::vector<Evidence> evidence(const PlacePicture& picture, const std::vector<PlacedProduct>& placed,
                               double near_surface, const SearchSettings& settings);

}  // namespace apc
