#include "kinematics/ik.hpp"

#include <algorithm>
#include <cmath>

#include "kinematics/spd6.hpp"

namespace apc {
namespace {

double squared(const Vec6& e) {
  double sum = 0.0;
  for (double v : e) sum += v * v;
  return sum;
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

}  // namespace

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

}  // namespace apc
