//! \file
//! Pairs that are near each other, with the gradients of their distances: rows of obstacle avoidance.
#pragma once

#include <vector>

#include "collision/checker.hpp"

namespace apc {

//! A frame of the robot, and a solid or another frame near it.
struct NearPair {
  Contact contact;
  std::vector<double> gradient;  //!< (n) of the distance, m per rad or m
};

//! Every frame with every solid, point of the cloud and tested frame that is nearer than `influence` m at q (n): the
//! few nearest spheres of each pair, of the cloud the nearest point. Throws std::invalid_argument if a solid is held.
std::vector<NearPair> near_pairs(const Checker& checker, const double* q, double influence);

}  // namespace apc
