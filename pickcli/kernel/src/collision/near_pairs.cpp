#include "collision/near_pairs.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace apc {
namespace {

constexpr std::size_t kMostOfPair = 4;  // spheres: which one is the nearest may change within a step
constexpr double kStep = 1e-7;  // m, of the differences that make a normal

//! Unit gradient of the signed distance at a point, by central differences; 0 where it has none.
Vec3 normal_at(const Vec3& p, const Solid& solid) {
  const auto slope = [&](const Vec3& e) {
    return (signed_distance(p + kStep * e, solid) - signed_distance(p - kStep * e, solid)) / (2.0 * kStep);
  };
  const Vec3 g{slope({1, 0, 0}), slope({0, 1, 0}), slope({0, 0, 1})};
  const double size = norm(g);
  return size > 0.5 ? (1.0 / size) * g : g;
}

//! A sphere near a solid or another sphere.
struct Near {
  double distance;
  Vec3 center, other;
};

class NearPairs {
 public:
  NearPairs(const Checker& checker, const double* q, double influence)
      : checker_(checker), covers_(checker.robot().covers()), influence_(influence), frames_(covers_.size()) {
    checker.robot().place(q, frames_.data());
    for (std::size_t f = 0; f < covers_.size(); ++f) {
      if (covers_[f].tree.empty()) continue;
      if (covers_[f].solid) throw std::invalid_argument("a held solid has no gradient of its distance");
      const int frame = static_cast<int>(f);
      against_solids(frame);
      against_cloud(frame);
      for (int inner : covers_[f].tested) against_frame(frame, inner);
    }
  }

  std::vector<NearPair> found;

 private:
  Sphere placed(int f, const Sphere& sphere) const { return {frames_[f] * sphere.center, sphere.radius}; }

  //! Frames from L on are rigid on frame L-1.
  int last_joint(int f) const { return std::min(f, checker_.robot().chain().n_frames() - 1); }

  //! Adds scale * n^T J of a point p that is fixed in frame f.
  void add_rows(int f, const Vec3& p, const Vec3& n, double scale, std::vector<double>& row) const {
    const std::vector<Joint>& joints = checker_.robot().chain().joints();
    for (int k = 0; k <= last_joint(f); ++k) {
      const Joint& joint = joints[static_cast<std::size_t>(k)];
      if (joint.type == JointKind::fixed) continue;
      const Vec3 axis = frames_[k].R * joint.axis;
      const Vec3 moves = joint.type == JointKind::prismatic ? axis : cross(axis, p - frames_[k].p);
      row[static_cast<std::size_t>(joint.q_index)] += scale * dot(n, moves);
    }
  }

  std::vector<double> no_row() const { return std::vector<double>(static_cast<std::size_t>(checker_.n()), 0.0); }

  //! Adds the spheres of a frame that are nearest to a solid, of those within the influence.
  void offer(int f, const Solid& solid, ContactKind kind, int index) {
    near_.clear();
    for (const Sphere& each : covers_[f].spheres) {
      const Sphere sphere = placed(f, each);
      const double distance = signed_distance(sphere.center, solid) - sphere.radius;
      if (distance < influence_) near_.push_back({distance, sphere.center, {}});
    }
    for (const Near& each : nearest()) {
      NearPair pair{{each.distance, f, kind, index}, no_row()};
      add_rows(f, each.center, normal_at(each.center, solid), 1.0, pair.gradient);
      found.push_back(std::move(pair));
    }
  }

  void against_solids(int f) {
    const Sphere around = placed(f, covers_[f].tree.front().ball);
    const World& world = checker_.world();
    world.tree().visit_near(around.center, [&] { return influence_ + around.radius; }, [&](int i) {
      const Obstacle& obstacle = world.obstacles()[static_cast<std::size_t>(i)];
      if (!(obstacle.ignored >> f & 1)) offer(f, obstacle.solid, ContactKind::world, obstacle.index);
    });
  }

  void against_cloud(int f) {
    const World& world = checker_.world();
    if (world.ignored_by_cloud() >> f & 1) return;
    const Cloud& cloud = *world.cloud();
    const Sphere around = placed(f, covers_[f].tree.front().ball);
    double least = influence_;
    int nearest = -1;
    cloud.tree().visit_near(around.center, [&] { return least + around.radius; }, [&](int row) {
      const int first = simd8::kLanes * row, last = std::min(first + simd8::kLanes, cloud.size());
      for (int i = first; i < last; ++i) {
        const Solid solid = cloud.solid(i);
        for (const Sphere& each : covers_[f].spheres) {
          const Sphere sphere = placed(f, each);
          const double distance = signed_distance(sphere.center, solid) - sphere.radius;
          if (distance < least) least = distance, nearest = i;
        }
      }
    });
    if (nearest >= 0) offer(f, cloud.solid(nearest), ContactKind::cloud, cloud.index(nearest));
  }

  void against_frame(int f, int g) {
    const Sphere outer = placed(f, covers_[f].tree.front().ball), inner = placed(g, covers_[g].tree.front().ball);
    if (norm(outer.center - inner.center) - outer.radius - inner.radius >= influence_) return;
    near_.clear();
    for (const Sphere& i : covers_[f].spheres)
      for (const Sphere& j : covers_[g].spheres) {
        const Sphere s = placed(f, i), t = placed(g, j);
        const double distance = norm(s.center - t.center) - s.radius - t.radius;
        if (distance < influence_) near_.push_back({distance, s.center, t.center});
      }
    for (const Near& each : nearest()) {
      NearPair pair{{each.distance, f, ContactKind::self, g}, no_row()};
      const Vec3 off = each.center - each.other;
      if (const double size = norm(off); size > 0.0) {
        add_rows(f, each.center, (1.0 / size) * off, 1.0, pair.gradient);
        add_rows(g, each.other, (1.0 / size) * off, -1.0, pair.gradient);
      }
      found.push_back(std::move(pair));
    }
  }

  //! The few nearest of near_.
  std::vector<Near> nearest() {
    const auto is_nearer = [](const Near& a, const Near& b) { return a.distance < b.distance; };
    const auto last = near_.begin() + static_cast<std::ptrdiff_t>(std::min(near_.size(), kMostOfPair));
    std::partial_sort(near_.begin(), last, near_.end(), is_nearer);
    return {near_.begin(), last};
  }

  const Checker& checker_;
  const std::vector<FrameCover>& covers_;
  const double influence_;
  std::vector<Pose> frames_;
  std::vector<Near> near_;
};

}  // namespace

std::vector<NearPair> near_pairs(const Checker& checker, const double* q, double influence) {
  return NearPairs(checker, q, influence).found;
}

}  // namespace apc
