//! \file
//! The robot as the checks see it: rigid bodies between moving joints, and spheres fixed in frames.
#pragma once

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "geometry/ball_tree.hpp"
#include "geometry/solid.hpp"
#include "kinematics/chain.hpp"
#include "simd/simd8_collision.hpp"

namespace apc {

//! All spheres of one frame, or the one solid that is held.
struct FrameCover {
  std::vector<Sphere> spheres;  //!< in the frame
  std::optional<Solid> solid;   //!< instead of spheres
  std::vector<BallNode> tree;   //!< over them; the root alone around a solid; of nothing: empty
  std::vector<BallNode> fine;   //!< over spheres that other frames are tested against instead; empty: the same
  std::vector<int> tested;      //!< frames before this one that its spheres must stay clear of

  //! What other frames are tested against.
  const std::vector<BallNode>& self_tree() const { return fine.empty() ? tree : fine; }
};

//! A chain with spheres in its frames and, as frame L, the held item: rigid on frame L-1.
class Robot {
 public:
  Robot(Chain chain, const std::vector<Sphere>& spheres, const std::vector<int>& frame,
        const std::vector<std::pair<int, int>>& self_pairs);

  //! A robot whose self pairs are tested with tighter spheres in the frames that have any.
  Robot(Chain chain, const std::vector<Sphere>& spheres, const std::vector<int>& frame,
        const std::vector<std::pair<int, int>>& self_pairs, const std::vector<Sphere>& fine_spheres,
        const std::vector<int>& fine_frame);
  Robot(Robot&&) = default;
  Robot& operator=(Robot&&) = default;

  //! A copy that holds nothing: cheaper than cutting the spheres into trees again.
  Robot bare() const;

  //! Replaces the held item; no spheres: nothing is held.
  void set_held(std::vector<Sphere> spheres, std::vector<int> tested_frames);

  //! Replaces the held item by one solid in frame L-1.
  void set_held(const Solid& solid, std::vector<int> tested_frames);

  const Chain& chain() const { return chain_; }
  const std::vector<FrameCover>& covers() const { return covers_; }  //!< L + 1, the last is the held item

  //! Poses of all frames and of the held item (L + 1).
  void place(const double* q, Pose* frames) const;

  //! The chain and the covers in single precision, for the batch test. Valid until the next set_held.
  const simd8::RobotData& single_precision() const { return single_; }

  //! Bound in m on how far any computed sphere centre is off in single precision, with all prismatic
  //! joints within +-|travel| of zero, summed over them.
  double rounding(double travel) const { return rounding_ + rounding_per_travel_ * travel; }

  //! Bound in m on how far a distance between two frames is off.
  double self_rounding(double travel) const;

  //! Bound in m on the distance of any sphere centre from the world's origin.
  double reach(double travel) const { return reach_ + travel; }

 private:
  Robot(const Robot&) = default;  // single_ points into the other until it is prepared anew
  void replace_held(FrameCover held);
  void prepare_bodies();
  void prepare_cover(std::size_t f);
  void add_balls(std::size_t f, const std::vector<BallNode>& tree);
  void prepare_single();
  simd8::FrameData bounded(std::size_t f) const;
  void bound_rounding();

  Chain chain_;
  std::vector<FrameCover> covers_;
  std::vector<int> body_of_frame_;        //!< L + 1: number of moving joints up to the frame
  std::vector<Pose> T_body_frame_;        //!< L + 1: constant
  std::vector<simd8::JointData> joints_;  //!< moving ones only
  Mat3 R_world_base_;                     //!< of body 0
  std::vector<simd8::FrameData> frames_;  //!< L + 1
  std::vector<simd8::Ball> balls_;
  std::vector<int> tested_;
  std::vector<simd8::SolidData> held_;  //!< one or none
  simd8::RobotData single_{};
  double rounding_ = 0.0, rounding_per_travel_ = 0.0, reach_ = 0.0;
};

}  // namespace apc
