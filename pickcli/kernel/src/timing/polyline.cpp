#include "timing/polyline.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace apc {
namespace {

//! Waypoints (N, n), row-major.
struct Waypoints {
  const double* rows;
  std::size_t n;

  double distance(std::size_t a, std::size_t b) const {
    double squares = 0.0;
    for (std::size_t j = 0; j < n; ++j) {
      const double off = rows[a * n + j] - rows[b * n + j];
      squares += off * off;
    }
    return std::sqrt(squares);
  }
};

//! How far waypoint i is from the chord between two others of this length, and how far along it.
std::pair<double, double> off_chord(const Waypoints& at, std::size_t first, std::size_t last, double length,
                                    std::size_t i) {
  const double *a = at.rows + first * at.n, *b = at.rows + last * at.n, *p = at.rows + i * at.n;
  double along = 0.0, squares = 0.0;
  for (std::size_t j = 0; j < at.n; ++j) along += (p[j] - a[j]) * (b[j] - a[j]);
  along = std::clamp(along / length, 0.0, length);
  for (std::size_t j = 0; j < at.n; ++j) {
    const double off = (p[j] - a[j]) - along * ((b[j] - a[j]) / length);
    squares += off * off;
  }
  return {std::sqrt(squares), along};
}

//! The waypoint that most needs to be kept between two others, or `first` if none does.
std::size_t worst_between(const Waypoints& at, std::size_t first, std::size_t last, const double* tolerance,
                          double same) {
  const double length = at.distance(first, last);
  double most = 1.0, farthest = 0.0;
  std::size_t worst = first;
  for (std::size_t i = first + 1; i < last; ++i) {
    double off;
    if (length <= same) {
      off = at.distance(first, i);
    } else {
      const auto [distance, along] = off_chord(at, first, last, length, i);
      farthest = std::max(farthest, along);
      off = std::max(distance, farthest - along);  // behind an earlier one: the path reverses there
    }
    if (off / tolerance[i] > most) {
      most = off / tolerance[i];
      worst = i;
    }
  }
  return worst;
}

//! Drop each kept waypoint at the place of the one before it; the end of the path is always kept.
std::vector<std::int32_t> without_repeats(const Waypoints& at, const std::vector<std::size_t>& kept,
                                          const PointTolerances& points) {
  std::vector<std::size_t> out{kept.front()};
  for (std::size_t k = 1; k < kept.size(); ++k) {
    const double way = at.distance(kept[k], out.back());
    if (way > points.same)
      out.push_back(kept[k]);
    else if (k + 1 == kept.size() && out.size() > 1)
      out.back() = kept[k];
    else if (k + 1 == kept.size() && way > points.nowhere)
      out.push_back(kept[k]);
  }
  return {out.begin(), out.end()};
}

}  // namespace

std::vector<std::int32_t> simplified(const double* waypoints, std::size_t N, std::size_t n,
                                     const double* tolerance, const PointTolerances& points) {
  const Waypoints at{waypoints, n};
  std::vector<std::size_t> kept{0};
  std::vector<std::pair<std::size_t, std::size_t>> left{{0, N - 1}};
  while (!left.empty()) {
    const auto [first, last] = left.back();
    left.pop_back();
    const std::size_t worst = worst_between(at, first, last, tolerance, points.same);
    if (worst != first) {
      left.insert(left.end(), {{worst, last}, {first, worst}});
    } else if (last != first) {
      kept.push_back(last);
    }
  }
  return without_repeats(at, kept, points);
}

}  // namespace apc
