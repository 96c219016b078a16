//! \file
//! Exact signed clearance in double precision.
#include <algorithm>

#include "collision/checker.hpp"

namespace apc {
namespace {

//! Looks for the nearest pair; a whole frame is skipped when its ball is farther than the best so far
//! (signed distances change by at most the distance moved, inside too).
class NearestPair {
 public:
  NearestPair(const Checker& checker, const double* q, double max_distance)
      : covers_(checker.robot().covers()), best_{max_distance}, T_world_frame_(covers_.size()) {
    checker.robot().place(q, T_world_frame_.data());
    for (std::size_t f = 0; f < covers_.size(); ++f) {
      if (covers_[f].tree.empty()) continue;
      const int frame = static_cast<int>(f);
      for (const Obstacle& obstacle : checker.world().obstacles())
        if (!(obstacle.ignored >> f & 1)) against_obstacle(frame, obstacle);
      for (int inner : covers_[f].tested) against_frame(frame, inner);
    }
  }

  const Contact& best() const { return best_; }

 private:
  Sphere ball(int f) const {
    const Sphere& root = covers_[f].tree.front().ball;
    return {T_world_frame_[f] * root.center, root.radius};
  }

  //! The held solid in the world.
  Solid placed(int f) const {
    Solid solid = *covers_[f].solid;
    solid.T = T_world_frame_[f] * solid.T;
    return solid;
  }

  void against_obstacle(int f, const Obstacle& obstacle) {
    const FrameCover& cover = covers_[f];
    const Solid& solid = obstacle.solid;
    if (signed_distance(ball(f).center, solid) - ball(f).radius >= best_.distance) return;
    if (cover.solid)
      offer(signed_distance(placed(f), solid, best_.distance), f, ContactKind::world, obstacle.index);
    for (const Sphere& s : cover.spheres)
      offer(signed_distance(T_world_frame_[f] * s.center, solid) - s.radius, f, ContactKind::world,
            obstacle.index);
  }

  void against_frame(int f, int g) {
    const FrameCover &outer = covers_[f], &inner = covers_[g];
    if (inner.tree.empty()) return;
    const Sphere a = ball(f), b = ball(g);
    if (norm(a.center - b.center) - a.radius - b.radius >= best_.distance) return;
    for (const Sphere& t : inner.spheres) {
      const Vec3 center = T_world_frame_[g] * t.center;
      if (outer.solid) offer(signed_distance(center, placed(f)) - t.radius, f, ContactKind::self, g);
      for (const Sphere& s : outer.spheres)
        offer(norm(center - T_world_frame_[f] * s.center) - s.radius - t.radius, f, ContactKind::self, g);
    }
  }

  void offer(double distance, int frame, ContactKind kind, int index) {
    if (distance < best_.distance) best_ = {distance, frame, kind, index};
  }

  const std::vector<FrameCover>& covers_;
  Contact best_;
  std::vector<Pose> T_world_frame_;
};

}  // namespace

Contact Checker::clearance(const double* q, double max_distance) const {
  return NearestPair(*this, q, max_distance).best();
}

}  // namespace apc
