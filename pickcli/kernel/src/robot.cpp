#include "robot.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>

namespace apc {
namespace {

constexpr double u = eight::kUnitRoundoff;

// Worst error of one more joint in a body's rotation matrix (Frobenius norm): rounding of the constant
// matrix (1.8 u), product of two rotations in three-term sums (9 u), sine and cosine (4 u), turning the
// first two columns (4 u).
constexpr double kRotationError = 20.0 * u;

void check_sphere(const Sphere& sphere, const std::string& what) {
  if (!(sphere.radius > 0.0)) throw std::invalid_argument(what + ": the radius of a sphere must be positive");
}

eight::Ball to_single(const Vec3& center, double radius, int next, bool is_sphere) {
  return {static_cast<float>(center.x), static_cast<float>(center.y), static_cast<float>(center.z),
          static_cast<float>(radius), next, is_sphere};
}

}  // namespace

Robot::Robot(Chain chain, const std::vector<Sphere>& spheres, const std::vector<int>& frame,
             const std::vector<std::pair<int, int>>& self_pairs)
    : chain_(std::move(chain)), covers_(chain_.n_frames() + 1) {
  const int n_frames = chain_.n_frames();
  for (size_t i = 0; i < spheres.size(); ++i) {
    check_sphere(spheres[i], "sphere " + std::to_string(i));
    if (frame[i] < 0 || frame[i] >= n_frames)
      throw std::invalid_argument("sphere " + std::to_string(i) + ": frame " + std::to_string(frame[i]) +
                                  " is not in 0.." + std::to_string(n_frames - 1));
    covers_[frame[i]].spheres.push_back(spheres[i]);
  }
  for (const auto& [a, b] : self_pairs) {
    if (a == b || std::min(a, b) < 0 || std::max(a, b) >= n_frames)
      throw std::invalid_argument("self pair (" + std::to_string(a) + ", " + std::to_string(b) +
                                  ") is not a pair of two frames in 0.." + std::to_string(n_frames - 1));
    covers_[std::max(a, b)].tested.push_back(std::min(a, b));
  }
  for (FrameCover& cover : covers_) cover.tree = build_ball_tree(cover.spheres);
  prepare_bodies();
  prepare_covers();
}

void Robot::set_held(std::vector<Sphere> spheres, std::vector<int> tested_frames) {
  for (size_t i = 0; i < spheres.size(); ++i) check_sphere(spheres[i], "held sphere " + std::to_string(i));
  std::vector<BallNode> tree = build_ball_tree(spheres);
  replace_held({std::move(spheres), {}, std::move(tree), std::move(tested_frames)});
}

void Robot::set_held(const Solid& solid, std::vector<int> tested_frames) {
  const BallNode root{{solid.T.p, norm(solid.half) + solid.rounding}, 1, false};
  replace_held({{}, solid, {root}, std::move(tested_frames)});
}

void Robot::replace_held(FrameCover held) {
  for (int f : held.tested)
    if (f < 0 || f >= chain_.n_frames())
      throw std::invalid_argument("tested frame " + std::to_string(f) + " is not in 0.." +
                                  std::to_string(chain_.n_frames() - 1));
  covers_.back() = std::move(held);
  prepare_covers();
}

void Robot::place(const double* q, Pose* frames) const {
  chain_.fk(q, frames);
  frames[chain_.n_frames()] = frames[chain_.n_frames() - 1];
}

// Every moving joint gets a frame whose z is its axis, and what is fixed in between is folded together.
void Robot::prepare_bodies() {
  Pose T_body_frame;
  for (const Joint& joint : chain_.joints()) {
    T_body_frame = T_body_frame * joint.T_parent_joint;
    if (joint.type != JointType::fixed) {
      const Pose T_frame_body{rotation_with_z(joint.axis), {}};
      const Pose T = T_body_frame * T_frame_body;
      eight::Joint single{{}, joint.type == JointType::prismatic, joint.q_index};
      for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column)
          single.T_body_joint[4 * row + column] = static_cast<float>(T.R(row, column));
        single.T_body_joint[4 * row + 3] = static_cast<float>(row == 0 ? T.p.x : row == 1 ? T.p.y : T.p.z);
      }
      joints_.push_back(single);
      T_body_frame = inverse(T_frame_body);
    }
    body_of_frame_.push_back(static_cast<int>(joints_.size()));
    T_body_frame_.push_back(T_body_frame);
  }
  body_of_frame_.push_back(body_of_frame_.back());
  T_body_frame_.push_back(T_body_frame_.back());
}

void Robot::prepare_covers() {
  frames_.clear();
  balls_.clear();
  tested_.clear();
  for (size_t f = 0; f < covers_.size(); ++f) {
    const FrameCover& cover = covers_[f];
    const int first = static_cast<int>(balls_.size()), last = first + static_cast<int>(cover.tree.size());
    double spread = cover.solid ? (1.0 + 8.0 * u) * norm(cover.solid->half) : 0.0;
    for (const BallNode& node : cover.tree) {
      const Vec3 center = T_body_frame_[f] * node.ball.center;
      // What bounds the spheres must still do so after rounding.
      const double slop = node.is_sphere ? 0.0 : 8.0 * u * (norm(center) + node.ball.radius);
      balls_.push_back(to_single(center, node.ball.radius + slop, first + node.next, node.is_sphere));
      const double distance = norm(node.ball.center - cover.tree.front().ball.center);
      spread = std::max(spread, (1.0 + 8.0 * u) * distance + 8.0 * u * norm(center));
    }
    frames_.push_back({body_of_frame_[f], first, last, static_cast<float>(spread), static_cast<int>(tested_.size()),
                       static_cast<int>(cover.tested.size())});
    tested_.insert(tested_.end(), cover.tested.begin(), cover.tested.end());
  }
  held_.clear();
  if (std::optional<Solid> solid = covers_.back().solid) {
    solid->T = T_body_frame_.back() * solid->T;
    held_.push_back(to_single(*solid));
  }
  single_ = {joints_.data(), static_cast<int>(joints_.size()), frames_.data(),
             static_cast<int>(frames_.size()), balls_.data(), static_cast<int>(balls_.size()),
             tested_.data(), held_.empty() ? nullptr : held_.data()};
  bound_rounding();
}

// Every offset between two bodies inherits the rotation error of the joints before it and adds the
// rounding of its own product (8 u of its length); every position is rounded twice more (2 u of the reach).
void Robot::bound_rounding() {
  const double n = static_cast<double>(joints_.size());
  rounding_ = reach_ = 0.0;
  for (size_t k = 0; k < joints_.size(); ++k) {
    const float* C = joints_[k].T_body_joint;
    const double offset = norm({C[3], C[7], C[11]});
    rounding_ += (static_cast<double>(k) * kRotationError + 8.0 * u) * offset;
    reach_ += offset;
  }
  double farthest = 0.0;
  for (const eight::Ball& b : balls_) farthest = std::max(farthest, norm({b.x, b.y, b.z}));
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

// Of two points; where one frame is a solid, the other's points are seen in its frame, turned as wrongly as it is.
double Robot::self_rounding(double travel) const {
  const double turned = single_.held ? 2.0 * (static_cast<double>(joints_.size()) + 1.0) * kRotationError : 0.0;
  return 2.0 * rounding(travel) + (16.0 * u + turned) * reach(travel);
}

}  // namespace apc
