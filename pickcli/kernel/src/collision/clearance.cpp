//! \file
//! Exact signed clearance in double precision.
#include <algorithm>
#include <limits>
#include <memory>

#include "collision/checker.hpp"

namespace apc {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kRounding = 1e-12;  //!< m, far above that of a distance in double precision

//! Looks for the nearest pair; a frame, or what a ball of its tree holds, is skipped when the ball is farther than
//! the best so far (signed distances change by at most the distance moved, inside too). The search ends where a
//! pair is not farther than too_near: that is then what it finds, or a pair that is nearer.
class NearestPair {
 public:
  NearestPair(const Checker& checker, const double* q, double max_distance, double too_near = -kInfinity)
      : covers_(checker.robot().covers()), best_{max_distance}, too_near_(too_near), T_world_frame_(covers_.size()) {
    checker.robot().place(q, T_world_frame_.data());
    for (std::size_t f = 0; f < covers_.size() && !is_over(); ++f) {
      if (covers_[f].tree.empty()) continue;
      const int frame = static_cast<int>(f);
      if (covers_[f].solid) held_ = placed(frame);
      against_world(frame, checker.world());
      measure_put_off(frame);
      for (int inner : covers_[f].tested) against_frame(frame, inner);
    }
  }

  const Contact& best() const { return best_; }

 private:
  struct PutOff {
    double bound;  //!< m, not above the distance
    Solid solid;
    ContactKind kind;
    int index;
  };

  //! Nothing that is farther is the nearest pair.
  double most() const { return std::min(best_.distance, least_known_); }

  bool is_over() const { return best_.distance <= too_near_; }

  Sphere ball(int f, const std::vector<BallNode>& tree) const {
    const Sphere& root = tree.front().ball;
    return {T_world_frame_[f] * root.center, root.radius};
  }

  //! The held solid in the world.
  Solid placed(int f) const {
    Solid solid = *covers_[f].solid;
    solid.T = T_world_frame_[f] * solid.T;
    return solid;
  }

  void against_world(int f, const World& world) {
    const Sphere around = ball(f, covers_[f].tree);
    // Where the ball's centre is within bounds, what is in them may be deeper than the best.
    const auto nearest = [&] { return is_over() ? -1.0 : std::max(most() + around.radius, 0.0); };
    world.tree().visit_near(around.center, nearest, [&](int i) {
      const Obstacle& obstacle = world.obstacles()[static_cast<std::size_t>(i)];
      if (!(obstacle.ignored >> f & 1)) against_solid(f, obstacle.solid, ContactKind::world, obstacle.index);
    });
    const Cloud& cloud = *world.cloud();
    if (world.ignored_by_cloud() >> f & 1) return;
    cloud.tree().visit_near(around.center, nearest, [&](int row) {
      const int first = simd8::kLanes * row, last = std::min(first + simd8::kLanes, cloud.size());
      for (int i = first; i < last; ++i) against_solid(f, cloud.solid(i), ContactKind::cloud, cloud.index(i));
    });
  }

  void against_solid(int f, const Solid& solid, ContactKind kind, int index) {
    const FrameCover& cover = covers_[f];
    const Sphere around = ball(f, cover.tree);
    if (is_over()) return;
    const double from_center = signed_distance(around.center, solid);
    if (from_center - around.radius > most()) return;
    if (cover.solid) return put_off(from_center, solid, kind, index);
    const auto distance = [&](const Sphere& ball) { return signed_distance(ball.center, solid) - ball.radius; };
    visit_near(f, cover.tree, best_.distance, distance, [&](const Sphere& s) { offer(distance(s), f, kind, index); });
  }

  //! Bounds the distance of the held solid from another; it is measured when that of the nearest is known.
  void put_off(double from_center, const Solid& solid, ContactKind kind, int index) {
    const Vec3& half = held_.half;
    least_known_ = std::min(least_known_, from_center - std::min({half.x, half.y, half.z}) - held_.rounding + kRounding);
    const double bound = distance_bound(held_, solid, most());
    if (bound <= most()) put_off_.push_back({bound, solid, kind, index});
  }

  //! Measures the distances put off, the least bound first.
  void measure_put_off(int f) {
    const auto is_less = [](const PutOff& a, const PutOff& b) { return a.bound < b.bound; };
    std::sort(put_off_.begin(), put_off_.end(), is_less);
    for (const auto& [bound, solid, kind, index] : put_off_) {
      if (is_over() || bound > best_.distance) break;
      offer(signed_distance(held_, solid, bound, best_.distance, too_near_), f, kind, index);
    }
    put_off_.clear();
  }

  //! Calls visit(sphere) for the spheres of a tree of a frame, in the world, that may be nearer than the least by
  //! a distance of balls.
  template <typename Distance, typename Visit>
  void visit_near(int f, const std::vector<BallNode>& tree, const double& least, const Distance& distance,
                  const Visit& visit) const {
    for (std::size_t i = 0; i < tree.size();) {
      const Sphere ball{T_world_frame_[f] * tree[i].ball.center, tree[i].ball.radius};
      if (tree[i].is_sphere)
        visit(ball), ++i;
      else
        i = distance(ball) > least + kRounding ? static_cast<std::size_t>(tree[i].next) : i + 1;
    }
  }

  void against_frame(int f, int g) {
    const FrameCover& outer = covers_[f];
    const FrameCover& inner = covers_[g];
    if (inner.tree.empty()) return;
    double gap = between(f, outer.self_tree(), g, inner.self_tree());
    const bool is_fine = !(outer.fine.empty() && inner.fine.empty()), is_held = &outer == &covers_.back();
    if (is_fine && !is_held && gap < best_.distance) gap = std::max(gap, between(f, outer.tree, g, inner.tree));
    if (gap < best_.distance) offer(gap, f, ContactKind::self, g);
  }

  //! Distance of what two trees of two frames hold, in the first perhaps the held solid; where it is not less than
  //! the best so far, that.
  double between(int f, const std::vector<BallNode>& outer, int g, const std::vector<BallNode>& inner) const {
    double least = best_.distance;
    const auto gap = [](const Sphere& s, const Sphere& t) {
      return norm(t.center - s.center) - s.radius - t.radius;
    };
    const Sphere around = ball(f, outer);
    if (gap(around, ball(g, inner)) >= least) return least;
    visit_near(g, inner, least, [&](const Sphere& t) { return gap(around, t); }, [&](const Sphere& t) {
      if (covers_[f].solid) least = std::min(least, signed_distance(t.center, held_) - t.radius);
      visit_near(f, outer, least, [&](const Sphere& s) { return gap(s, t); },
                 [&](const Sphere& s) { least = std::min(least, gap(s, t)); });
    });
    return least;
  }

  //! Of obstacles that are equally near the first of the user counts, whatever their order in the tree.
  void offer(double distance, int frame, ContactKind kind, int index) {
    const bool is_first = frame == best_.frame && kind == best_.kind && index < best_.index;
    if (distance < best_.distance || (distance == best_.distance && is_first))
      best_ = {distance, frame, kind, index};
  }

  const std::vector<FrameCover>& covers_;
  Contact best_;
  const double too_near_;
  double least_known_ = kInfinity;  //!< m, that some pair is not farther
  Solid held_;                      //!< in the world
  std::vector<PutOff> put_off_;     //!< what the held solid may be nearest to
  std::vector<Pose> T_world_frame_;
};

}  // namespace

Contact Checker::clearance(const double* q, double max_distance) const {
  return NearestPair(*this, q, max_distance).best();
}

void Checker::clearances(const double* Q, int n_rows, double max_distance, double* out) const {
  const std::size_t n = static_cast<std::size_t>(this->n()), K = static_cast<std::size_t>(n_rows);
  const auto is_far = std::make_unique<bool[]>(K);
  are_free(Q, n_rows, max_distance, is_far.get());
  for (std::size_t i = 0; i < K; ++i)
    out[i] = is_far[i] ? max_distance : clearance(Q + i * n, max_distance).distance;
}

std::vector<ClearRow> Checker::clearest(const double* Q, int n_rows, int n_most, double max_distance) const {
  std::vector<ClearRow> kept;
  for (int i = 0; i < n_rows && n_most > 0; ++i) {
    const bool is_full = static_cast<int>(kept.size()) == n_most;
    const double least = is_full ? kept.back().distance : -kInfinity;
    const double* q = Q + static_cast<std::size_t>(i) * static_cast<std::size_t>(n());
    const double distance = NearestPair(*this, q, max_distance, least).best().distance;
    if (distance <= least) continue;
    if (is_full) kept.pop_back();
    const auto is_farther = [](double d, const ClearRow& row) { return d > row.distance; };
    kept.insert(std::upper_bound(kept.begin(), kept.end(), distance, is_farther), {i, distance});
  }
  return kept;
}

}  // namespace apc
