//! \file
//! Where the robot is in eight configurations: forward kinematics on demand, body by body and ball by ball.
#pragma once

#include "simd/simd8_geometry.hpp"

namespace apc::simd8::APC_ARCHITECTURE {
namespace {

class LinkPoses {
 public:
  //! scratch: of scratch_bytes(robot), aligned to 32.
  LinkPoses(const RobotData& robot, const Batch& batch, void* scratch) : robot_(robot), batch_(batch) {
    places_ = static_cast<Place*>(scratch);
    extents_ = reinterpret_cast<Extent*>(places_ + robot.n_joints + 1);
    has_extent_ = reinterpret_cast<char*>(extents_ + robot.n_frames);
    __builtin_memset(has_extent_, 0, static_cast<std::size_t>(robot.n_frames));
    for (int i = 0; i < 9; ++i) places_[0].R[i] = all(robot.R_world_base[i]);
    places_[0].p = {V{}, V{}, V{}};
  }

  //! Places all bodies up to this one; to be called before anything is asked about it.
  void reach(int body) {
    for (; n_placed_ < body; ++n_placed_) place_body(n_placed_);
  }

  const Place& place(int body) const { return places_[body]; }

  //! Centre of a ball of a body in the world. Not kept: the branch to see whether it is there costs more.
  Point point(int i, int body) const {
    const Ball& ball = robot_.balls[i];
    return map(places_[body], ball.x, ball.y, ball.z);
  }

  //! Centre of a frame's box in the world, and world-aligned bounds of the box. Computed when first asked
  //! for.
  const Point& center(int f) { return extent(f).center; }
  const Bounds& bounds(int f) { return extent(f).bounds; }

  //! Distance of a point from the axis of the joint that moves a body.
  V axis_distance(const Point& point, int body) const {
    const Place& T = places_[body];
    const V x = point.x - T.p.x, y = point.y - T.p.y, z = point.z - T.p.z;
    const V ux = T.R[2], uy = T.R[5], uz = T.R[8];
    return square_root(norm2({y * uz - z * uy, z * ux - x * uz, x * uy - y * ux}));
  }

 private:
  struct Extent {
    Point center;
    Bounds bounds;
  };

  const Extent& extent(int f) {
    if (!has_extent_[f]) {
      has_extent_[f] = 1;
      const FrameData& frame = robot_.frames[f];
      const Place& T = places_[frame.body];
      const Point c = map(T, frame.center[0], frame.center[1], frame.center[2]);
      const Point half{extent_along(T.R, frame.half), extent_along(T.R + 3, frame.half),
                       extent_along(T.R + 6, frame.half)};
      extents_[f] = {
          c, {{c.x - half.x, c.y - half.y, c.z - half.z}, {c.x + half.x, c.y + half.y, c.z + half.z}}};
    }
    return extents_[f];
  }

  Doubles position(int j) const {
    Doubles lanes;
    __builtin_memcpy(&lanes, batch_.is_edge ? batch_.middle : batch_.q[j], sizeof lanes);
    return batch_.is_edge ? batch_.q0[j] + lanes * batch_.dq[j] : lanes;
  }

  //! Pose of body k+1 from that of body k.
  void place_body(int k) {
    const JointData& joint = robot_.joints[k];
    const Place& from = places_[k];
    Place& to = places_[k + 1];
    const Doubles q = position(joint.q_index);
    V sine, cosine, shift{};
    sine_cosine((joint.is_prismatic ? Doubles{} : q) + joint.zero, sine, cosine);
    if (joint.is_prismatic) shift = __builtin_convertvector(q, V);
    const V tilt_cosine = all(joint.tilt_cosine), tilt_sine = all(joint.tilt_sine);
    const V offset[3] = {all(joint.offset[0]), all(joint.offset[1]), all(joint.offset[2])};
    const V from_p[3] = {from.p.x, from.p.y, from.p.z};
    V p[3];
    for (int i = 0; i < 3; ++i) {
      const V x = from.R[3 * i], v = from.R[3 * i + 1], w = from.R[3 * i + 2];
      const V y = v * tilt_cosine + w * tilt_sine, z = w * tilt_cosine - v * tilt_sine;
      p[i] = from_p[i] + (x * offset[0] + v * offset[1] + w * offset[2]);
      if (joint.is_prismatic) p[i] += z * shift;
      to.R[3 * i] = x * cosine + y * sine;
      to.R[3 * i + 1] = y * cosine - x * sine;
      to.R[3 * i + 2] = z;
    }
    to.p = {p[0], p[1], p[2]};
  }

  const RobotData& robot_;
  const Batch& batch_;
  Place* places_;    //!< by body
  Extent* extents_;  //!< by frame, valid where has_extent_
  char* has_extent_;
  int n_placed_ = 0;
};

}  // namespace
}  // namespace apc::simd8::APC_ARCHITECTURE
