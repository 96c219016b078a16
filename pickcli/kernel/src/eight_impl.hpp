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

APC_INLINE Point map(const Place& T, const Sphere& s) {
  return {T.p.x + T.R[0] * s.x + T.R[1] * s.y + T.R[2] * s.z, T.p.y + T.R[3] * s.x + T.R[4] * s.y + T.R[5] * s.z,
          T.p.z + T.R[6] * s.x + T.R[7] * s.y + T.R[8] * s.z};
}

// How close is too close, by lane: `near` at the midpoint, `far` for the whole interval.
struct Threshold {
  V near, far;
};

class EightTest {
 public:
  EightTest(const Robot& robot, const World& world, const Batch& batch, void* scratch, Verdict& verdict)
      : robot_(robot), world_(world), batch_(batch), verdict_(verdict) {
    places_ = static_cast<Place*>(scratch);
    balls_ = reinterpret_cast<Point*>(places_ + robot.n_joints + 1);
    points_ = balls_ + robot.n_frames;
    has_points_ = reinterpret_cast<char*>(points_ + robot.n_spheres);
    for (int f = 0; f < robot.n_frames; ++f) has_points_[f] = 0;
    for (int i = 0; i < kLanes; ++i) half_width_[i] = batch.half_width[i];
    for (V& v : places_[0].R) v = V{};
    places_[0].R[0] = places_[0].R[4] = places_[0].R[8] = V{} + 1.0f;
    places_[0].p = {V{}, V{}, V{}};
  }

  // From the base outwards; the first hit ends it.
  void run() {
    int n_placed = 0;
    for (int f = 0; f < robot_.n_frames; ++f) {
      const Frame& frame = robot_.frames[f];
      if (frame.n_spheres == 0) continue;
      for (; n_placed < frame.body; ++n_placed) place_body(n_placed);
      balls_[f] = map(places_[frame.body], frame.ball);
      if (batch_.is_edge) bound_motion(f);
      if (hits_world(f) || hits_self(f)) break;
    }
    verdict_.unproven = bits(unproven_);
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

  // For every inner body b: how far frame f moves relative to b, over the interval and by slack. Turning
  // the joints one by one from the base outwards, each sees the geometry of the midpoint, so a point
  // moves by at most the sum of (joint motion) * (distance from the joint's axis).
  void bound_motion(int f) {
    const Frame& frame = robot_.frames[f];
    const V spread = V{} + (frame.spread + batch_.lever_error);
    V moved{}, slack{};
    moved_[frame.body] = slack_[frame.body] = V{};
    for (int k = frame.body; k > 0; --k) {
      const float speed = batch_.speed[k - 1], loose = batch_.slack[k - 1];
      if (speed > 0.0f || loose > 0.0f) {
        const V lever = robot_.joints[k - 1].is_prismatic ? V{} + 1.0f : axis_distance(balls_[f], k) + spread;
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

  // Thresholds for a frame moving relative to an inner body. An interval that is already unproven is
  // only searched for a hit at its midpoint; one too short to split must be proven as it is.
  Threshold threshold(float margin, int inner_body) const {
    const V base = V{} + margin;
    if (!batch_.is_edge) return {base, base};
    const V moved = moved_[inner_body];
    const V still = base + slack_[inner_body], whole = still + moved;
    const V near = moved < batch_.resolution ? whole : still;
    return {near, unproven_ ? near : whole};
  }

  // The lanes still at stake in which a squared distance does not exceed a threshold.
  int within(V d2, V threshold) const { return bits(not_above(d2, square(threshold))) & live_; }

  // Compares the squared distance of one pair, sum of radii given, with both thresholds. True ends the test.
  bool judge(V d2, V radius, Threshold& limit, int frame, int kind, int index) {
    const int open = within(d2, radius + limit.far);
    if (!open) return false;
    unproven_ |= not_above(d2, square(radius + limit.far));
    if (!batch_.is_edge) return (live_ &= ~open) == 0;
    if (const int hit = within(d2, radius + limit.near)) {
      verdict_ = {0, __builtin_ctz(static_cast<unsigned>(hit)), frame, kind, index};
      return true;
    }
    limit.far = unproven_ ? limit.near : limit.far;
    return false;
  }

  bool hits_world(int f) {
    const Frame& frame = robot_.frames[f];
    Threshold limit = threshold(batch_.world_margin, 0);
    for (int g = 0; g < world_.n_groups; ++g) {
      const Group& group = world_.groups[g];
      if (!is_near(f, group.around, limit)) continue;
      for (int b = group.first_box; b < group.first_box + group.n_boxes; ++b) {
        const Box& box = world_.boxes[b];
        if (!is_near(f, box, limit)) continue;
        place_points(f);
        for (int s = frame.first_sphere; s < frame.first_sphere + frame.n_spheres; ++s) {
          const V radius = V{} + robot_.spheres[s].radius;
          if (judge(distance2(points_[s], box), radius, limit, f, 0, box.index)) return true;
        }
      }
    }
    return false;
  }

  bool is_near(int f, const Box& box, const Threshold& limit) const {
    if (box.ignored >> f & 1) return false;
    return within(distance2(balls_[f], box), robot_.frames[f].ball.radius + limit.far) != 0;
  }

  bool hits_self(int f) {
    const Frame& outer = robot_.frames[f];
    for (int i = outer.first_tested; i < outer.first_tested + outer.n_tested; ++i) {
      const int g = robot_.tested[i];
      const Frame& inner = robot_.frames[g];
      if (inner.n_spheres == 0) continue;
      Threshold limit = threshold(batch_.self_margin, inner.body);
      const V reach = outer.ball.radius + inner.ball.radius + limit.far;
      if (!within(distance2(balls_[f], balls_[g]), reach)) continue;
      place_points(f);
      place_points(g);
      if (hits_frame(f, g, limit)) return true;
    }
    return false;
  }

  bool hits_frame(int f, int g, Threshold& limit) {
    const Frame &outer = robot_.frames[f], &inner = robot_.frames[g];
    for (int s = outer.first_sphere; s < outer.first_sphere + outer.n_spheres; ++s) {
      const float radius = robot_.spheres[s].radius;
      const V reach = radius + inner.ball.radius + limit.far;
      if (!within(distance2(points_[s], balls_[g]), reach)) continue;
      for (int t = inner.first_sphere; t < inner.first_sphere + inner.n_spheres; ++t) {
        const V sum = V{} + (radius + robot_.spheres[t].radius);
        if (judge(distance2(points_[s], points_[t]), sum, limit, f, 1, g)) return true;
      }
    }
    return false;
  }

  void place_points(int f) {
    if (has_points_[f]) return;
    has_points_[f] = 1;
    const Frame& frame = robot_.frames[f];
    for (int s = frame.first_sphere; s < frame.first_sphere + frame.n_spheres; ++s)
      points_[s] = map(places_[frame.body], robot_.spheres[s]);
  }

  const Robot& robot_;
  const World& world_;
  const Batch& batch_;
  Verdict& verdict_;
  Place* places_;     // by body
  Point* balls_;      // by frame
  Point* points_;     // by sphere, valid where has_points_
  char* has_points_;  // by frame
  V half_width_;
  Mask unproven_{};
  int live_ = 0xff;  // bit per lane; without motion, a lane that is not free is not looked at again
  V moved_[33], slack_[33];  // of the frame at hand, by inner body
};

}  // namespace

void test(const Robot& robot, const World& world, const Batch& batch, void* scratch, Verdict& verdict) {
  verdict = {0, -1, -1, -1, -1};
  EightTest(robot, world, batch, scratch, verdict).run();
}

}  // namespace apc::eight::APC_ARCHITECTURE
