#include "kinematics/resolved_rate.hpp"

#include <algorithm>
#include <cmath>

namespace apc {

void ResolvedRate::place(const double* q) {
  chain_.fk(q, frames_);
  tip_ = frames_[chain_.n_frames() - 1] * T_last_tip_;
  chain_.jacobian(frames_, tip_.p, J_);
}

void ResolvedRate::add_least(Vec6 twist, double* dq) const {
  const int n = chain_.n();
  double A[6][6] = {};
  for (int j = 0; j < n; ++j) {
    const double weight = velocity_[j] * velocity_[j];
    for (int a = 0; a < 6; ++a) {
      const double scaled = weight * J_[a * n + j];
      for (int b = 0; b <= a; ++b) A[a][b] += scaled * J_[b * n + j];
    }
  }
  solve_spd(A, twist);
  for (int j = 0; j < n; ++j) {
    double along = 0.0;
    for (int a = 0; a < 6; ++a) along += J_[a * n + j] * twist[static_cast<std::size_t>(a)];
    dq[j] += velocity_[j] * velocity_[j] * along;
  }
}

void ResolvedRate::rate(const double* q, const double* own, const double* twist, double* dq) {
  const int n = chain_.n();
  place(q);
  Vec6 missing;
  for (int a = 0; a < 6; ++a) {
    double sum = twist[a];
    for (int j = 0; j < n; ++j) sum -= J_[a * n + j] * own[j];
    missing[static_cast<std::size_t>(a)] = sum;
  }
  std::copy(own, own + n, dq);
  add_least(missing, dq);
}

void ResolvedRate::correct(const Pose& T_world_tip, double* q) {
  place(q);
  const Vec3 p = T_world_tip.p - tip_.p, r = rotation_vector(T_world_tip.R * transposed(tip_.R));
  add_least({p.x, p.y, p.z, r.x, r.y, r.z}, q);
}

namespace {

//! One step of h s from q (n,) to q_next (n,), h negative for one back; its mean rate (n,) is left in rate.
void step(ResolvedRate& arm, const WantedMotion& wanted, int here, int there, const double* q, double* q_next,
          double* rate) {
  const int n = arm.n(), between = std::min(here, there);
  const double h = wanted.times[static_cast<std::size_t>(there)] - wanted.times[static_cast<std::size_t>(here)];
  const double *own = wanted.own_between + between * n, *twist = wanted.twists_between + between * 6;
  double first[kMaxJoints], second[kMaxJoints], third[kMaxJoints], last[kMaxJoints], moved[kMaxJoints];
  const auto move = [&](const double* by, double time) {
    for (int j = 0; j < n; ++j) moved[j] = q[j] + time * by[j];
  };
  arm.rate(q, wanted.own + here * n, wanted.twists + here * 6, first);
  move(first, h / 2.0);
  arm.rate(moved, own, twist, second);
  move(second, h / 2.0);
  arm.rate(moved, own, twist, third);
  move(third, h);
  arm.rate(moved, wanted.own + there * n, wanted.twists + there * 6, last);
  for (int j = 0; j < n; ++j) {
    rate[j] = (first[j] + 2.0 * second[j] + 2.0 * third[j] + last[j]) / 6.0;
    q_next[j] = q[j] + h * rate[j];
  }
}

}  // namespace

TrackedPath track(ResolvedRate& arm, const double* velocity, const WantedMotion& wanted, int met,
                  const double* q_met, const TrackLimits& limits) {
  const int n = arm.n(), N = static_cast<int>(wanted.times.size());
  TrackedPath path;
  path.Q.assign(static_cast<std::size_t>(N * n), 0.0);
  std::copy(q_met, q_met + n, &path.Q[static_cast<std::size_t>(met * n)]);
  double rate[kMaxJoints];
  for (const int way : {1, -1}) {
    for (int here = met; way > 0 ? here < N - 1 : here > 0; here += way) {
      const int there = here + way;
      double* q = &path.Q[static_cast<std::size_t>(there * n)];
      step(arm, wanted, here, there, &path.Q[static_cast<std::size_t>(here * n)], q, rate);
      for (int j = 0; j < n; ++j)  // not finite: singular, too
        if (!(std::abs(rate[j]) <= limits.fastest * velocity[j])) path.end = TrackEnd::singular;
      path.at = there;
      if (path.end != TrackEnd::done) return path;
      arm.correct(wanted.poses[static_cast<std::size_t>(there)], q);
      double farthest = 0.0;
      for (int j = 0; j < n; ++j) {
        const double beyond = std::max(limits.lower[j] - q[j], q[j] - limits.upper[j]);
        if (!(beyond <= farthest)) farthest = beyond, path.joint = j, path.end = TrackEnd::limit;
      }
      if (path.end != TrackEnd::done) return path;
    }
  }
  return path;
}

}  // namespace apc
