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

// A moving joint in a frame whose z is its axis: motion is a rotation about z or a shift along it.
// Body k is what moves with joint k-1; body 0 is the world.
struct Joint {
  float T_body_joint[12];  // rows of (R | p): joint frame in the body before it, at position 0
  bool is_prismatic;
  int q_index;
};

struct Sphere {
  float x, y, z, radius;  // in the body
};

struct Frame {
  int body;
  int first_sphere, n_spheres;
  Sphere ball;   // contains all spheres of the frame
  float spread;  // largest distance of a sphere centre from the ball's centre
  int first_tested, n_tested;
};

struct Robot {
  const Joint* joints;
  int n_joints;
  const Frame* frames;
  int n_frames;
  const Sphere* spheres;
  int n_spheres;
  const int* tested;  // inner frames of self pairs, by outer frame
};

struct Box {
  float R[9];  // T_world_box
  float center[3];
  float half[3];
  std::uint64_t ignored;  // bit f: frame f is not tested
  int index;              // the user's
};

struct Group {
  Box around;  // contains all its boxes; ignored: by all of them
  int first_box, n_boxes;
};

struct World {
  const Group* groups;
  int n_groups;
  const Box* boxes;
};

// Eight intervals: lane i stands for every configuration within half_width[i] * speed + slack of its q.
struct Batch {
  alignas(64) double q[32][kLanes];  // midpoints, by entry of the configuration
  float half_width[kLanes];
  float speed[32];           // by moving joint, rad or m per unit of half_width
  float slack[32];           // by moving joint, rad or m
  bool is_edge;              // false: eight configurations, no motion; the test ends when all lanes are hit
  float world_margin, self_margin;  // m, rounding included
  float lever_error;         // m, rounding of a sphere centre's distance from an axis
  float resolution;          // m: an interval that moves a frame less than this is not split further
};

struct Verdict {
  int unproven;  // bit per lane: not proven all over the interval (of an edge: but clear at the midpoint)
  int hit_lane;  // of an edge: a lane that is not free and not worth splitting, or -1
  int frame, kind, index;
};

inline std::size_t scratch_bytes(const Robot& robot) {
  return 32 * (12 * static_cast<std::size_t>(robot.n_joints + 1) + 3 * static_cast<std::size_t>(robot.n_frames) +
               3 * static_cast<std::size_t>(robot.n_spheres)) + static_cast<std::size_t>(robot.n_frames);
}

using Test = void (*)(const Robot&, const World&, const Batch&, void* scratch, Verdict&);

namespace baseline {
void test(const Robot&, const World&, const Batch&, void* scratch, Verdict&);
}
namespace avx2 {
void test(const Robot&, const World&, const Batch&, void* scratch, Verdict&);
}

}  // namespace apc::eight
