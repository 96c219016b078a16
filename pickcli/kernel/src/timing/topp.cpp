#include "timing/topp.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace apc {
namespace {

constexpr double kTiny = 1e-9;
constexpr double kSamePoint = 1e-12;  //!< of the path's length

//! |u - slope x| <= width, x at the start of the interval.
struct Strip {
  double slope, width;
};

class Passes {
 public:
  explicit Passes(const PathGrid& grid) : grid_(grid), strips_((grid.M - 1) * 2 * grid.n), x_(grid.M) {
    for (std::size_t i = 0; i + 1 < grid.M; ++i) make_strips(i);
    for (std::size_t i = 0; i < grid.M; ++i) x_[i] = highest(i);
    x_.front() = x_.back() = 0.0;
    backward();
    forward();
  }

  double x(std::size_t i) const { return x_[i]; }

  //! Half-width of the narrowest strip: the acceleration along a line.
  double narrowest(std::size_t i) const {
    double least = std::numeric_limits<double>::infinity();
    for (const Strip* k = begin(i); k != end(i); ++k) least = std::min(least, k->width);
    return least;
  }

 private:
  const Strip* begin(std::size_t i) const { return &strips_[2 * grid_.n * i]; }
  const Strip* end(std::size_t i) const { return begin(i) + 2 * grid_.n; }
  double step(std::size_t i) const { return 2.0 * (grid_.s[i + 1] - grid_.s[i]); }

  //! The limits at the interval's start, and those at its end, where x is x_i + step u.
  void make_strips(std::size_t i) {
    const std::size_t n = grid_.n;
    for (std::size_t j = 0; j < n; ++j) {
      const std::size_t at = i * n + j, after = at + n;
      const double limit = grid_.acceleration[at];
      strips_[2 * n * i + j] = strip(grid_.dq[at], grid_.ddq[at], limit);
      strips_[2 * n * i + n + j] =
          strip(grid_.dq[after] + step(i) * grid_.ddq[after], grid_.ddq[after], limit);
    }
  }

  //! |a u + b x| <= c
  static Strip strip(double a, double b, double c) {
    if (std::abs(a) < kTiny) a = kTiny;
    return {-b / a, c / std::abs(a)};
  }

  //! Largest x that any u can sustain at gridpoint i, speed limit included.
  double highest(std::size_t i) const {
    const double x = grid_.speed[i] * grid_.speed[i];
    if (i + 1 == grid_.M || grid_.is_line[i]) return x;
    // Two strips meet up to x = (c + c') / (m - m').
    double parting = kTiny;
    for (const Strip* a = begin(i); a != end(i); ++a)
      for (const Strip* b = begin(i); b != end(i); ++b)
        parting = std::max(parting, (a->slope - b->slope) / (a->width + b->width));
    return std::min(x, 1.0 / parting);
  }

  //! x becomes the upper ends of the controllable sets: from there the end can still be reached at rest.
  void backward() {
    for (std::size_t i = grid_.M - 1; i-- > 0;) {
      const double after = x_[i + 1], ds = step(i);
      for (const Strip* k = begin(i); k != end(i); ++k)
        x_[i] = std::min(x_[i], (after + ds * k->width) / std::max(1.0 + ds * k->slope, kTiny));
    }
  }

  //! x becomes the fastest: always the largest acceleration that stays controllable.
  void forward() {
    for (std::size_t i = 0; i + 1 < grid_.M; ++i) {
      double gain = std::numeric_limits<double>::infinity();
      for (const Strip* k = begin(i); k != end(i); ++k) gain = std::min(gain, k->width + k->slope * x_[i]);
      x_[i + 1] = std::max(std::min(x_[i + 1], x_[i] + step(i) * gain), 0.0);
    }
  }

  const PathGrid& grid_;
  std::vector<Strip> strips_;  //!< (M-1, 2n)
  std::vector<double> x_;      //!< (M,)
};

//! Points in time; one that lies where the one before it lies is left out, but the last stays.
class Points {
 public:
  explicit Points(double length) : same_(kSamePoint * length) {}

  void add(double s, double v) {
    if (out_.s.empty() || s - out_.s.back() > same_) push(s, v);
  }

  PaceProfile ended(double s, double v) {
    if (out_.s.size() > 1 && s - out_.s.back() <= same_) pop();
    push(s, v);
    return std::move(out_);
  }

 private:
  void push(double s, double v) {
    const bool is_first = out_.s.empty();
    const double dt = is_first ? 0.0 : 2.0 * (s - out_.s.back()) / std::max(v + out_.v.back(), 1e-12);
    out_.t.push_back(is_first ? 0.0 : out_.t.back() + dt);
    out_.s.push_back(s);
    out_.v.push_back(v);
  }

  void pop() {
    for (std::vector<double>* values : {&out_.t, &out_.s, &out_.v}) values->pop_back();
  }

  double same_;
  PaceProfile out_;
};

//! Square of the fastest cruise on line i: reached and left with acceleration u and kept for grid.cruise.
//! Distance = (v^2 - x0) / 2u + (v^2 - x1) / 2u + v cruise, solved for v.
double cruise_squared(const PathGrid& grid, std::size_t i, double x0, double x1, double u) {
  const double half = u * grid.cruise / 2.0;
  const double v = std::sqrt(half * half + u * (grid.s[i + 1] - grid.s[i]) + (x0 + x1) / 2.0) - half;
  const double allowed = std::min(v, grid.line_speed[i]);
  return std::max(allowed * allowed, std::max(x0, x1));
}

}  // namespace

PaceProfile fastest_pace(const PathGrid& grid) {
  const Passes passes(grid);
  const std::size_t last = grid.M - 1;
  Points points(grid.s[last]);
  for (std::size_t i = 0; i < last; ++i) {
    const double x0 = passes.x(i), x1 = passes.x(i + 1), end = grid.s[i + 1];
    points.add(grid.s[i], std::sqrt(x0));
    if (!grid.is_line[i]) continue;
    const double u = passes.narrowest(i), peak = cruise_squared(grid, i, x0, x1, u);
    const double rise = std::min(grid.s[i] + (peak - x0) / (2.0 * u), end);
    const double fall = std::max(end - (peak - x1) / (2.0 * u), rise);
    points.add(rise, std::sqrt(peak));
    points.add(fall, std::sqrt(peak));
  }
  return points.ended(grid.s[last], std::sqrt(passes.x(last)));
}

SmoothPace smoothed(const double* t, const double* s, const double* v, std::size_t P, double step,
                    std::size_t n_window) {
  const double duration = t[P - 1], window = static_cast<double>(n_window);
  const std::size_t n_cells = static_cast<std::size_t>(std::max(std::ceil(duration / step - 1e-9), 1.0));
  std::vector<double> speed(n_cells + 2 * (n_window + 1), 0.0);  // mean of each cell, taken at its middle
  double before = 0.0;
  for (std::size_t i = 0, at = 0; i <= n_cells; ++i) {
    const double now = std::min(step * static_cast<double>(i), duration);
    while (at + 2 < P && t[at + 1] <= now) ++at;
    const double dt = now - t[at], slope = (v[at + 1] - v[at]) / (t[at + 1] - t[at]);
    const double position = s[at] + dt * (v[at] + 0.5 * slope * dt);
    if (i > 0) speed[n_window + i] = (position - before) / step;
    before = position;
  }
  std::vector<double> total(speed.size(), 0.0);
  for (std::size_t i = 1; i < total.size(); ++i) total[i] = total[i - 1] + (speed[i] + speed[i - 1]) / 2;
  const std::size_t K = speed.size() - n_window;
  SmoothPace pace{std::vector<double>(K, 0.0), std::vector<double>(K, 0.0), std::vector<double>(K, 0.0)};
  for (std::size_t i = 1; i + 1 < K; ++i) {
    pace.ds[i] = std::max(total[i + n_window] - total[i], 0.0) / window;
    pace.dds[i] = (speed[i + n_window] - speed[i]) / (window * step);
  }
  for (std::size_t i = 1; i < K; ++i) {
    const double gained =
        step * pace.ds[i - 1] + step * step * (pace.dds[i - 1] / 3 + pace.dds[i] / 6);
    pace.s[i] = pace.s[i - 1] + std::max(gained, 0.0);
  }
  const double rounding = s[P - 1] / pace.s.back();
  for (double& value : pace.s) value *= rounding;
  return pace;
}

}  // namespace apc
