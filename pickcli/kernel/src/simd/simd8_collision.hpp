// The hot test: eight configurations side by side against the world and the robot itself.
//
// Everything here is plain data in single precision, prepared elsewhere in double. The test itself is
// compiled twice (baseline x86-64 and AVX2) from eight_impl.hpp; both give the same bits.
#pragma once

#include <cstddef>
#include <cstdint>

namespace apc::eight {

inline constexpr int kLanes = 8;
inline constexpr float kUnitRoundoff = 5.9604645e-8f;  // 2^-24

// A moving joint. Body k is what moves with joint k-1; body 0 stands still. The axis of a body's joint is its z,
// and its x is turned such that a turn about x takes it to the axis of the next joint: the next body is moved by
// offset, turned by tilt about x, moved by a prismatic joint and turned by a revolute one along or about z, each
// from its zero.
struct Joint {
  float offset[3];               // m, in the body before it
  float tilt_cosine, tilt_sine;
  double zero;                   // rad
  bool is_prismatic;
  int q_index;
};

// A sphere of a frame, or a ball around those that follow it up to `next`.
struct Ball {
  float x, y, z, radius;  // in the body
  int next;
  bool is_sphere;
};

// Spheres, or one solid. The box holds the centres of the spheres, or the solid's core.
struct Frame {
  int body;
  int first_ball, last_ball;  // a tree in depth-first order, its root first; empty: first == last
  float center[3], half[3];   // of the box, aligned to the body
  float radius;               // of the largest sphere, or the solid's rounding
  float spread;               // largest distance from the box's centre of a sphere's centre, or of the core
  int first_tested, n_tested;
};

enum class SolidKind : int { box, cylinder, sphere };

// A core and everything within rounding of it. A cylinder is about its z; a sphere's core is its centre.
struct Solid {
  float R[9];  // to the parent: the world, or for the held item its body
  float center[3];
  float half[3];  // half extents of the core
  float rounding;
  SolidKind kind;
  bool is_square;  // R is the identity
};

// Which frames: of the held item and of a chain of 63 joints, one bit each.
using Frames = std::uint64_t;

struct Robot {
  float R_world_base[9];  // body 0 stands in the world's origin
  const Joint* joints;
  int n_joints;
  const Frame* frames;
  int n_frames;
  Frames covered;  // those with anything in them
  const Ball* balls;
  int n_balls;
  const int* tested;  // inner frames of self pairs, by outer frame
  const Solid* held;  // in its body, if the last frame is one solid (its root a ball around it); else null
};

struct Obstacle {
  Solid solid;
  std::uint64_t ignored;  // bit f: frame f is not tested
  int index;              // the user's
};

// World-aligned bounds of eight obstacles; of none: +infinity .. -infinity.
struct alignas(32) EightBounds {
  float low[3][kLanes], high[3][kLanes];
};

// Obstacles that stand close together.
struct Group {
  std::uint64_t ignored;  // by every obstacle
  const Obstacle* obstacles;
  const EightBounds* bounds;  // of obstacles 0..7, 8..15, ...
  int n_obstacles;
};

struct World {
  const Group* groups;
  const EightBounds* bounds;  // around groups 0..7, 8..15, ...
  int n_groups;
};

// Eight intervals: lane i stands for every configuration within half_width[i] * speed + slack of its midpoint,
// which is q0 + middle[i] * dq on an edge, and column i of q otherwise.
struct Batch {
  alignas(64) double middle[kLanes];
  double q0[32], dq[32];       // by entry of the configuration
  const double (*q)[kLanes];  // by entry of the configuration
  Frames world[kLanes], self[kLanes];  // what is still to be tested: frames against obstacles, against inner frames
  float half_width[kLanes];
  float speed[32];           // by moving joint, rad or m per unit of half_width
  float slack[32];           // by moving joint, rad or m
  bool is_edge;              // false: configurations, no motion; a lane that is hit is done
  float world_margin, self_margin;  // m, rounding included
  float lever_error;         // m, rounding of a sphere centre's distance from an axis
  float resolution;          // m: an interval that moves a frame less than this is not split further
};

struct Verdict {
  Frames world[kLanes], self[kLanes];  // not proven all over the interval; of an edge: but clear at the midpoint
  int hit_lane;  // of an edge: a lane that is not free and not worth splitting, or -1; ends the test
  int frame, kind, index;
};

inline std::size_t scratch_bytes(const Robot& robot) {
  const std::size_t n_bodies = static_cast<std::size_t>(robot.n_joints) + 1;
  const std::size_t n_frames = static_cast<std::size_t>(robot.n_frames);
  return 4 * kLanes * (12 * n_bodies + 9 * n_frames) + n_frames;
}

using Test = void (*)(const Robot&, const World&, const Batch&, void* scratch, Verdict&);

namespace baseline {
void test(const Robot&, const World&, const Batch&, void* scratch, Verdict&);
}
namespace avx2 {
void test(const Robot&, const World&, const Batch&, void* scratch, Verdict&);
}

}  // namespace apc::eight
