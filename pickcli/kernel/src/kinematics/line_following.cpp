#include "kinematics/line_following.hpp"

#include <algorithm>
#include <cmath>

namespace apc {
namespace {

Pose tip(const Chain& chain, const Pose& T_last_tip, const double* q) {
  Pose frames[kMaxFrames];
  chain.fk(q, frames);
  return frames[chain.n_frames() - 1] * T_last_tip;
}

double angle_between(const Mat3& a, const Mat3& b) { return norm(rotation_vector(transposed(a) * b)); }

//! How far a pose is off half-way between two others. The turns before and after it should be equal, and
//! their difference is twice its own.
Deviation off_middle(const Pose& a, const Pose& middle, const Pose& b) {
  const Mat3 before = transposed(a.R) * middle.R, after = transposed(middle.R) * b.R;
  return {norm(middle.p - 0.5 * (a.p + b.p)), angle_between(before, after) / 2.0};
}

//! A straight line: the tip turns about one axis, in proportion to its progress.
class Line {
 public:
  Line(const Pose& first, const Pose& last) : first_(first), along_(last.p - first.p) {
    const Vec3 turn = rotation_vector(transposed(first.R) * last.R);
    length_ = norm(along_);
    angle_ = norm(turn);
    axis_ = (1.0 / std::max(angle_, 1e-12)) * turn;
  }

  //! How far a pose is off: its distance from the line, and its angle to the line's pose at the same place.
  //! A line without length has no places; there, the given progress (0 to 1) counts.
  Deviation deviation(const Pose& T, double progress) const {
    const Vec3 off = T.p - first_.p;
    const double s =
        length_ > 1e-6 ? std::clamp(dot(off, along_) / (length_ * length_), 0.0, 1.0) : progress;
    return {norm(off - s * along_), angle_between(first_.R * rotation(axis_, s * angle_), T.R)};
  }

 private:
  Pose first_;
  Vec3 along_, axis_;
  double length_, angle_;
};

//! Whether the joint chord from row i to row j of Q keeps the tip near the line between their poses.
bool is_straight(const Chain& chain, const Pose& T_last_tip, const double* Q, const std::vector<Pose>& poses,
                 int i, int j, const Deviation& most) {
  const int n = chain.n();
  const Line line(poses[i], poses[j]);
  double q[kMaxJoints];
  for (int k = i + 1; k < j; ++k) {
    const double s = static_cast<double>(k - i) / (j - i);
    for (int a = 0; a < n; ++a) q[a] = Q[i * n + a] + s * (Q[j * n + a] - Q[i * n + a]);
    if (!is_within(line.deviation(tip(chain, T_last_tip, q), s), most)) return false;
  }
  return true;
}

}  // namespace

Deviation line_deviation(const std::vector<Pose>& poses) {
  const Line line(poses.front(), poses.back());
  Deviation most;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const double steady = static_cast<double>(i) / static_cast<double>(poses.size() - 1);
    const Deviation off = line.deviation(poses[i], steady);
    most.position = std::max(most.position, off.position);
    most.angle = std::max(most.angle, off.angle);
  }
  return most;
}

FollowPath follow(const IkProblem& problem, const std::vector<Pose>& targets, const double* q0,
                  const double* max_step, const Deviation& most) {
  const int n = problem.chain.n();
  FollowPath path{{}, FollowEnd::done, {}};
  Configuration q(q0, q0 + n), middle(q);
  Pose T_world_tip = tip(problem.chain, problem.T_last_tip, q0);
  for (const Pose& target : targets) {
    const Configuration before = q;
    const Pose T_before = T_world_tip;
    const IkResult result = solve(problem, target, q.data());
    if (result == IkResult::converged) {
      for (int j = 0; j < n; ++j)
        if (std::abs(q[j] - before[j]) > max_step[j]) path.reason = FollowEnd::joint_step;
    } else {
      path.reason = result == IkResult::at_limit ? FollowEnd::limit : FollowEnd::no_convergence;
    }
    if (path.reason != FollowEnd::done) break;
    for (int j = 0; j < n; ++j) middle[j] = (before[j] + q[j]) / 2.0;
    T_world_tip = tip(problem.chain, problem.T_last_tip, q.data());
    path.off = off_middle(T_before, tip(problem.chain, problem.T_last_tip, middle.data()), T_world_tip);
    if (!is_within(path.off, most)) {
      path.reason = FollowEnd::off_line;
      break;
    }
    path.configurations.push_back(q);
  }
  return path;
}

std::vector<int> longest_chords(const Chain& chain, const Pose& T_last_tip, const double* Q,
                                const std::vector<Pose>& poses, const Deviation& most) {
  const int last = static_cast<int>(poses.size()) - 1;
  std::vector<int> kept{0};
  for (int i = 0; i < last; i = kept.back()) {
    int j = last;
    while (j > i + 1 && !is_straight(chain, T_last_tip, Q, poses, i, j, most)) j = i + (j - i) / 2;
    kept.push_back(j);
  }
  return kept;
}

}  // namespace apc
