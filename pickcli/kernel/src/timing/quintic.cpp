#include "timing/quintic.hpp"

#include <algorithm>
#include <cmath>

namespace apc {
namespace {

double largest(double a, double b) { return std::max(std::abs(a), std::abs(b)); }

constexpr double kSurely = 1.0 + 1e-9;  // above rounding

//! Whether a polynomial stays below a floor on [0, 1], by its Bernstein coefficients.
template <int N>
bool is_below(const double (&b)[N], double floor) {
  double hull = 0.0;
  for (double coefficient : b) hull = std::max(hull, std::abs(coefficient));
  return hull * kSurely < floor;
}

//! Bound of |c0 + .. + c4 u^4| on [0, 1] by its Bernstein coefficients on both halves.
double quartic_bound(double c0, double c1, double c2, double c3, double c4, double floor) {
  double b[5] = {c0, c0 + c1 / 4, c0 + c1 / 2 + c2 / 6, c0 + 0.75 * c1 + c2 / 2 + c3 / 4,
                 c0 + c1 + c2 + c3 + c4};
  if (is_below(b, floor)) return 0.0;
  double bound = largest(b[0], b[4]);
  // De Casteljau at 1/2: the first and the last of every row are the coefficients on the two halves.
  for (int last = 4; last > 0; --last) {
    for (int i = 0; i < last; ++i) b[i] = (b[i] + b[i + 1]) / 2;
    bound = std::max(bound, largest(b[0], b[last - 1]));
  }
  return bound;
}

//! Largest |c0 + c1 u + c2 u^2| on [0, 1].
double quadratic_peak(double c0, double c1, double c2, double floor) {
  if (is_below({c0, c0 + c1 / 2, c0 + c1 + c2}, floor)) return 0.0;
  const double peak = largest(c0, c0 + c1 + c2);
  const double u = c2 == 0.0 ? 0.0 : std::clamp(-c1 / (2.0 * c2), 0.0, 1.0);
  return std::max(peak, std::abs(c0 + u * (c1 + u * c2)));
}

//! Largest |c0 + .. + c3 u^3| on [0, 1].
double cubic_peak(double c0, double c1, double c2, double c3, double floor) {
  if (is_below({c0, c0 + c1 / 3, c0 + (2 * c1 + c2) / 3, c0 + c1 + c2 + c3}, floor)) return 0.0;
  double peak = largest(c0, c0 + c1 + c2 + c3);
  const double root = std::sqrt(std::max(c2 * c2 - 3.0 * c1 * c3, 0.0));
  const double stable = c2 >= 0.0 ? -(c2 + root) : root - c2;  // the two roots without cancellation
  const auto look = [&](double above, double below) {
    if (below == 0.0) return;
    const double u = std::clamp(above / below, 0.0, 1.0);
    peak = std::max(peak, std::abs(c0 + u * (c1 + u * (c2 + u * c3))));
  };
  look(stable, 3.0 * c3);
  look(c1, stable);
  return peak;
}

//! c1 u + .. + c5 u^5, how far a quintic is from where it starts, u = t / h.
struct Quintic {
  double c1, c2, c3, c4, c5;
};

Quintic quintic_between(const JointState& start, const JointState& end, double h) {
  const double way = end.p - start.p, v0 = start.v * h, v1 = end.v * h, a0 = start.a * h * h,
               a1 = end.a * h * h;
  return {v0, a0 / 2, 10 * way - 6 * v0 - 4 * v1 - 1.5 * a0 + 0.5 * a1,
          -15 * way + 8 * v0 + 7 * v1 + 1.5 * a0 - a1, 6 * way - 3 * v0 - 3 * v1 - 0.5 * a0 + 0.5 * a1};
}

}  // namespace

Peaks quintic_peaks(const JointState& start, const JointState& end, double h, const Peaks& floor) {
  const auto [c1, c2, c3, c4, c5] = quintic_between(start, end, h);
  const double h2 = h * h, h3 = h * h * h;
  return {quartic_bound(c1, 2 * c2, 3 * c3, 4 * c4, 5 * c5, floor.velocity * h) / h,
          cubic_peak(2 * c2, 6 * c3, 12 * c4, 20 * c5, floor.acceleration * h2) / h2,
          quadratic_peak(6 * c3, 24 * c4, 60 * c5, floor.jerk * h3) / h3};
}

void quintic_states(const QuinticPoints& points, const double* t, std::size_t M, int highest, double* out) {
  const std::size_t n = points.n, size = M * n;
  const double *times = points.times, *last = times + points.N - 1;
  for (std::size_t i = 0; i < M; ++i) {
    const double at = std::clamp(t[i], times[0], *last);
    const std::size_t k = static_cast<std::size_t>(std::upper_bound(times + 1, last, at) - times) - 1;
    const double h = times[k + 1] - times[k], u = (at - times[k]) / h;
    for (std::size_t j = 0; j < n; ++j) {
      const std::size_t from = k * n + j, to = from + n;
      const JointState start{points.positions[from], points.velocities[from], points.accelerations[from]};
      const JointState end{points.positions[to], points.velocities[to], points.accelerations[to]};
      const auto [c1, c2, c3, c4, c5] = quintic_between(start, end, h);
      double* state = out + i * n + j;
      state[0] = start.p + u * (c1 + u * (c2 + u * (c3 + u * (c4 + u * c5))));
      if (highest >= 1)
        state[size] = (c1 + u * (2 * c2 + u * (3 * c3 + u * (4 * c4 + u * 5 * c5)))) / h;
      if (highest >= 2) state[2 * size] = (2 * c2 + u * (6 * c3 + u * (12 * c4 + u * 20 * c5))) / (h * h);
    }
  }
}

}  // namespace apc
