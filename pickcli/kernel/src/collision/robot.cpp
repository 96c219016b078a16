#include "collision/robot.hpp"

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <string>

namespace apc {
namespace {

constexpr double u = simd8::kUnitRoundoff;

//! Worst error of one more joint in a body's rotation matrix (Frobenius norm): rounding of the tilt (1.5 u),
//! sine and cosine (4 u), and two turns of two columns each (4 u and 4 u). The base's own (1.5 u) is in what
//! is left.
constexpr double kRotationError = 16.0 * u;

void check_sphere(const Sphere& sphere, const std::string& what) {
  if (!(sphere.radius > 0.0)) throw std::invalid_argument(what + ": the radius of a sphere must be positive");
}

//! Of the farthest corner of a frame's box from the body's origin, or more.
double corner_distance(const simd8::FrameData& f) {
  return norm({f.center[0], f.center[1], f.center[2]}) + norm({f.half[0], f.half[1], f.half[2]});
}

//! The spheres of each frame.
std::vector<std::vector<Sphere>> by_frame(const std::vector<Sphere>& spheres, const std::vector<int>& frame,
                                          int n_frames, const std::string& what) {
  std::vector<std::vector<Sphere>> found(static_cast<std::size_t>(n_frames));
  for (std::size_t i = 0; i < spheres.size(); ++i) {
    check_sphere(spheres[i], what + " " + std::to_string(i));
    if (frame[i] < 0 || frame[i] >= n_frames)
      throw std::invalid_argument(what + " " + std::to_string(i) + ": frame " + std::to_string(frame[i]) +
                                  " is not in 0.." + std::to_string(n_frames - 1));
    found[static_cast<std::size_t>(frame[i])].push_back(spheres[i]);
  }
  return found;
}

float to_float(double x) { return static_cast<float>(x); }

simd8::Ball to_single(const Vec3& center, double radius, int next, bool is_sphere) {
  return {to_float(center.x), to_float(center.y), to_float(center.z), to_float(radius), next, is_sphere};
}

Mat3 about_z(double angle) { return rotation({0.0, 0.0, 1.0}, angle); }

//! A rotation as turns about z, then the new x, then the new z.
struct Turns {
  double first, tilt, last;
};

Turns as_turns(const Mat3& R) {
  const double first = std::atan2(R(0, 2), -R(1, 2)),
               tilt = std::atan2(std::hypot(R(0, 2), R(1, 2)), R(2, 2));
  const Vec3 x = rotation({1.0, 0.0, 0.0}, -tilt) * (about_z(-first) * R.column(0));
  return {first, tilt, std::atan2(x.y, x.x)};
}

//! A box aligned to a body, with all centres of spheres, or a solid's core, in it.
struct Box {
  Vec3 center, half;
  double rounding;  //!< of the solid, or the largest radius
  double spread;    //!< largest distance of a centre, or of a point of the core, from the box's centre
};

Box box_around(const Pose& T_body_frame, const std::vector<Sphere>& spheres) {
  if (spheres.empty()) return {};
  const double inf = std::numeric_limits<double>::infinity();
  Vec3 low{inf, inf, inf}, high{-inf, -inf, -inf};
  for (const Sphere& s : spheres) {
    const Vec3 c = T_body_frame * s.center;
    low = {std::min(low.x, c.x), std::min(low.y, c.y), std::min(low.z, c.z)};
    high = {std::max(high.x, c.x), std::max(high.y, c.y), std::max(high.z, c.z)};
  }
  Box box{0.5 * (low + high), 0.5 * (high - low), 0.0, 0.0};
  for (const Sphere& s : spheres) {
    box.rounding = std::max(box.rounding, s.radius);
    box.spread = std::max(box.spread, norm(T_body_frame * s.center - box.center));
  }
  return box;
}

Box box_around(const Pose& T_body_frame, const Solid& solid) {
  const Pose T = T_body_frame * solid.T;
  const Solid placed{T, solid.half, solid.rounding, solid.kind};
  const Vec3 half{support(placed, {1, 0, 0}), support(placed, {0, 1, 0}), support(placed, {0, 0, 1})};
  return {T.p, half, solid.rounding, norm(solid.half)};
}

}  // namespace

Robot::Robot(Chain chain, const std::vector<Sphere>& spheres, const std::vector<int>& frame,
             const std::vector<std::pair<int, int>>& self_pairs)
    : Robot(std::move(chain), spheres, frame, self_pairs, {}, {}) {}

Robot::Robot(Chain chain, const std::vector<Sphere>& spheres, const std::vector<int>& frame,
             const std::vector<std::pair<int, int>>& self_pairs, const std::vector<Sphere>& fine_spheres,
             const std::vector<int>& fine_frame)
    : chain_(std::move(chain)), covers_(chain_.n_frames() + 1) {
  const int n_frames = chain_.n_frames();
  std::vector<std::vector<Sphere>> coarse = by_frame(spheres, frame, n_frames, "sphere"),
                                   fine = by_frame(fine_spheres, fine_frame, n_frames, "fine sphere");
  for (std::size_t f = 0; f < coarse.size(); ++f) {
    covers_[f].spheres = std::move(coarse[f]);
    covers_[f].fine = build_ball_tree(std::move(fine[f]));
    if (covers_[f].spheres.empty() && !covers_[f].fine.empty())
      throw std::invalid_argument("frame " + std::to_string(f) + ": it has fine spheres and no others");
  }
  for (const auto& [a, b] : self_pairs) {
    if (a == b || std::min(a, b) < 0 || std::max(a, b) >= n_frames)
      throw std::invalid_argument("self pair (" + std::to_string(a) + ", " + std::to_string(b) +
                                  ") is not a pair of two frames in 0.." + std::to_string(n_frames - 1));
    covers_[std::max(a, b)].tested.push_back(std::min(a, b));
  }
  for (FrameCover& cover : covers_) cover.tree = build_ball_tree(cover.spheres);
  prepare_bodies();
  for (std::size_t f = 0; f < covers_.size(); ++f) prepare_cover(f);
  prepare_single();
}

Robot Robot::bare() const {
  Robot copy(*this);
  copy.replace_held({});
  return copy;
}

void Robot::set_held(std::vector<Sphere> spheres, std::vector<int> tested_frames) {
  for (size_t i = 0; i < spheres.size(); ++i) check_sphere(spheres[i], "held sphere " + std::to_string(i));
  std::vector<BallNode> tree = build_ball_tree(spheres);
  replace_held({std::move(spheres), {}, std::move(tree), {}, std::move(tested_frames)});
}

void Robot::set_held(const Solid& solid, std::vector<int> tested_frames) {
  const BallNode root{{solid.T.p, norm(solid.half) + solid.rounding}, 1, false};
  replace_held({{}, solid, {root}, {}, std::move(tested_frames)});
}

void Robot::replace_held(FrameCover held) {
  for (int f : held.tested)
    if (f < 0 || f >= chain_.n_frames())
      throw std::invalid_argument("tested frame " + std::to_string(f) + " is not in 0.." +
                                  std::to_string(chain_.n_frames() - 1));
  covers_.back() = std::move(held);
  balls_.resize(static_cast<std::size_t>(frames_.back().first_ball));
  tested_.resize(static_cast<std::size_t>(frames_.back().first_tested));
  frames_.pop_back();
  prepare_cover(frames_.size());
  prepare_single();
}

void Robot::place(const double* q, Pose* frames) const {
  chain_.fk(q, frames);
  frames[chain_.n_frames()] = frames[chain_.n_frames() - 1];
}

//! What is fixed between two moving joints is folded together and written as turns about z, x and z. The
//! first turns the frame of the body before, the last is where the joint's own turn begins.
void Robot::prepare_bodies() {
  std::vector<double> first_turn{0.0};  // by body
  Pose T_axis_frame;                    // of the frame at hand, as seen along the axis of its body
  for (const Joint& joint : chain_.joints()) {
    T_axis_frame = T_axis_frame * joint.T_parent_joint;
    if (joint.type != JointKind::fixed) {
      const Pose T_frame_axis{rotation_with_z(joint.axis), {}};
      const Pose T = T_axis_frame * T_frame_axis;
      const Turns turns = as_turns(T.R);
      first_turn.back() = turns.first;
      if (!joints_.empty()) joints_.back().zero += turns.first;
      const Vec3 offset = about_z(-turns.first) * T.p;
      joints_.push_back({{to_float(offset.x), to_float(offset.y), to_float(offset.z)},
                         to_float(std::cos(turns.tilt)),
                         to_float(std::sin(turns.tilt)),
                         turns.last,
                         joint.type == JointKind::prismatic,
                         joint.q_index});
      first_turn.push_back(0.0);
      T_axis_frame = inverse(T_frame_axis);
    }
    body_of_frame_.push_back(static_cast<int>(joints_.size()));
    T_body_frame_.push_back(T_axis_frame);
  }
  body_of_frame_.push_back(body_of_frame_.back());
  T_body_frame_.push_back(T_body_frame_.back());
  for (std::size_t f = 0; f < T_body_frame_.size(); ++f)
    T_body_frame_[f] = Pose{about_z(-first_turn[body_of_frame_[f]]), {}} * T_body_frame_[f];
  R_world_base_ = about_z(first_turn.front());
}

//! What single precision has of a frame goes behind that of the frames before it.
void Robot::prepare_cover(std::size_t f) {
  const FrameCover& cover = covers_[f];
  simd8::FrameData frame = bounded(f);
  frame.first_ball = static_cast<int>(balls_.size());
  add_balls(f, cover.tree);
  frame.last_ball = static_cast<int>(balls_.size());
  frame.first_self = cover.fine.empty() ? frame.first_ball : frame.last_ball;
  add_balls(f, cover.fine);
  frame.last_self = static_cast<int>(balls_.size());
  frame.first_tested = static_cast<int>(tested_.size());
  frame.n_tested = static_cast<int>(cover.tested.size());
  tested_.insert(tested_.end(), cover.tested.begin(), cover.tested.end());
  frames_.push_back(frame);
}

void Robot::add_balls(std::size_t f, const std::vector<BallNode>& tree) {
  const int first = static_cast<int>(balls_.size());
  for (const BallNode& node : tree) {
    const Vec3 center = T_body_frame_[f] * node.ball.center;
    // What bounds the spheres must still do so after rounding.
    const double slop = node.is_sphere ? 0.0 : 8.0 * u * (norm(center) + node.ball.radius);
    balls_.push_back(to_single(center, node.ball.radius + slop, first + node.next, node.is_sphere));
  }
}

void Robot::prepare_single() {
  simd8::Frames covered = 0;
  for (std::size_t f = 0; f < covers_.size(); ++f)
    if (!covers_[f].tree.empty()) covered |= simd8::Frames{1} << f;
  held_.clear();
  if (std::optional<Solid> solid = covers_.back().solid) {
    solid->T = T_body_frame_.back() * solid->T;
    held_.push_back(to_single(*solid));
  }
  single_ = {{},
             joints_.data(),
             static_cast<int>(joints_.size()),
             frames_.data(),
             static_cast<int>(frames_.size()),
             covered,
             balls_.data(),
             static_cast<int>(balls_.size()),
             tested_.data(),
             held_.empty() ? nullptr : held_.data()};
  for (int i = 0; i < 9; ++i) single_.R_world_base[i] = to_float(R_world_base_.m[i]);
  bound_rounding();
}

//! The frame with its box, nothing else set. What the box bounds it must still bound after rounding.
simd8::FrameData Robot::bounded(std::size_t f) const {
  const FrameCover& cover = covers_[f];
  Box box =
      cover.solid ? box_around(T_body_frame_[f], *cover.solid) : box_around(T_body_frame_[f], cover.spheres);
  double self_radius = box.rounding;
  for (const BallNode& node : cover.fine) {
    if (!node.is_sphere) continue;
    const Vec3 center = T_body_frame_[f] * node.ball.center, away = center - box.center;
    const Vec3 out{std::max(std::abs(away.x) - box.half.x, 0.0), std::max(std::abs(away.y) - box.half.y, 0.0),
                   std::max(std::abs(away.z) - box.half.z, 0.0)};
    self_radius = std::max(self_radius, norm(out) + node.ball.radius);
    box.spread = std::max(box.spread, norm(away));
  }
  const double slop = 16.0 * u * (norm(box.center) + norm(box.half));
  const Vec3 c = box.center, h = box.half + Vec3{slop, slop, slop};
  return {body_of_frame_[f],
          0,
          0,
          0,
          0,
          {to_float(c.x), to_float(c.y), to_float(c.z)},
          {to_float(h.x), to_float(h.y), to_float(h.z)},
          to_float(box.rounding * (1.0 + 2.0 * u)),
          to_float((self_radius + slop) * (1.0 + 2.0 * u)),
          to_float(box.spread + slop),
          0,
          0};
}

//! Every offset between two bodies inherits the rotation error of the joints before it and adds the
//! rounding of its own product (8 u of its length); every position is rounded twice more (2 u of the reach).
void Robot::bound_rounding() {
  const double n = static_cast<double>(joints_.size());
  rounding_ = reach_ = 0.0;
  for (size_t k = 0; k < joints_.size(); ++k) {
    const float* p = joints_[k].offset;
    const double offset = norm({p[0], p[1], p[2]});
    rounding_ += (static_cast<double>(k) * kRotationError + 8.0 * u) * offset;
    reach_ += offset;
  }
  double farthest = 0.0;
  for (const simd8::Ball& b : balls_) farthest = std::max(farthest, norm({b.x, b.y, b.z}));
  for (const simd8::FrameData& f : frames_) farthest = std::max(farthest, corner_distance(f));
  rounding_ += (n * kRotationError + 8.0 * u) * farthest;
  // A held solid is turned once more, and so are the points of its core.
  if (const std::optional<Solid>& solid = covers_.back().solid) {
    const double size = norm(solid->half) + solid->rounding;
    rounding_ += (n + 1.0) * kRotationError * size;
    farthest += size;
  }
  reach_ += farthest;
  rounding_ += 2.0 * (n + 1.0) * u * reach_;
  rounding_per_travel_ = n * kRotationError + 8.0 * u + 2.0 * (n + 1.0) * u;
}

//! Of two points; where one frame is a solid, the other's points are seen in its frame, turned as wrongly as
//! it is.
double Robot::self_rounding(double travel) const {
  const double turned =
      single_.held ? 2.0 * (static_cast<double>(joints_.size()) + 1.0) * kRotationError : 0.0;
  return 2.0 * rounding(travel) + (16.0 * u + turned) * reach(travel);
}

}  // namespace apc
