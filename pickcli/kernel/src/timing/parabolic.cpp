#include "timing/parabolic.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace apc {
namespace {

constexpr double kRounding = 1e-9;  //!< relative: how far beyond a limit rounding may lead
constexpr double kNothing = 1e-12;  //!< m or rad, per s: what counts as none
constexpr int kWindows = 6;         //!< of averaging that are tried, from a pause to two

//! Ticks added in turn to the least time of the slowest joint where another joint has no segment just then:
//! because of the rounding to ticks, or as it would have to wait and cannot (Hauser and Ng-Thow-Hing 2010,
//! III-C).
constexpr int kExtra[] = {0, 1, 2, 4, 8, 16, 32};

//! Rounded up to whole ticks, but for rounding errors.
double ticks_up(double t) { return std::ceil(t / kTick - 1e-6) * kTick; }

//! Whole ticks for a change of speed: at least one where the speed changes.
double ramp_time(double change, double acceleration) {
  change = std::abs(change);
  return std::max(ticks_up(change / acceleration), change > kNothing ? kTick : 0.0);
}

//! One joint between two velocities, over a distance.
struct Way {
  double d, v0, v1;
};

//! Of one joint.
struct Limit {
  double velocity, acceleration, pause;
};

Limit limit_of(const ParabolicLimits& limits, std::size_t j) {
  return {limits.velocity[j], limits.acceleration[j], limits.pause};
}

//! Time that a joint needs alone, with full ramps and the pause in between.
double least_time(Way way, const Limit& limit) {
  const double a = limit.acceleration;
  // What a single ramp from v0 to v1 leaves.
  const double beyond = way.d - (way.v0 + way.v1) / 2 * std::abs(way.v1 - way.v0) / a;
  const double sign = beyond < 0.0 ? -1.0 : 1.0;
  const double d = sign * way.d, v0 = sign * way.v0, v1 = sign * way.v1;
  const double half = a * limit.pause / 2;
  double peak = std::sqrt(std::max(half * half + a * d + (v0 * v0 + v1 * v1) / 2, 0.0)) - half;
  peak = std::min(std::max(peak, std::max(v0, v1)), limit.velocity);
  const double cruised = d - (2 * peak * peak - v0 * v0 - v1 * v1) / (2 * a);
  const double cruise = std::abs(peak) > kNothing ? cruised / peak : 0.0;
  return (2 * peak - v0 - v1) / a + std::max(cruise, 0.0);
}

//! A speed between two ramps, and whether that keeps the limits.
struct Cruise {
  double speed, up, down;
  bool is_good;
};

//! With a share of the acceleration. The distance grows with the speed in between, so there is one speed for
//! every distance: linear where it lies between v0 and v1, else the root of a quadratic, and linear again once
//! ramps are rounded to ticks.
Cruise cruise_with(const Way& way, const Limit& limit, double share, double duration, double pause) {
  const auto [d, v0, v1] = way;
  const double a = share * limit.acceleration;
  const double ramp = std::abs(v1 - v0) / a, total = v0 + v1;
  const double between = (d - total / 2 * ramp) / std::max(duration - ramp, kNothing);
  const double faster = std::max(v0, v1), slower = std::min(v0, v1);
  const double sign = between > faster ? 1.0 : -1.0;
  const double b = duration + sign * total / a;
  const double root = b * b - 4 / a * ((v0 * v0 + v1 * v1) / (2 * a) + sign * d);
  const bool is_between = between <= faster && between >= slower;
  double speed = is_between ? between : sign * a / 2 * (b - std::sqrt(std::max(root, 0.0)));
  double up = 0.0, down = 0.0;
  for (int i = 0; i < 2; ++i) {
    up = ramp_time(speed - v0, a);
    down = ramp_time(v1 - speed, a);
    speed = (d - (v0 * up + v1 * down) / 2) / std::max(duration - (up + down) / 2, kTick);
  }
  const double first = speed - v0, last = v1 - speed, cruise = duration - up - down;
  const double slack = kRounding * limit.velocity;
  const auto is_kept = [&](double change, double time) {
    return std::abs(change) <= a * time + (time > 0.0 ? slack : 0.0) + kNothing;
  };
  return {speed, up, down,
          is_kept(first, up) && is_kept(last, down) && std::abs(speed) <= limit.velocity + slack &&
              cruise >= (first * last < 0.0 ? pause : 0.0) - kTick / 2};
}

//! With half of the acceleration where a joint can, else with all of it. With half, no jerk limit minds a ramp up
//! next to a ramp down; and it is calmer.
Cruise calm_cruise(const Way& way, const Limit& limit, double duration) {
  const Cruise calm = cruise_with(way, limit, 0.5, duration, 0.0);
  return calm.is_good ? calm : cruise_with(way, limit, 1.0, duration, limit.pause);
}

Ramps ramps_of(double q0, const Way& way, const Cruise& cruise) {
  return {q0, way.v0, cruise.speed, way.v1, cruise.up, cruise.down};
}

//! The whole number nearest to it, of two the even one.
int nearest_int(double x) { return static_cast<int>(std::nearbyint(x)); }

}  // namespace

ParabolicSegment::ParabolicSegment(std::vector<Ramps> joints, double duration)
    : joints_(std::move(joints)), duration_(duration) {
  constexpr double inf = std::numeric_limits<double>::infinity();
  for (Ramps& joint : joints_) {
    joint.first = (joint.speed - joint.v0) / (joint.up > 0.0 ? joint.up : inf);
    joint.last = (joint.v1 - joint.speed) / (joint.down > 0.0 ? joint.down : inf);
  }
}

void ParabolicSegment::evaluate(double t, double* q, double* v) const {
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    const Ramps& r = joints_[j];
    const double x = std::min(t, r.up), z = std::max(t - (duration_ - r.down), 0.0);
    const double missing = r.v0 - r.speed;
    q[j] = r.q0 + r.speed * t + x * (missing + r.first * x / 2) + r.last * z * z / 2;
    if (v) v[j] = r.speed + missing + r.first * x + r.last * z;
  }
}

MotionState ParabolicSegment::state(double t) const {
  MotionState state{std::vector<double>(n()), std::vector<double>(n())};
  evaluate(t, state.q.data(), state.v.data());
  return state;
}

double ParabolicSegment::acceleration(std::size_t joint, double t) const {
  const Ramps& r = joints_[joint];
  return (t < r.up ? r.first : 0.0) + (t > duration_ - r.down ? r.last : 0.0);
}

ParabolicSegment ParabolicSegment::part(double start, double end) const {
  const MotionState here = state(start), there = state(end);
  std::vector<Ramps> joints;
  joints.reserve(n());
  for (std::size_t j = 0; j < n(); ++j) {
    const Ramps& r = joints_[j];
    const double brakes = duration_ - r.down;
    const double up = std::clamp(r.up, start, end) - start, down = end - std::clamp(brakes, start, end);
    double speed = r.up > end ? there.v[j] : r.speed;
    if (brakes < start) speed = here.v[j];
    joints.push_back({here.q[j], here.v[j], speed, there.v[j], up, down});
  }
  return {std::move(joints), end - start};
}

std::optional<ParabolicSegment> steer_fixed_time(const MotionState& start, const MotionState& end,
                                                 const ParabolicLimits& limits, double duration) {
  std::vector<Ramps> joints;
  joints.reserve(start.q.size());
  for (std::size_t j = 0; j < start.q.size(); ++j) {
    const Way way{end.q[j] - start.q[j], start.v[j], end.v[j]};
    const Cruise cruise = calm_cruise(way, limit_of(limits, j), duration);
    if (!cruise.is_good) return std::nullopt;
    joints.push_back(ramps_of(start.q[j], way, cruise));
  }
  return ParabolicSegment(std::move(joints), duration);
}

std::optional<ParabolicSegment> steer_min_time(const MotionState& start, const MotionState& end,
                                               const ParabolicLimits& limits, double at_most) {
  double slowest = 0.0;
  for (std::size_t j = 0; j < start.q.size(); ++j)
    slowest = std::max(
        slowest, least_time({end.q[j] - start.q[j], start.v[j], end.v[j]}, limit_of(limits, j)));
  const double least = std::max(ticks_up(slowest), kTick);
  for (int extra : kExtra) {
    const double duration = least + extra * kTick;
    if (duration > at_most + kTick / 2) return std::nullopt;
    if (auto segment = steer_fixed_time(start, end, limits, duration)) return segment;
  }
  return std::nullopt;
}

std::optional<std::pair<ParabolicSegment, ParabolicSegment>> steer_via(
    const MotionState& start, const std::vector<const MotionState*>& middles, const MotionState& end,
    const ParabolicLimits& limits, double there, double back) {
  std::vector<Ramps> first, last;
  for (std::size_t j = 0; j < start.q.size(); ++j) {
    const Limit limit = limit_of(limits, j);
    for (const MotionState* middle : middles) {
      const Way out{middle->q[j] - start.q[j], start.v[j], middle->v[j]};
      const Way on{end.q[j] - middle->q[j], middle->v[j], end.v[j]};
      const Cruise a = calm_cruise(out, limit, there);
      if (!a.is_good) continue;
      const Cruise b = calm_cruise(on, limit, back);
      if (!b.is_good) continue;
      first.push_back(ramps_of(start.q[j], out, a));
      last.push_back(ramps_of(middle->q[j], on, b));
      break;
    }
    if (first.size() != j + 1) return std::nullopt;
  }
  return std::pair(ParabolicSegment(std::move(first), there), ParabolicSegment(std::move(last), back));
}

Tube tube(const Segments& segments, double step) {
  Tube out;
  const std::size_t n = segments.front().n();
  std::vector<double> q(n);
  for (std::size_t s = 0; s < segments.size(); ++s) {
    const ParabolicSegment& segment = segments[s];
    const int n_chords = static_cast<int>(std::ceil(segment.duration() / step - 1e-9));
    const double h = segment.duration() / n_chords;
    const auto time = [&](int i) { return i < n_chords ? i * h : segment.duration(); };
    for (int i = 0; i < n_chords; ++i) {
      const double from = time(i), to = time(i + 1);
      segment.evaluate(from, q.data(), nullptr);
      out.Q.insert(out.Q.end(), q.begin(), q.end());
      for (const Ramps& r : segment.joints()) {
        const double bend = std::max(from < r.up ? std::abs(r.first) : 0.0,
                                     to > segment.duration() - r.down ? std::abs(r.last) : 0.0);
        out.slack.push_back(bend * (time(1) * time(1)) / 8);
      }
    }
  }
  segments.back().evaluate(segments.back().duration(), q.data(), nullptr);
  out.Q.insert(out.Q.end(), q.begin(), q.end());
  return out;
}

std::vector<double> positions(const Segments& segments, const double* t, std::size_t M) {
  const std::size_t n = segments.front().n();
  std::vector<double> out(M * n);
  std::size_t k = 0;
  double end = segments.front().duration();
  for (std::size_t i = 0; i < M; ++i) {
    while (k + 1 < segments.size() && t[i] >= end) end += segments[++k].duration();
    segments[k].evaluate(t[i] - (end - segments[k].duration()), &out[i * n], nullptr);
  }
  return out;
}

std::vector<double> accelerations(const Segments& segments) {
  std::vector<double> out;
  for (const ParabolicSegment& segment : segments)
    for (int i = 0, K = nearest_int(segment.duration() / kTick); i < K; ++i)
      for (std::size_t j = 0; j < segment.n(); ++j)
        out.push_back(segment.acceleration(j, kTick * (i + 0.5)));
  return out;
}

double jerk_window(const Segments& segments, const ParabolicLimits& limits) {
  const std::size_t n = segments.front().n();
  const int ticks = nearest_int(limits.pause / kTick);
  bool is_short_enough = true;
  for (std::size_t j = 0; j < n; ++j)
    is_short_enough =
        is_short_enough &&
        2 * limits.acceleration[j] <= limits.jerk[j] * limits.pause * (1.0 + kRounding);
  if (is_short_enough) return ticks * kTick;
  std::vector<double> a(2 * static_cast<std::size_t>(ticks) * n, 0.0);  // at rest before
  const std::vector<double> moving = accelerations(segments);
  a.insert(a.end(), moving.begin(), moving.end());
  a.resize(a.size() + 2 * static_cast<std::size_t>(ticks) * n, 0.0);  // and after
  const auto keeps = [&](int window) {
    const std::size_t apart = static_cast<std::size_t>(window) * n;
    std::vector<double> most(n);
    for (std::size_t j = 0; j < n; ++j) most[j] = limits.jerk[j] * (window * kTick * (1.0 + kRounding));
    for (std::size_t i = 0; i + apart < a.size(); i += n)
      for (std::size_t j = 0; j < n; ++j)
        if (!(std::abs(a[i + j + apart] - a[i + j]) <= most[j])) return false;
    return true;
  };
  int window = ticks;
  for (int i = 0; i < kWindows; ++i) {
    const double even = i * (static_cast<double>(ticks) / (kWindows - 1)) + ticks;
    window = i + 1 < kWindows ? nearest_int(even) : 2 * ticks;
    if (keeps(window)) break;
  }
  return window * kTick;
}

ParabolicTrajectory::ParabolicTrajectory(Segments segments) : segments_(std::move(segments)), starts_{0.0} {
  double so_far = 0.0;
  for (const ParabolicSegment& segment : segments_) {
    so_far += segment.duration();
    starts_.push_back(std::nearbyint(so_far / kTick) * kTick);
  }
}

MotionState ParabolicTrajectory::state(double t) const {
  const auto after = std::upper_bound(starts_.begin(), starts_.end(), t) - starts_.begin();
  const std::size_t k = static_cast<std::size_t>(
      std::clamp<std::ptrdiff_t>(after - 1, 0, static_cast<std::ptrdiff_t>(segments_.size()) - 1));
  return segments_[k].state(t - starts_[k]);
}

Segments ParabolicTrajectory::between(double start, double end) const {
  Segments parts;
  for (std::size_t k = 0; k < segments_.size(); ++k) {
    const double duration = segments_[k].duration();
    const double low = std::max(start - starts_[k], 0.0), high = std::min(end - starts_[k], duration);
    if (!(high - low > kTick / 2)) continue;
    const bool is_whole = low < kTick / 2 && high > duration - kTick / 2;
    parts.push_back(is_whole ? segments_[k] : segments_[k].part(low, high));
  }
  return parts;
}

ParabolicTrajectory ParabolicTrajectory::replaced(double start, double end, const Segments& segments) const {
  Segments all = between(0.0, start);
  all.insert(all.end(), segments.begin(), segments.end());
  for (ParabolicSegment& segment : between(end, duration())) all.push_back(std::move(segment));
  return ParabolicTrajectory(std::move(all));
}

}  // namespace apc
