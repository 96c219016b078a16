//! \file
//! The batch test: eight configurations side by side against the world and the robot itself.
//!
//! Everything here is plain data in single precision, prepared elsewhere in double. The test itself is
//! compiled twice (baseline x86-64 and AVX2) from simd8_collision_impl.hpp; both give the same bits.
//! Lengths are in m, angles in rad.
#pragma once

#include <cstddef>
#include <cstdint>

namespace apc::simd8 {

inline constexpr int kLanes = 8;                       //!< configurations in one batch
inline constexpr float kUnitRoundoff = 5.9604645e-8f;  //!< 2^-24

//! A moving joint. Body k is what moves with joint k-1; body 0 stands still. The axis of a body's joint is
//! its z, and its x is turned such that a turn about x takes it to the axis of the next joint: the next body
//! is moved by offset, turned by tilt about x, moved by a prismatic joint and turned by a revolute one along
//! or about z, each from its zero.
struct JointData {
  float offset[3];               //!< m, in the body before it
  float tilt_cosine, tilt_sine;  //!< of the turn about x
  double zero;                   //!< rad, of the joint's own turn where it stands at 0
  bool is_prismatic;             //!< moves along its z instead of turning about it
  int q_index;                   //!< entry of the configuration that moves it
};

//! A sphere of a frame, or a ball around those that follow it up to `next`.
struct Ball {
  float x, y, z, radius;  //!< m, in the body
  int next;               //!< index of the first ball that is not inside this one
  bool is_sphere;         //!< a sphere of the frame itself
};

//! Spheres, or one solid. The box holds the centres of the spheres, or the solid's core.
struct FrameData {
  int body;                   //!< that it is fixed to
  int first_ball, last_ball;  //!< a tree in depth-first order, its root first; empty: first == last
  int first_self, last_self;  //!< the same, of what other frames are tested against
  float center[3], half[3];   //!< m, of the box, aligned to the body
  float radius;               //!< m, of the largest sphere, or the solid's rounding
  float self_radius;          //!< m, of the box, within which all is that other frames are tested against
  float spread;  //!< m, largest distance of a sphere's centre, or of the core, from the box's centre
  int first_tested, n_tested;  //!< its inner frames of self pairs, in RobotData::tested
};

//! What the core of a solid is.
enum class SolidKind : int { box, cylinder, sphere };

//! A core and everything within rounding of it. A cylinder is about its z; a sphere's core is its centre.
struct SolidData {
  float R[9];       //!< to the parent: the world, or for the held item its body
  float center[3];  //!< m, in the parent
  float half[3];    //!< m, half extents of the core
  float rounding;   //!< m
  SolidKind kind;   //!< of the core
  bool is_square;   //!< R is the identity
};

//! Which frames: of the held item and of a chain of 63 joints, one bit each.
using Frames = std::uint64_t;

//! A chain with everything that its frames carry.
struct RobotData {
  float R_world_base[9];    //!< body 0 stands in the world's origin
  const JointData* joints;  //!< moving ones, from the base outwards
  int n_joints;
  const FrameData* frames;  //!< the held item last
  int n_frames;
  Frames covered;     //!< those with anything in them
  const Ball* balls;  //!< of all frames
  int n_balls;
  const int* tested;  //!< inner frames of self pairs, by outer frame
  const SolidData*
      held;  //!< in its body, if the last frame is one solid (its root a ball around it); else null
};

//! A solid of the world.
struct ObstacleData {
  SolidData solid;        //!< in the world
  std::uint64_t ignored;  //!< bit f: frame f is not tested
  int index;              //!< the user's
};

//! World-aligned bounds of eight things; of none: +infinity .. -infinity.
struct alignas(32) Bounds8 {
  float low[3][kLanes], high[3][kLanes];  //!< m, by axis and thing
};

//! Bounds around bounds: row r of a level bounds rows 8r..8r+7 of the level below, of the lowest level things
//! 8r..8r+7.
struct TreeData {
  const Bounds8* levels[12];  //!< rows, the lowest first: for 8^12 things
  int n_levels;               //!< 0: nothing
  int n_on_top;               //!< rows of the highest
};

//! Eight points of a cloud; none: at infinity.
struct alignas(32) Points8 {
  float center[3][kLanes];  //!< m, in the world, by axis and point
  float radius[kLanes];     //!< m around it
};

//! Points, each with a cube along the world's axes around it and all that is within its radius of that.
struct CloudData {
  TreeData tree;  //!< over the rows
  const Points8* rows;
  const int* index;       //!< the user's, by point
  float half_edge;        //!< m, of the cubes
  std::uint64_t ignored;  //!< bit f: frame f is not tested
};

//! Everything that stands.
struct WorldData {
  TreeData tree;  //!< over the obstacles
  const ObstacleData* obstacles;
  CloudData cloud;
};

//! Eight intervals: lane i stands for every configuration within half_width[i] * speed + slack of its
//! midpoint, which is q0 + middle[i] * dq on an edge, and column i of q otherwise.
struct Batch {
  alignas(64) double middle[kLanes];  //!< share of the edge, 0..1
  double q0[32], dq[32];              //!< rad or m, by entry of the configuration
  const double (*q)[kLanes];          //!< rad or m, by entry of the configuration
  Frames world[kLanes],
      self[kLanes];          //!< what is still to be tested: frames against obstacles, against inner frames
  float half_width[kLanes];  //!< share of the edge
  float speed[32];           //!< by moving joint, rad or m per unit of half_width
  float slack[32];           //!< by moving joint, rad or m
  bool is_edge;              //!< false: configurations; a lane that is hit is done
  bool moves;                //!< false: the midpoints alone are tested, without slack
  float world_margin, self_margin;  //!< m, rounding included
  float lever_error;                //!< m, rounding of a sphere centre's distance from an axis
  float resolution;                 //!< m: an interval that moves a frame less than this is not split further
};

//! What a batch proved, and what it did not.
struct BatchResult {
  Frames world[kLanes],
      self[kLanes];  //!< not proven all over the interval; of an edge: but clear at the midpoint
  int hit_lane;      //!< of an edge: a lane that is not free and not worth splitting, or -1; ends the test
  int frame, kind, index;  //!< of the hit: as in EdgeReport
};

//! Memory that a test needs, aligned to 32 bytes.
inline std::size_t scratch_bytes(const RobotData& robot) {
  const std::size_t n_bodies = static_cast<std::size_t>(robot.n_joints) + 1;
  const std::size_t n_frames = static_cast<std::size_t>(robot.n_frames);
  return 4 * kLanes * (12 * n_bodies + 9 * n_frames) + n_frames;
}

//! Tests one batch.
using Test = void (*)(const RobotData&, const WorldData&, const Batch&, void* scratch, BatchResult&);

namespace baseline {
void test(const RobotData&, const WorldData&, const Batch&, void* scratch, BatchResult&);
}
namespace avx2 {
void test(const RobotData&, const WorldData&, const Batch&, void* scratch, BatchResult&);
}

}  // namespace apc::simd8
