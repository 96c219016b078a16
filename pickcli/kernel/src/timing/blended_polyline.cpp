#include "timing/blended_polyline.hpp"

#include <algorithm>
#include <cmath>

#include "timing/quintic.hpp"

namespace apc {
namespace {

constexpr double kDensity = 4.0;                  // nodes per half-length of a blend
constexpr double kSame = 1e-6;                    // joint units: what is nearer is one point
const double kPeakThird = 10.0 / std::sqrt(3.0);  // of the smoothstep's second derivative

//! h bump(offset / h) and its derivatives by the offset, up to `highest`: what a blend adds to the corner.
void bumps(double offset, double h, int highest, double* out) {
  const double width = 2.0 * h, u = (offset + h) / width, u2 = u * u, u3 = u2 * u, v = 1.0 - u;
  const bool is_past = offset > 0.0;
  out[0] = width * u3 * u * (2.5 - 3.0 * u + u2) - (is_past ? offset : 0.0);
  if (highest >= 1) out[1] = u3 * (10.0 - 15.0 * u + 6.0 * u2) - (is_past ? 1.0 : 0.0);
  if (highest >= 2) out[2] = 30.0 * u2 * v * v / width;
  if (highest >= 3) out[3] = 60.0 * u * v * (v - u) / (width * width);
}

//! Sorted, without those that differ from a neighbour only by rounding; the largest is kept as it is.
std::vector<double> distinct(std::vector<double> s) {
  std::sort(s.begin(), s.end());
  const double last = s.back(), tolerance = std::min(1e-8, 0.1 * last);
  if (!(last > 0.0)) return {0.0};
  std::vector<double> kept;
  for (std::size_t i = 0; i < s.size(); ++i)
    if ((i == 0 || s[i] - s[i - 1] > tolerance) && s[i] < last - tolerance) kept.push_back(s[i]);
  kept.push_back(last);
  return kept;
}

//! y at x < xs.back(), linear between increasing xs.
double interpolated(double x, const std::vector<double>& xs, const std::vector<double>& ys) {
  const std::size_t i = static_cast<std::size_t>(std::upper_bound(xs.begin(), xs.end(), x) - xs.begin()) - 1;
  if (x == xs[i]) return ys[i];
  return (ys[i + 1] - ys[i]) / (xs[i + 1] - xs[i]) * (x - xs[i]) + ys[i];
}

double length_of(const double* v, std::size_t n) {
  double squares = 0.0;
  for (std::size_t j = 0; j < n; ++j) squares += v[j] * v[j];
  return std::sqrt(squares);
}

}  // namespace

BlendedPolyline::BlendedPolyline(PolylineData data)
    : data_(std::move(data)), n_(data_.corners.size() / data_.s.size()) {
  const std::vector<double>&s = data_.s, &h = data_.half_lengths;
  const std::size_t K = s.size();
  starts_.resize(K);
  ends_.resize(K);
  for (std::size_t k = 0; k < K; ++k) ends_[k] = k == 0 ? s[k] + h[k] : std::max(ends_[k - 1], s[k] + h[k]);
  for (std::size_t k = K; k-- > 0;)
    starts_[k] = k + 1 == K ? s[k] - h[k] : std::min(starts_[k + 1], s[k] - h[k]);
}

BlendedPolyline::Corners BlendedPolyline::near(double start, double end) const {
  const auto first = std::lower_bound(ends_.begin(), ends_.end(), start) - ends_.begin();
  const auto last = std::upper_bound(starts_.begin(), starts_.end(), end) - starts_.begin();
  return {static_cast<std::size_t>(first), static_cast<std::size_t>(last)};
}

std::size_t BlendedPolyline::edge_of(double s) const {
  if (data_.s.size() <= 2) return 0;
  return static_cast<std::size_t>(std::upper_bound(data_.s.begin() + 1, data_.s.end() - 1, s) -
                                  (data_.s.begin() + 1));
}

std::vector<double> BlendedPolyline::knots() const {
  const std::vector<double>&s = data_.s, &h = data_.half_lengths;
  std::vector<double> found{0.0, length()};
  std::vector<std::size_t> blends;
  for (std::size_t k = 0; k < s.size(); ++k) {
    if (h[k] > 0.0)
      blends.push_back(k);
    else if (k > 0 && k + 1 < s.size())
      found.push_back(s[k]);
  }
  // Blends that overlap or touch are one cluster; a later, longer one may reach back over several.
  for (std::size_t i = 0, first = 0; i < blends.size(); ++i) {
    if (i + 1 < blends.size() && starts_[blends[i + 1]] <= ends_[blends[i]] + kSame) continue;
    add_nodes(blends[first], blends[i], found);
    first = i + 1;
  }
  return distinct(std::move(found));
}

//! Nodes of one cluster: kDensity or more per half-length of the shortest blend there.
void BlendedPolyline::add_nodes(std::size_t first, std::size_t last, std::vector<double>& out) const {
  if (first == last) {
    for (int i = 0; i <= 2 * kDensity; ++i)
      out.push_back(data_.s[first] + data_.half_lengths[first] * (i / kDensity - 1.0));
    return;
  }
  std::vector<double> marks;
  for (std::size_t k = first; k <= last; ++k) {
    const double s = data_.s[k], h = data_.half_lengths[k];
    if (h > 0.0) marks.insert(marks.end(), {s - h, s - h / 2, s, s + h / 2, s + h});
  }
  std::sort(marks.begin(), marks.end());
  marks.erase(std::unique(marks.begin(), marks.end()), marks.end());
  std::vector<double> count{0.0};  // of nodes, up to each mark
  for (std::size_t i = 0; i + 1 < marks.size(); ++i) {
    const double middle = (marks[i + 1] + marks[i]) / 2;
    double density = 0.0;
    for (std::size_t k = first; k <= last; ++k)
      if (std::abs(middle - data_.s[k]) < data_.half_lengths[k])
        density = std::max(density, 1.0 / data_.half_lengths[k]);
    count.push_back(count.back() + density * kDensity * (marks[i + 1] - marks[i]));
  }
  const int n = std::max(static_cast<int>(std::ceil(count.back() - 1e-6)), 2);
  const double step = count.back() / n;
  for (int i = 0; i < n; ++i) out.push_back(interpolated(i * step, count, marks));
  out.push_back(marks.back());
}

void BlendedPolyline::evaluate(const double* s, std::size_t M, int highest, double* out) const {
  const std::size_t size = M * n_;
  std::fill(out, out + size * static_cast<std::size_t>(highest + 1), 0.0);
  for (std::size_t i = 0; i < M; ++i) {
    const double at = std::clamp(s[i], 0.0, length());
    const std::size_t edge = edge_of(at);
    double* q = out + i * n_;
    const auto [first, last] = near(at, at);
    for (std::size_t k = first; k < last; ++k) {
      const double offset = at - data_.s[k];
      if (!(std::abs(offset) < data_.half_lengths[k])) continue;
      double weights[4];
      bumps(offset, data_.half_lengths[k], highest, weights);
      for (int d = 0; d <= highest; ++d)
        for (std::size_t j = 0; j < n_; ++j)
          q[static_cast<std::size_t>(d) * size + j] += weights[d] * turn(k)[j];
    }
    for (std::size_t j = 0; j < n_; ++j) {
      q[j] += data_.corners[edge * n_ + j] + direction(edge)[j] * (at - data_.s[edge]);
      if (highest >= 1) q[size + j] += direction(edge)[j];
    }
  }
}

void BlendedPolyline::are_lines(const double* start, const double* end, std::size_t M, bool* out) const {
  for (std::size_t i = 0; i < M; ++i) {
    const double middle = (start[i] + end[i]) / 2;
    const auto [first, last] = near(middle, middle);
    out[i] = true;
    for (std::size_t k = first; k < last; ++k)
      out[i] = out[i] && std::abs(middle - data_.s[k]) >= data_.half_lengths[k];
  }
}

void BlendedPolyline::bound_second(const double* start, const double* end, std::size_t M, double* out) const {
  std::fill(out, out + M * n_, 0.0);
  for (std::size_t i = 0; i < M; ++i) {
    const auto [first, last] = near(start[i], end[i]);
    for (std::size_t k = first; k < last; ++k) {
      if (!(data_.half_lengths[k] > 0.0)) continue;
      const double h = std::max(data_.half_lengths[k], kSame),
                   nearest = std::clamp(data_.s[k], start[i], end[i]);
      const double x = std::min(std::abs(nearest - data_.s[k]) / h, 1.0), left = 1.0 - x * x;
      const double weight = 15.0 / 16.0 * left * left / h;
      for (std::size_t j = 0; j < n_; ++j) out[i * n_ + j] += weight * std::abs(turn(k)[j]);
    }
  }
}

void BlendedPolyline::bound_third(const double* start, const double* end, std::size_t M, double* out) const {
  std::fill(out, out + M * n_, 0.0);
  for (std::size_t i = 0; i < M; ++i) {
    const auto [first, last] = near(start[i], end[i]);
    for (std::size_t k = first; k < last; ++k) {
      const double nearest = std::clamp(data_.s[k], start[i], end[i]);
      if (!(std::abs(nearest - data_.s[k]) < data_.half_lengths[k])) continue;
      const double width = std::max(2.0 * data_.half_lengths[k], kSame),
                   weight = kPeakThird / (width * width);
      for (std::size_t j = 0; j < n_; ++j) out[i * n_ + j] += weight * std::abs(turn(k)[j]);
    }
  }
}

void BlendedPolyline::bound_deviation(const double* start, const double* end, std::size_t M,
                                      double* out) const {
  for (std::size_t i = 0; i < M; ++i) {
    out[i] = 0.0;
    const auto [first, last] = near(start[i], end[i]);
    for (std::size_t k = first; k < last; ++k) {
      const double offset = std::clamp(data_.s[k], start[i], end[i]) - data_.s[k];
      if (!(std::abs(offset) < data_.half_lengths[k])) continue;
      double bump;
      bumps(offset, data_.half_lengths[k], 0, &bump);
      out[i] += bump * length_of(turn(k), n_);
    }
  }
}

void needed_time_scale(const BlendedPolyline& curve, const Pace& pace, const JointLimits& limits,
                       const double* scale, double* out) {
  const std::size_t n = curve.n(), size = pace.K * n;
  std::vector<double> states(3 * size);
  curve.evaluate(pace.s, pace.K, 2, states.data());
  const auto state = [&](std::size_t i, std::size_t j) {
    const double q = states[i * n + j], dq = states[size + i * n + j], ddq = states[2 * size + i * n + j];
    const double ds = pace.ds[i];
    return JointState{q, dq * ds, ddq * (ds * ds) + dq * pace.dds[i]};
  };
  for (std::size_t i = 0; i + 1 < pace.K; ++i) {
    Peaks share{scale[i], scale[i], scale[i]};  // of the limits, the most of all joints
    for (std::size_t j = 0; j < n; ++j) {
      const Peaks floor{share.velocity * limits.velocity[j], share.acceleration * limits.acceleration[j],
                        share.jerk * limits.jerk[j]};
      const Peaks peaks = quintic_peaks(state(i, j), state(i + 1, j), pace.t[i + 1] - pace.t[i], floor);
      share.velocity = std::max(share.velocity, peaks.velocity / limits.velocity[j]);
      share.acceleration = std::max(share.acceleration, peaks.acceleration / limits.acceleration[j]);
      share.jerk = std::max(share.jerk, peaks.jerk / limits.jerk[j]);
    }
    out[i] = std::max({share.velocity / scale[i], std::sqrt(share.acceleration / scale[i]),
                       std::cbrt(share.jerk / scale[i])});
  }
}

}  // namespace apc
