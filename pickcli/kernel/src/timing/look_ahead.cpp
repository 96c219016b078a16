#include "timing/look_ahead.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace apc {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNowhere = 1e-9;  // joint units: an edge, or a turn, that is none
constexpr double kFlat = 1e-12;    // share of a joint in a direction: it stands still

struct Edge {
  double length, top, acceleration;  //!< joint units; per s, per s^2 along it
  std::vector<double> direction;     //!< (n,)
};

//! The least limit over what each joint has of a direction.
double along(const double* limits, const std::vector<double>& direction) {
  double least = kInfinity;
  for (std::size_t j = 0; j < direction.size(); ++j)
    least = std::min(least, limits[j] / std::max(std::abs(direction[j]), kFlat));
  return least;
}

double length_of(const std::vector<double>& v) {
  double squares = 0.0;
  for (double value : v) squares += value * value;
  return std::sqrt(squares);
}

//! The edges that lead anywhere.
std::vector<Edge> edges_of(const Polyline& line) {
  std::vector<Edge> edges;
  std::vector<double> step(line.n);
  for (std::size_t i = 0; i + 1 < line.N; ++i) {
    const double *from = line.waypoints + i * line.n, *to = from + line.n;
    for (std::size_t j = 0; j < line.n; ++j) step[j] = to[j] - from[j];
    const double length = length_of(step);
    if (!(length > kNowhere)) continue;
    for (double& share : step) share /= length;
    edges.push_back({length, along(line.velocity, step), along(line.acceleration, step), step});
  }
  return edges;
}

//! Fastest speed through the corner of two edges on a parabolic blend. A parabola that leaves them a distance h
//! before and after the corner deviates by h |du| / 4 and, run at speed v, needs the acceleration v^2 du / (2 h).
double corner_speed(const Polyline& line, const Edge& before, const Edge& after) {
  std::vector<double> turn(line.n);
  for (std::size_t j = 0; j < line.n; ++j) turn[j] = after.direction[j] - before.direction[j];
  const double size = std::max(length_of(turn), kNowhere);
  const double reach = std::min(4 * line.corner_deviation / size, std::min(before.length, after.length) / 2);
  return std::sqrt(along(line.acceleration, turn) * 2 * reach);
}

double reachable(double speed, const Edge& edge) {
  return std::sqrt(speed * speed + 2 * edge.acceleration * edge.length);
}

//! Seconds along an edge from speed v0 to v1, never above its top speed.
double trapezoid(const Edge& edge, double v0, double v1) {
  const double a = edge.acceleration;
  const double peak = std::min(edge.top, std::sqrt((2 * a * edge.length + v0 * v0 + v1 * v1) / 2));
  const double ramps = (2 * peak * peak - v0 * v0 - v1 * v1) / (2 * a);
  const double cruise = std::max(edge.length - ramps, 0.0);
  return (2 * peak - v0 - v1) / a + cruise / peak;
}

}  // namespace

double estimated_duration(const Polyline& line) {
  const std::vector<Edge> edges = edges_of(line);
  const std::size_t E = edges.size();
  std::vector<double> speeds(E + 1, 0.0);  // at the start of each edge, and at the end
  for (std::size_t i = 1; i < E; ++i) speeds[i] = corner_speed(line, edges[i - 1], edges[i]);
  for (std::size_t i = E; i-- > 0;)
    speeds[i] = std::min({speeds[i], edges[i].top, reachable(speeds[i + 1], edges[i])});
  for (std::size_t i = 0; i < E; ++i)
    speeds[i + 1] = std::min({speeds[i + 1], edges[i].top, reachable(speeds[i], edges[i])});
  double seconds = 0.0;
  for (std::size_t i = 0; i < E; ++i) seconds += trapezoid(edges[i], speeds[i], speeds[i + 1]);
  return seconds;
}

}  // namespace apc
