//! \file
//! Random poses, solids and robots, the same on every machine.
#pragma once

#include <random>
#include <vector>

#include "collision/checker.hpp"

namespace apc::test {

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}

  //! Uniform between two bounds.
  double between(double low, double high) {
    return low + (high - low) * (static_cast<double>(engine_() >> 11) * 0x1p-53);
  }
  int below(int n) { return static_cast<int>(engine_() % static_cast<unsigned>(n)); }

  Vec3 point(double size) { return {between(-size, size), between(-size, size), between(-size, size)}; }

  Vec3 direction() {
    for (;;) {
      const Vec3 v = point(1.0);
      const double length = norm(v);
      if (length > 0.1 && length < 1.0) return (1.0 / length) * v;
    }
  }

  Pose pose(double size) { return {rotation(direction(), between(-3.0, 3.0)), point(size)}; }

  Solid solid(const Pose& T, double rounding = 0.0) {
    const auto kind = static_cast<SolidKind>(below(3));
    const double r = between(0.02, 0.3), h = between(0.02, 0.3);
    if (kind == SolidKind::cylinder) return make_solid(T, {r, r, h}, kind, rounding);
    if (kind == SolidKind::sphere) return make_solid(T, {r, r, r}, kind, rounding);
    return make_solid(T, {r, between(0.02, 0.3), h}, kind, rounding);
  }

  //! Six joints, one of them a rail, with three spheres in every second frame.
  Robot robot() {
    std::vector<Joint> joints;
    std::vector<Sphere> spheres;
    std::vector<int> frame;
    for (int k = 0; k < 6; ++k) {
      const JointKind kind = k == 0 ? JointKind::prismatic : JointKind::revolute;
      joints.push_back({kind, {rotation(direction(), between(-3.0, 3.0)), point(0.2)}, direction(), k});
      if (k % 2 == 0) continue;
      for (int i = 0; i < 3; ++i) {
        spheres.push_back({point(0.1), between(0.02, 0.08)});
        frame.push_back(k);
      }
    }
    return Robot(Chain(std::move(joints)), spheres, frame, {});
  }

  World world(int n) {
    std::vector<Obstacle> obstacles;
    for (int i = 0; i < n; ++i) obstacles.push_back({solid(pose(1.2)), 0, i});
    return World(std::move(obstacles));
  }

  std::vector<double> configuration(int n) {
    std::vector<double> q;
    for (int j = 0; j < n; ++j) q.push_back(between(j == 0 ? -0.5 : -3.0, j == 0 ? 0.5 : 3.0));
    return q;
  }

 private:
  std::mt19937_64 engine_;
};

}  // namespace apc::test
