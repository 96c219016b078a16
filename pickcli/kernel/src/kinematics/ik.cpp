#include "kinematics/ik.hpp"

#include <algorithm>
#include <cmath>

namespace apc {
namespace {

using Vec6 = std::array<double, 6>;

double squared(const Vec6& e) {
  double sum = 0.0;
  for (double v : e) sum += v * v;
  return sum;
}

//! Solves the symmetric positive definite system A x = b in place of b (Cholesky).
void solve_spd(double A[6][6], Vec6& b) {
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j <= i; ++j) {
      double sum = A[i][j];
      for (int k = 0; k < j; ++k) sum -= A[i][k] * A[j][k];
      A[i][j] = i == j ? std::sqrt(sum) : sum / A[j][j];
    }
  }
  for (int i = 0; i < 6; ++i) {
    for (int k = 0; k < i; ++k) b[i] -= A[i][k] * b[k];
    b[i] /= A[i][i];
  }
  for (int i = 5; i >= 0; --i) {
    for (int k = i + 1; k < 6; ++k) b[i] -= A[k][i] * b[k];
    b[i] /= A[i][i];
  }
}

//! One descent: the iterate, its error and its Jacobian.
class Descent {
 public:
  Descent(const IkProblem& problem, const Pose& target, double* q)
      : problem_(problem), target_(target), n_(problem.chain.n()), q_(q) {
    for (int j = 0; j < n_; ++j) q_[j] = std::clamp(q_[j], problem.lower[j], problem.upper[j]);
    error_ = error(q_);
  }

  IkResult run() {
    double damping = 1e-3;
    bool accepted = true;
    for (int i = 0; i < problem_.max_iterations && !is_converged(); ++i) {
      if (accepted) problem_.chain.jacobian(frames_, T_world_tip_.p, J_);
      double q_new[kMaxJoints];
      step(damping, q_new);
      const Vec6 e = error(q_new);
      const double before = squared(error_), after = squared(e);
      accepted = after < before;
      if (accepted) {
        // Almost no progress by a nearly undamped step is a local minimum: another seed is cheaper.
        const bool is_stuck = after > 0.9999 * before && damping < 1e-2;
        std::copy(q_new, q_new + n_, q_);
        error_ = e;
        damping = std::max(0.2 * damping, 1e-10);
        if (is_stuck) break;
      } else {
        damping *= 10.0;
        if (damping > 1e5) break;
      }
    }
    if (is_converged()) return IkResult::converged;
    return n_pressed_ > 0 ? IkResult::at_limit : IkResult::not_converged;
  }

 private:
  bool is_converged() const {
    const Vec6& e = error_;
    return norm({e[0], e[1], e[2]}) <= problem_.position_tolerance &&
           norm({e[3], e[4], e[5]}) <= problem_.rotation_tolerance;
  }

  Vec6 error(const double* q) {
    problem_.chain.fk(q, frames_);
    T_world_tip_ = frames_[problem_.chain.n_frames() - 1] * problem_.T_last_tip;
    const Vec3 p = target_.p - T_world_tip_.p;
    const Vec3 r = rotation_vector(target_.R * transposed(T_world_tip_.R));
    return {p.x, p.y, p.z, r.x, r.y, r.z};
  }

  //! Damped step clamped to the limits. A joint that stands at a limit and would leave it is taken out
  //! and the step solved again, so that the others do its work.
  void step(double damping, double* q_new) {
    bool is_free[kMaxJoints];
    std::fill(is_free, is_free + n_, true);
    for (n_pressed_ = 0;;) {
      const int n_before = n_pressed_;
      damped_step(damping, is_free, q_new);
      for (int j = 0; j < n_; ++j) {
        const bool presses = (q_[j] <= problem_.lower[j] && q_new[j] < q_[j]) ||
                             (q_[j] >= problem_.upper[j] && q_new[j] > q_[j]);
        if (is_free[j] && presses) is_free[j] = false, ++n_pressed_;
      }
      if (n_pressed_ == n_before) break;
    }
    for (int j = 0; j < n_; ++j) q_new[j] = std::clamp(q_new[j], problem_.lower[j], problem_.upper[j]);
  }

  //! q + W^-1 J^T (J W^-1 J^T + damping I)^-1 e over the free joints.
  void damped_step(double damping, const bool* is_free, double* q_new) const {
    double A[6][6] = {};
    for (int j = 0; j < n_; ++j) {
      if (!is_free[j]) continue;
      for (int a = 0; a < 6; ++a) {
        const double scaled = J_[a * n_ + j] / problem_.weights[j];
        for (int b = 0; b <= a; ++b) A[a][b] += scaled * J_[b * n_ + j];
      }
    }
    for (int a = 0; a < 6; ++a) A[a][a] += damping;
    Vec6 y = error_;
    solve_spd(A, y);
    for (int j = 0; j < n_; ++j) {
      double dq = 0.0;
      for (int a = 0; is_free[j] && a < 6; ++a) dq += J_[a * n_ + j] * y[a];
      q_new[j] = q_[j] + dq / problem_.weights[j];
    }
  }

  const IkProblem& problem_;
  const Pose& target_;
  const int n_;
  double* q_;
  Vec6 error_;
  Pose T_world_tip_;
  Pose frames_[kMaxFrames];
  double J_[6 * kMaxJoints];
  int n_pressed_ = 0;
};

bool are_close(const Configuration& a, const Configuration& b, double distance) {
  for (size_t j = 0; j < a.size(); ++j)
    if (std::abs(a[j] - b[j]) > distance) return false;
  return true;
}

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

IkResult solve(const IkProblem& problem, const Pose& T_world_target, double* q) {
  return Descent(problem, T_world_target, q).run();
}

std::vector<Configuration> solve_all(const IkProblem& problem, const Pose& T_world_target,
                                     const double* seeds, int n_seeds, double distinct) {
  const int n = problem.chain.n();
  std::vector<Configuration> found;
  for (int i = 0; i < n_seeds; ++i) {
    Configuration q(seeds + i * n, seeds + (i + 1) * n);
    if (solve(problem, T_world_target, q.data()) != IkResult::converged) continue;
    const bool is_new = std::none_of(found.begin(), found.end(), [&](const Configuration& other) {
      return are_close(q, other, distinct);
    });
    if (is_new) found.push_back(std::move(q));
  }
  return found;
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
