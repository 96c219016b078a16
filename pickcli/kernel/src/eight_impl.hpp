// The test of eight.hpp, for one instruction set. The includer defines APC_ARCHITECTURE.
//
// No templates or inline functions of the standard library in here: the linker keeps one copy of each,
// and it must not be the one compiled for AVX2.
#include "eight.hpp"
#include "simd.hpp"

namespace apc::eight::APC_ARCHITECTURE {
namespace {

struct Point {
  V x, y, z;
};

struct Place {  // of a body in the world, R row-major
  V R[9];
  Point p;
};

APC_INLINE V square(V a) { return a * a; }
APC_INLINE V norm2(const Point& a) { return square(a.x) + square(a.y) + square(a.z); }
APC_INLINE V distance2(const Point& a, const Point& b) { return norm2({a.x - b.x, a.y - b.y, a.z - b.z}); }

// Squared distance of a point from a box, zero inside.
APC_INLINE V distance2(const Point& point, const Box& box) {
  const V x = point.x - box.center[0], y = point.y - box.center[1], z = point.z - box.center[2];
  const V zero{};
  const V dx = larger(magnitude(x * box.R[0] + y * box.R[3] + z * box.R[6]) - box.half[0], zero);
  const V dy = larger(magnitude(x * box.R[1] + y * box.R[4] + z * box.R[7]) - box.half[1], zero);
  const V dz = larger(magnitude(x * box.R[2] + y * box.R[5] + z * box.R[8]) - box.half[2], zero);
  return norm2({dx, dy, dz});
}

APC_INLINE Point map(const Place& T, const Ball& s) {
  return {T.p.x + T.R[0] * s.x + T.R[1] * s.y + T.R[2] * s.z, T.p.y + T.R[3] * s.x + T.R[4] * s.y + T.R[5] * s.z,
          T.p.z + T.R[6] * s.x + T.R[7] * s.y + T.R[8] * s.z};
}

// A world-aligned box, the same in every lane.
struct Bounds {
  Point low, high;

  // Which of eight groups it meets, a bit each.
  APC_INLINE int meets(const EightBounds& groups) const {
    return bits(~((high.x < load(groups.low[0])) | (high.y < load(groups.low[1])) | (high.z < load(groups.low[2])) |
                  (low.x > load(groups.high[0])) | (low.y > load(groups.high[1])) | (low.z > load(groups.high[2]))));
  }
};

// How close is too close, by lane: `near` at the midpoint, `far` for the whole interval.
struct Threshold {
  V near, far;
};

class EightTest {
 public:
  EightTest(const Robot& robot, const World& world, const Batch& batch, void* scratch, Verdict& verdict)
      : robot_(robot), world_(world), batch_(batch), verdict_(verdict) {
    places_ = static_cast<Place*>(scratch);
    points_ = reinterpret_cast<Point*>(places_ + robot.n_joints + 1);
    has_point_ = reinterpret_cast<char*>(points_ + robot.n_balls);
    __builtin_memset(has_point_, 0, static_cast<std::size_t>(robot.n_balls));
    half_width_ = load(batch.half_width);
    for (V& v : places_[0].R) v = V{};
    places_[0].R[0] = places_[0].R[4] = places_[0].R[8] = V{} + 1.0f;
    places_[0].p = {V{}, V{}, V{}};
  }

  // From the base outwards; the first hit ends it.
  void run() {
    Frames world = 0, self = 0;
    for (int i = 0; i < kLanes; ++i) world |= batch_.world[i], self |= batch_.self[i];
    int n_placed = 0;
    for (int f = 0; f < robot_.n_frames; ++f) {
      const Frame& frame = robot_.frames[f];
      if (frame.first_ball == frame.last_ball || !((world | self) >> f & 1)) continue;
      for (; n_placed < frame.body; ++n_placed) place_body(n_placed);
      if (batch_.is_edge) bound_motion(f);
      if (world >> f & 1 && start(batch_.world, f)) {
        if (hits_world(f)) return;
        note(verdict_.world, f);
      }
      if (frame.n_tested > 0 && self >> f & 1 && start(batch_.self, f)) {
        if (hits_self(f)) return;
        note(verdict_.self, f);
      }
    }
  }

 private:
  // Takes up the lanes in which a frame is still to be tested; whether there are any.
  bool start(const Frames* pending, int f) {
    live_ = open_ = 0;
    for (int i = 0; i < kLanes; ++i) live_ |= static_cast<int>(pending[i] >> f & 1) << i;
    live_ &= ~done_;
    return live_ != 0;
  }

  void note(Frames* unproven, int f) {
    for (int i = 0; i < kLanes; ++i) unproven[i] |= static_cast<Frames>(open_ >> i & 1) << f;
    if (!batch_.is_edge) done_ |= open_;
  }

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

  // For every inner body b: how far frame f moves relative to b, over the interval and by slack. Turning
  // the joints one by one from the base outwards, each sees the geometry of the midpoint, so a point
  // moves by at most the sum of (joint motion) * (distance from the joint's axis).
  void bound_motion(int f) {
    const Frame& frame = robot_.frames[f];
    const V spread = V{} + (frame.spread + batch_.lever_error);
    const Point root = point(frame.first_ball, frame.body);
    V moved{}, slack{};
    moved_[frame.body] = slack_[frame.body] = V{};
    for (int k = frame.body; k > 0; --k) {
      const float speed = batch_.speed[k - 1], loose = batch_.slack[k - 1];
      if (speed > 0.0f || loose > 0.0f) {
        const V lever = robot_.joints[k - 1].is_prismatic ? V{} + 1.0f : axis_distance(root, k) + spread;
        moved += lever * speed;
        slack += lever * loose;
      }
      moved_[k - 1] = moved * half_width_;
      slack_[k - 1] = slack;
    }
  }

  V axis_distance(const Point& point, int body) const {
    const Place& T = places_[body];
    const V x = point.x - T.p.x, y = point.y - T.p.y, z = point.z - T.p.z;
    const V ux = T.R[2], uy = T.R[5], uz = T.R[8];
    return square_root(norm2({y * uz - z * uy, z * ux - x * uz, x * uy - y * ux}));
  }

  // Thresholds for a frame moving relative to an inner body. An interval too short to split must be proven
  // as it is.
  Threshold threshold(float margin, int inner_body) const {
    const V base = V{} + margin;
    if (!batch_.is_edge) return {base, base};
    const V moved = moved_[inner_body];
    const V still = base + slack_[inner_body], whole = still + moved;
    return {moved < batch_.resolution ? whole : still, whole};
  }

  // The lanes at stake in which a squared distance does not exceed a threshold.
  int within(V d2, V threshold) const { return bits(not_above(d2, square(threshold))) & live_; }

  // Compares the squared distance of one pair, sum of radii given, with both thresholds. True: nothing is
  // left to be found for this frame.
  bool judge(V d2, V radius, Threshold& limit, int frame, int kind, int index) {
    const int open = within(d2, radius + limit.far);
    if (!open) return false;
    open_ |= open;
    if (!batch_.is_edge) return (live_ &= ~open) == 0;
    if (const int hit = within(d2, radius + limit.near)) {
      verdict_.hit_lane = __builtin_ctz(static_cast<unsigned>(hit));
      verdict_.frame = frame;
      verdict_.kind = kind;
      verdict_.index = index;
      return true;
    }
    // What is unproven anyway is only searched for a hit at its midpoint.
    limit.far = lanes(open) ? limit.near : limit.far;
    return false;
  }

  // True: a hit, the test is over.
  bool hits_world(int f) {
    const Frame& frame = robot_.frames[f];
    const Ball& ball = robot_.balls[frame.first_ball];
    const Point& root = point(frame.first_ball, frame.body);
    Threshold limit = threshold(batch_.world_margin, 0);
    const Bounds swept = bounds(root, ball.radius + limit.far);
    for (int first = 0; first < world_.n_groups; first += kLanes) {
      for (int near = swept.meets(world_.bounds[first / kLanes]); near; near &= near - 1) {
        const Group& group = world_.groups[first + __builtin_ctz(static_cast<unsigned>(near))];
        if (group.around.ignored >> f & 1) continue;
        if (!within(distance2(root, group.around), ball.radius + limit.far)) continue;
        if (hits_group(f, group, swept, limit)) return batch_.is_edge;
      }
    }
    return false;
  }

  bool hits_group(int f, const Group& group, const Bounds& swept, Threshold& limit) {
    const Frame& frame = robot_.frames[f];
    const V radius = V{} + robot_.balls[frame.first_ball].radius;
    const Point& root = point(frame.first_ball, frame.body);
    for (int first = 0; first < group.n_boxes; first += kLanes) {
      for (int near = swept.meets(group.bounds[first / kLanes]); near; near &= near - 1) {
        const Box& box = group.boxes[first + __builtin_ctz(static_cast<unsigned>(near))];
        if (box.ignored >> f & 1 || !is_near(distance2(root, box), radius, limit)) continue;
        if (hits_box(f, box, limit)) return true;
      }
    }
    return false;
  }

  // Whether a ball is near enough to look at what is in it. Where the interval moves it by more than its own
  // radius that would rarely prove anything: such lanes are left to their halves, but for hits.
  bool is_near(V d2, V radius, Threshold& limit) {
    const int near = within(d2, radius + limit.far);
    if (!near) return false;
    const int hasty = near & bits(limit.far - limit.near > radius);
    if (!hasty) return true;
    open_ |= hasty;
    limit.far = lanes(hasty) ? limit.near : limit.far;
    return within(d2, radius + limit.far) != 0;
  }

  // World-aligned bounds of the balls of all live lanes.
  Bounds bounds(const Point& center, V radius) const {
    const Mask live = lanes(live_);
    const V nowhere = V{} - __builtin_inff();
    const auto most = [&](V a) { return V{} + largest(live ? a + radius : nowhere); };
    return {{-most(-center.x), -most(-center.y), -most(-center.z)}, {most(center.x), most(center.y), most(center.z)}};
  }

  // Down the tree of a frame, skipping balls that are clear of the box in every live lane.
  bool hits_box(int f, const Box& box, Threshold& limit) {
    const Frame& frame = robot_.frames[f];
    for (int i = frame.first_ball + 1; i < frame.last_ball;) {
      const Ball& ball = robot_.balls[i];
      const V d2 = distance2(point(i, frame.body), box), radius = V{} + ball.radius;
      if (ball.is_sphere && judge(d2, radius, limit, f, 0, box.index)) return true;
      i = ball.is_sphere || within(d2, radius + limit.far) ? i + 1 : ball.next;
    }
    return false;
  }

  bool hits_self(int f) {
    const Frame& outer = robot_.frames[f];
    for (int i = outer.first_tested; i < outer.first_tested + outer.n_tested; ++i) {
      const int g = robot_.tested[i];
      const Frame& inner = robot_.frames[g];
      if (inner.first_ball == inner.last_ball) continue;
      Threshold limit = threshold(batch_.self_margin, inner.body);
      if (hits_frame(f, g, limit)) return batch_.is_edge;
    }
    return false;
  }

  // Down the tree of the outer frame against the root of the inner one, and from each sphere that is near
  // down the tree of the inner one.
  bool hits_frame(int f, int g, Threshold& limit) {
    const Frame &outer = robot_.frames[f], &inner = robot_.frames[g];
    const Point root = point(inner.first_ball, inner.body);
    const V root_radius = V{} + robot_.balls[inner.first_ball].radius;
    for (int i = outer.first_ball; i < outer.last_ball;) {
      const Ball& ball = robot_.balls[i];
      const Point& center = point(i, outer.body);
      const bool near = is_near(distance2(center, root), ball.radius + root_radius, limit);
      if (near && ball.is_sphere && hits_sphere(center, ball.radius, f, g, limit)) return true;
      i = near ? i + 1 : ball.next;
    }
    return false;
  }

  bool hits_sphere(const Point& center, float radius, int f, int g, Threshold& limit) {
    const Frame& inner = robot_.frames[g];
    for (int i = inner.first_ball; i < inner.last_ball;) {
      const Ball& ball = robot_.balls[i];
      const V d2 = distance2(center, point(i, inner.body)), sum = V{} + (radius + ball.radius);
      if (ball.is_sphere && judge(d2, sum, limit, f, 1, g)) return true;
      i = ball.is_sphere || within(d2, sum + limit.far) ? i + 1 : ball.next;
    }
    return false;
  }

  // Centre of a ball in the world, computed when first asked for.
  const Point& point(int i, int body) {
    if (!has_point_[i]) {
      has_point_[i] = 1;
      points_[i] = map(places_[body], robot_.balls[i]);
    }
    return points_[i];
  }

  const Robot& robot_;
  const World& world_;
  const Batch& batch_;
  Verdict& verdict_;
  Place* places_;    // by body
  Point* points_;    // by ball, valid where has_point_
  char* has_point_;  // by ball
  V half_width_;
  // A bit per lane: at stake in the frame at hand, found unproven in it, and, of configurations, found not
  // free in any frame before.
  int live_ = 0, open_ = 0, done_ = 0;
  V moved_[33], slack_[33];  // of the frame at hand, by inner body
};

}  // namespace

void test(const Robot& robot, const World& world, const Batch& batch, void* scratch, Verdict& verdict) {
  verdict = {{}, {}, -1, -1, -1, -1};
  EightTest(robot, world, batch, scratch, verdict).run();
}

}  // namespace apc::eight::APC_ARCHITECTURE
