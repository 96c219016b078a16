// Where the robot is in eight configurations: forward kinematics on demand, body by body and ball by ball.
#pragma once

#include "eight_geometry.hpp"

namespace apc::eight::APC_ARCHITECTURE {
namespace {

class Posture {
 public:
  // scratch: of scratch_bytes(robot), aligned to 32.
  Posture(const Robot& robot, const Batch& batch, void* scratch) : robot_(robot), batch_(batch) {
    places_ = static_cast<Place*>(scratch);
    points_ = reinterpret_cast<Point*>(places_ + robot.n_joints + 1);
    has_point_ = reinterpret_cast<char*>(points_ + robot.n_balls);
    __builtin_memset(has_point_, 0, static_cast<std::size_t>(robot.n_balls));
    for (V& v : places_[0].R) v = V{};
    places_[0].R[0] = places_[0].R[4] = places_[0].R[8] = V{} + 1.0f;
    places_[0].p = {V{}, V{}, V{}};
  }

  // Places all bodies up to this one; to be called before anything is asked about it.
  void reach(int body) {
    for (; n_placed_ < body; ++n_placed_) place_body(n_placed_);
  }

  const Place& place(int body) const { return places_[body]; }

  // Centre of a ball of a body in the world, computed when first asked for.
  const Point& point(int i, int body) {
    if (!has_point_[i]) {
      has_point_[i] = 1;
      points_[i] = map(places_[body], robot_.balls[i]);
    }
    return points_[i];
  }

  // Distance of a point from the axis of the joint that moves a body.
  V axis_distance(const Point& point, int body) const {
    const Place& T = places_[body];
    const V x = point.x - T.p.x, y = point.y - T.p.y, z = point.z - T.p.z;
    const V ux = T.R[2], uy = T.R[5], uz = T.R[8];
    return square_root(norm2({y * uz - z * uy, z * ux - x * uz, x * uy - y * ux}));
  }

 private:
  // Pose of body k+1 from that of body k.
  void place_body(int k) {
    const Joint& joint = robot_.joints[k];
    const float* C = joint.T_body_joint;
    const Place& from = places_[k];
    Place& to = places_[k + 1];
    Doubles q;
    __builtin_memcpy(&q, batch_.q[joint.q_index], sizeof q);
    V sine{}, cosine{}, shift{};
    if (joint.is_prismatic) shift = __builtin_convertvector(q, V);
    else sine_cosine(q, sine, cosine);
    V* p[3] = {&to.p.x, &to.p.y, &to.p.z};
    const V from_p[3] = {from.p.x, from.p.y, from.p.z};
    for (int i = 0; i < 3; ++i) {
      const V* r = from.R + 3 * i;
      const V x = r[0] * C[0] + r[1] * C[4] + r[2] * C[8];
      const V y = r[0] * C[1] + r[1] * C[5] + r[2] * C[9];
      const V z = r[0] * C[2] + r[1] * C[6] + r[2] * C[10];
      *p[i] = from_p[i] + (r[0] * C[3] + r[1] * C[7] + r[2] * C[11]);
      if (joint.is_prismatic) {
        to.R[3 * i] = x;
        to.R[3 * i + 1] = y;
        *p[i] += z * shift;
      } else {
        to.R[3 * i] = x * cosine + y * sine;
        to.R[3 * i + 1] = y * cosine - x * sine;
      }
      to.R[3 * i + 2] = z;
    }
  }

  const Robot& robot_;
  const Batch& batch_;
  Place* places_;    // by body
  Point* points_;    // by ball, valid where has_point_
  char* has_point_;  // by ball
  int n_placed_ = 0;
};

}  // namespace
}  // namespace apc::eight::APC_ARCHITECTURE
