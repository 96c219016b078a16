//! \file
//! The test of simd8_collision.hpp, for one instruction set. The includer defines APC_ARCHITECTURE.
//!
//! No templates or inline functions of the standard library in here: the linker keeps one copy of each,
//! and it must not be the one compiled for AVX2.
#include "simd/simd8_distance_bound.hpp"
#include "simd/simd8_link_poses.hpp"

namespace apc::simd8::APC_ARCHITECTURE {
namespace {

//! How close is too close, by lane: `near` at the midpoint, `far` for the whole interval.
struct Threshold {
  V near, far;
};

//! Relative: more than axes that up to 32 joints have turned are too short or long by.
constexpr float kTurned = 1.0f + 1e-4f;

class CollisionTest {
 public:
  CollisionTest(const RobotData& robot, const WorldData& world, const Batch& batch, void* scratch,
                BatchResult& result)
      : robot_(robot),
        world_(world),
        batch_(batch),
        result_(result),
        poses_(robot, batch, scratch),
        half_width_(load(batch.half_width)) {}

  //! From the base outwards; the first hit ends it.
  void run() {
    const Pending world(batch_.world), self(batch_.self);
    for (Frames left = (world.any | self.any) & robot_.covered; left; left &= left - 1) {
      const int f = __builtin_ctzll(left);
      const FrameData& frame = robot_.frames[f];
      poses_.reach(frame.body);
      if (is_solid(f)) held_ = map(poses_.place(frame.body), *robot_.held);
      if (batch_.moves) bound_motion(f);
      if (start(world, f)) {
        if (hits_world(f)) return;
        note(result_.world, f);
      }
      if (frame.n_tested > 0 && start(self, f)) {
        if (hits_self(f)) return;
        note(result_.self, f);
      }
    }
  }

 private:
  //! What is still to be tested in any lane, and in all.
  struct Pending {
    explicit Pending(const Frames* by_lane) : by_lane(by_lane) {
      for (int i = 0; i < kLanes; ++i) any |= by_lane[i], all &= by_lane[i];
    }
    const Frames* by_lane;
    Frames any = 0, all = ~Frames{0};
  };

  //! Takes up the lanes in which a frame is still to be tested; whether there are any.
  bool start(const Pending& pending, int f) {
    live_ = open_ = 0;
    if (!(pending.any >> f & 1)) return false;
    if (pending.all >> f & 1)
      live_ = 255;
    else
      for (int i = 0; i < kLanes; ++i) live_ |= static_cast<int>(pending.by_lane[i] >> f & 1) << i;
    live_ &= ~done_;
    return live_ != 0;
  }

  void note(Frames* unproven, int f) {
    for (int left = open_; left; left &= left - 1)
      unproven[__builtin_ctz(static_cast<unsigned>(left))] |= Frames{1} << f;
    if (!batch_.is_edge) done_ |= open_;
  }

  //! For every inner body b: how far frame f moves relative to b, per unit of half_width and by slack.
  //! Turning the joints one by one from the base outwards, each sees the geometry of the midpoint, so a point
  //! moves by at most the sum of (joint motion) * (distance from the joint's axis).
  void bound_motion(int f) {
    const FrameData& frame = robot_.frames[f];
    const V spread = all(frame.spread + batch_.lever_error);
    const Point center = poses_.center(f);
    V moved{}, slack{};
    moved_[frame.body] = slack_[frame.body] = V{};
    for (int k = frame.body; k > 0; --k) {
      const float speed = batch_.speed[k - 1], loose = batch_.slack[k - 1];
      if (speed + loose > 0.0f) {
        const V lever =
            robot_.joints[k - 1].is_prismatic ? all(1.0f) : poses_.axis_distance(center, k) + spread;
        moved += lever * speed;
        if (loose > 0.0f) slack += lever * loose;
      }
      moved_[k - 1] = moved;
      slack_[k - 1] = slack;
    }
  }

  //! Thresholds for a frame moving relative to an inner body. An interval too short to split must be proven
  //! as it is.
  Threshold threshold(float margin, int inner_body) const {
    if (!batch_.moves) return {all(margin), all(margin)};
    const V moved = moved_[inner_body] * half_width_, still = slack_[inner_body] + margin,
            whole = still + moved;
    return {select(above(all(batch_.resolution), moved), whole, still), whole};
  }

  //! The lanes at stake in which a squared distance does not exceed a threshold.
  int within(V d2, V threshold) const { return ~bits(above(d2, square(threshold))) & live_; }

  //! Compares the squared distance of one pair, sum of radii given, with both thresholds. True: nothing is
  //! left to be found for this frame.
  bool judge(V d2, V radius, Threshold& limit, int frame, int kind, int index) {
    const int open = within(d2, radius + limit.far);
    if (!open) return false;
    open_ |= open;
    if (!batch_.is_edge) return (live_ &= ~open) == 0;
    if (const int hit = within(d2, radius + limit.near) & ~spared_) {
      result_.hit_lane = __builtin_ctz(static_cast<unsigned>(hit));
      result_.frame = frame;
      result_.kind = kind;
      result_.index = index;
      return true;
    }
    // What is unproven anyway is only searched for a hit at its midpoint.
    limit.far = select(lanes(open), limit.near, limit.far);
    return false;
  }

  //! What is looked for in the world: one frame, where it may be in any lane and how near is too near.
  struct Search {
    int f;
    const Bounds& box;  //!< by lane, of the frame at the midpoint
    Bounds swept;       //!< the same in every lane
    V radius, size;     //!< m, largest of the frame's spheres; of the ball around them
    Threshold& limit;
  };

  //! True: a hit, the test is over.
  bool hits_world(int f) {
    const FrameData& frame = robot_.frames[f];
    Threshold limit = threshold(batch_.world_margin, 0);
    const Bounds& box = poses_.bounds(f);
    const Search search{f,
                        box,
                        swept_bounds(box, frame.radius + limit.far),
                        all(frame.radius),
                        all(robot_.balls[frame.first_ball].radius),
                        limit};
    return (hits_obstacles(search) || hits_cloud(search)) && batch_.is_edge;
  }

  bool hits_obstacles(const Search& search) {
    const auto is_reached = [&](const Bounds& box) { return is_in_reach(search, box); };
    return any_near(world_.tree, search, is_reached, [&](int i, const Bounds& box) {
      const ObstacleData& obstacle = world_.obstacles[i];
      return !(obstacle.ignored >> search.f & 1) && hits(search, box, obstacle.solid, 0, obstacle.index);
    });
  }

  bool hits_cloud(const Search& search) {
    const CloudData& cloud = world_.cloud;
    if (cloud.ignored >> search.f & 1) return false;
    const auto is_reached = [&](const Bounds& box) {
      return is_in_reach(search, box) && is_in_reach_of_box(search, ball_around(box));
    };
    const float corner = kCorner * cloud.half_edge;
    return any_near(cloud.tree, search, is_reached, [&](int row, const Bounds& box) {
      if (!is_reached(box)) return false;
      const Points8& points = cloud.rows[row];
      for (int near = search.swept.meets(bounds_of(points, cloud.half_edge)); near; near &= near - 1) {
        const int i = __builtin_ctz(static_cast<unsigned>(near));
        const Point center{all(points.center[0][i]), all(points.center[1][i]), all(points.center[2][i])};
        if (!is_in_reach_of_box(search, {center, all(points.radius[i] + corner)})) continue;
        const SolidData solid = solid_of(points, i, cloud.half_edge);
        if (hits(search, bounds_around(solid), solid, 2, cloud.index[kLanes * row + i])) return true;
      }
      return false;
    });
  }

  //! Tries all things of a tree that the frame may come near to, until one says true.
  template <typename IsReached, typename Try>
  bool any_near(const TreeData& tree, const Search& search, const IsReached& is_reached, const Try& one) {
    for (int row = 0; row < tree.n_on_top; ++row)
      if (any_in_row(tree, tree.n_levels - 1, row, search, is_reached, one)) return true;
    return false;
  }

  template <typename IsReached, typename Try>
  bool any_in_row(const TreeData& tree, int level, int row, const Search& search, const IsReached& is_reached,
                  const Try& one) {
    const Bounds8& boxes = tree.levels[level][row];
    for (int near = search.swept.meets(bounds_of(boxes)); near; near &= near - 1) {
      const int i = __builtin_ctz(static_cast<unsigned>(near)), child = kLanes * row + i;
      const Bounds box = bounds_of(boxes, i);
      if (level == 0 ? one(child, box)
                     : is_reached(box) && any_in_row(tree, level - 1, child, search, is_reached, one))
        return true;
    }
    return false;
  }

  //! Whether the frame may come near to something in these bounds in any live lane.
  bool is_in_reach(const Search& search, const Bounds& box) const {
    return within(distance2(search.box, box), search.radius + search.limit.far) != 0;
  }

  //! The same of a ball in every lane, by the frame's box along the axes of its body: of a link that lies aslant
  //! that tells more than the box along the axes of the world. What rounding turns the body by is allowed for.
  bool is_in_reach_of_box(const Search& search, const AnyBall& ball) const {
    const FrameData& frame = robot_.frames[search.f];
    const Place& T = poses_.place(frame.body);
    const V x = ball.center.x - T.p.x, y = ball.center.y - T.p.y, z = ball.center.z - T.p.z, zero{};
    const auto outside = [&](int i) {
      const V at = x * T.R[i] + y * T.R[3 + i] + z * T.R[6 + i];
      return larger(magnitude(at - frame.center[i]) - frame.half[i], zero);
    };
    const V enough = (search.radius + search.limit.far + ball.radius) * kTurned + batch_.lever_error;
    return within(norm2({outside(0), outside(1), outside(2)}), enough) != 0;
  }

  //! One solid in its bounds; the kind is that of the report.
  bool hits(const Search& search, const Bounds& box, const SolidData& solid, int kind, int index) {
    const auto& [f, own, swept, radius, size, limit] = search;
    if (!is_near(distance2(own, box), radius, size, limit)) return false;
    return is_solid(f) ? hits_as_solid(f, solid, kind, index, limit)
                       : hits_spheres(f, solid, kind, index, limit);
  }

  //! Whether something is near enough to look at what is in it. Where the interval moves it by more than half
  //! its size that would rarely prove anything: such lanes are left to their halves, but for hits.
  bool is_near(V d2, V radius, V size, Threshold& limit) {
    const int near = within(d2, radius + limit.far);
    if (!near) return false;
    const int hasty = near & bits(above(limit.far - limit.near, 0.5f * size));
    if (!hasty) return true;
    open_ |= hasty;
    limit.far = select(lanes(hasty), limit.near, limit.far);
    return within(d2, radius + limit.far) != 0;
  }

  //! Bounds of everything within radius of the bounds of any live lane.
  Bounds swept_bounds(const Bounds& box, V radius) const {
    const Mask live = lanes(live_);
    const V nowhere = all(-__builtin_inff());
    const auto most = [&](V a) { return all(largest(select(live, a + radius, nowhere))); };
    return {{-most(-box.low.x), -most(-box.low.y), -most(-box.low.z)},
            {most(box.high.x), most(box.high.y), most(box.high.z)}};
  }

  //! Down the tree of a frame, skipping balls that are clear of the solid in every live lane.
  bool hits_spheres(int f, const SolidData& solid, int kind, int index, Threshold& limit) {
    const FrameData& frame = robot_.frames[f];
    for (int i = frame.first_ball + 1; i < frame.last_ball;) {
      const Ball& ball = robot_.balls[i];
      const V d2 = distance2(poses_.point(i, frame.body), solid);
      const V radius = all(ball.radius + solid.rounding);
      if (ball.is_sphere && judge(d2, radius, limit, f, kind, index)) return true;
      i = ball.is_sphere || within(d2, radius + limit.far) ? i + 1 : ball.next;
    }
    return false;
  }

  //! The held solid itself: by the widest slab between the two.
  bool hits_as_solid(int f, const SolidData& solid, int kind, int index, Threshold& limit) {
    const V radius = all(held_.rounding + solid.rounding);
    const V gap = DistanceBound(held_, solid).widest(radius + limit.near, radius + limit.far, live_);
    return judge(square(gap), radius, limit, f, kind, index);
  }

  bool hits_self(int f) {
    const FrameData& outer = robot_.frames[f];
    for (int i = outer.first_tested; i < outer.first_tested + outer.n_tested; ++i) {
      const int g = robot_.tested[i];
      const FrameData& inner = robot_.frames[g];
      if (inner.first_self == inner.last_self) continue;
      Threshold limit = threshold(batch_.self_margin, inner.body);
      const V radius = all(outer.self_radius + inner.self_radius);
      const V size = all(robot_.balls[outer.first_self].radius + robot_.balls[inner.first_self].radius);
      if (!is_near(distance2(poses_.bounds(f), poses_.bounds(g)), radius, size, limit)) continue;
      const int clear = live_ & ~near_by_few(f, g, limit.far);
      live_ &= ~clear;
      spared_ = batch_.moves ? live_ & ~near_by_few(f, g, limit.near) : 0;
      const bool is_over = live_ && (is_solid(f) ? hits_as_solid(f, g, limit) : hits_frame(f, g, limit));
      spared_ = 0;
      if (is_over && batch_.is_edge) return true;
      live_ |= clear;
      if (!live_) return false;
    }
    return false;
  }

  //! The live lanes in which the spheres that the world is tested by, fewer than the fine ones, do not tell two
  //! frames of the robot clear of each other by a threshold; all of them where neither has fine ones.
  int near_by_few(int f, int g, V threshold) const {
    const FrameData &outer = robot_.frames[f], &inner = robot_.frames[g];
    const bool is_fine = outer.first_self != outer.first_ball || inner.first_self != inner.first_ball;
    if (!is_fine || f == robot_.n_frames - 1) return live_;
    const Ball& root = robot_.balls[inner.first_ball];
    const Point middle = poses_.point(inner.first_ball, inner.body);
    int near = 0;
    for (int i = outer.first_ball; i < outer.last_ball && near != live_;) {
      const Ball& ball = robot_.balls[i];
      const Point center = poses_.point(i, outer.body);
      const bool reaches = within(distance2(center, middle), all(ball.radius + root.radius) + threshold) & ~near;
      if (reaches && ball.is_sphere) near |= near_spheres(center, ball.radius, inner, threshold);
      i = reaches ? i + 1 : ball.next;
    }
    return near;
  }

  //! The live lanes in which a sphere is near to one of a frame.
  int near_spheres(const Point& center, float radius, const FrameData& frame, V threshold) const {
    int near = 0;
    for (int i = frame.first_ball; i < frame.last_ball;) {
      const Ball& ball = robot_.balls[i];
      const int here =
          within(distance2(center, poses_.point(i, frame.body)), all(radius + ball.radius) + threshold) & ~near;
      if (ball.is_sphere) near |= here;
      i = here ? i + 1 : ball.next;
    }
    return near;
  }

  //! Down the tree of the outer frame against the box of the inner one, and from each sphere that is near
  //! down the tree of the inner one.
  bool hits_frame(int f, int g, Threshold& limit) {
    const FrameData &outer = robot_.frames[f], &inner = robot_.frames[g];
    const Bounds& box = poses_.bounds(g);
    const float size = robot_.balls[inner.first_self].radius;
    for (int i = outer.first_self + 1; i < outer.last_self;) {
      const Ball& ball = robot_.balls[i];
      const Point center = poses_.point(i, outer.body);
      const bool near = is_near(distance2({center, center}, box), all(ball.radius + inner.self_radius),
                                all(ball.radius + size), limit);
      if (near && ball.is_sphere && hits_sphere(center, ball.radius, f, g, limit)) return true;
      i = near ? i + 1 : ball.next;
    }
    return false;
  }

  //! The held solid itself against the tree of the inner frame.
  bool hits_as_solid(int f, int g, Threshold& limit) {
    const FrameData& inner = robot_.frames[g];
    for (int i = inner.first_self; i < inner.last_self;) {
      const Ball& ball = robot_.balls[i];
      const V d2 = distance2(poses_.point(i, inner.body), held_), sum = all(held_.rounding + ball.radius);
      if (ball.is_sphere && judge(d2, sum, limit, f, 1, g)) return true;
      i = ball.is_sphere || within(d2, sum + limit.far) ? i + 1 : ball.next;
    }
    return false;
  }

  bool is_solid(int f) const { return robot_.held && f == robot_.n_frames - 1; }

  bool hits_sphere(const Point& center, float radius, int f, int g, Threshold& limit) {
    const FrameData& inner = robot_.frames[g];
    for (int i = inner.first_self; i < inner.last_self;) {
      const Ball& ball = robot_.balls[i];
      const V d2 = distance2(center, poses_.point(i, inner.body)), sum = all(radius + ball.radius);
      if (ball.is_sphere && judge(d2, sum, limit, f, 1, g)) return true;
      i = ball.is_sphere || within(d2, sum + limit.far) ? i + 1 : ball.next;
    }
    return false;
  }

  const RobotData& robot_;
  const WorldData& world_;
  const Batch& batch_;
  BatchResult& result_;
  LinkPoses poses_;
  const V half_width_;
  Placed held_;  //!< of the held solid
  //! A bit per lane: at stake in the frame at hand, found unproven in it, and, of configurations, found not
  //! free in any frame before.
  int live_ = 0, open_ = 0, done_ = 0;
  int spared_ = 0;  //!< those that the frame at hand does not hit at the midpoint, whatever its fine spheres say
  V moved_[33], slack_[33];  //!< of the frame at hand, by inner body
};

}  // namespace

void test(const RobotData& robot, const WorldData& world, const Batch& batch, void* scratch,
          BatchResult& result) {
  result = {{}, {}, -1, -1, -1, -1};
  CollisionTest(robot, world, batch, scratch, result).run();
}

}  // namespace apc::simd8::APC_ARCHITECTURE
