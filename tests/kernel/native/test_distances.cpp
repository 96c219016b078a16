//! \file
//! Distances of solids, found by going from one to the other and back, against brute force.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "random_cases.hpp"

using namespace apc;

namespace {

//! Points of a core's surface and inside of it, in the parent's frame, n along each axis.
std::vector<Vec3> samples(const Solid& solid, int n) {
  std::vector<Vec3> points;
  for (int i = 0; i <= n; ++i)
    for (int j = 0; j <= n; ++j)
      for (int k = 0; k <= n; ++k) {
        const double x = 2.0 * i / n - 1.0, y = 2.0 * j / n - 1.0, z = 2.0 * k / n - 1.0;
        Vec3 p{x * solid.half.x, y * solid.half.y, z * solid.half.z};
        if (solid.kind == SolidKind::cylinder) {
          const double angle = 3.141592653589793 * y, radius = 0.5 * (x + 1.0) * solid.half.x;
          p = {radius * std::cos(angle), radius * std::sin(angle), z * solid.half.z};
        }
        points.push_back(solid.T * p);
      }
  return points;
}

//! The smallest distance of any sample of one core from the other solid: from above.
double brute_force(const Solid& a, const Solid& b) {
  double least = std::numeric_limits<double>::infinity();
  for (const Vec3& point : samples(a, 24)) least = std::min(least, signed_distance(point, b));
  return least - a.rounding;
}

//! How far neighbouring samples of a core are apart, at most.
double pitch(const Solid& solid) { return norm(solid.half) * 3.2 * 2.0 / 24; }

}  // namespace

TEST_CASE("the distance of two solids is below every sample's, and near to the smallest") {
  test::Random random(11);
  int n_apart = 0;
  for (int i = 0; i < 150; ++i) {
    const Solid a = random.solid(random.pose(0.5), random.between(0.0, 0.02));
    const Solid b = random.solid(random.pose(0.5), random.between(0.0, 0.02));
    const double found = signed_distance(a, b, std::numeric_limits<double>::infinity()),
                 above = brute_force(a, b);
    CHECK_LE(found, above + 1e-9);
    if (found <= 0.0) continue;
    ++n_apart;
    CHECK_LE(above, found + pitch(a) + 1e-12);
  }
  CHECK(n_apart > 50);
}

TEST_CASE("distances known by hand") {
  const double inf = std::numeric_limits<double>::infinity();
  const Solid cube = make_solid({}, {0.1, 0.1, 0.1}, SolidKind::box, 0.0);
  const auto box_at = [](const Vec3& p) {
    return make_solid({{}, p}, {0.1, 0.1, 0.1}, SolidKind::box, 0.0);
  };
  CHECK_LE(std::abs(signed_distance(cube, box_at({0.5, 0.0, 0.0}), inf) - 0.3), 1e-9);
  CHECK_LE(std::abs(signed_distance(cube, box_at({0.5, 0.5, 0.0}), inf) - 0.3 * std::sqrt(2.0)), 1e-9);
  CHECK_LE(std::abs(signed_distance(cube, box_at({0.5, 0.5, 0.5}), inf) - 0.3 * std::sqrt(3.0)), 1e-9);
  CHECK_LE(std::abs(signed_distance(cube, box_at({0.15, 0.0, 0.0}), inf) + 0.05), 1e-9);
  const Solid ball = make_solid({{}, {0.3, 0.4, 0.1}}, {0.05, 0.05, 0.05}, SolidKind::sphere, 0.0);
  CHECK_LE(std::abs(signed_distance(cube, ball, inf) - (std::hypot(0.2, 0.3) - 0.05)), 1e-9);
  const Solid can = make_solid({{}, {0.0, 0.0, 0.4}}, {0.05, 0.05, 0.1}, SolidKind::cylinder, 0.0);
  CHECK_LE(std::abs(signed_distance(cube, can, inf) - 0.2), 1e-9);
}

TEST_CASE("a bound is not above the distance, and enough or too near end the search rightly") {
  test::Random random(13);
  const double inf = std::numeric_limits<double>::infinity();
  int n_beyond = 0, n_near = 0;
  for (int i = 0; i < 300; ++i) {
    const Solid a = random.solid(random.pose(0.5), random.between(0.0, 0.02));
    const Solid b = random.solid(random.pose(0.5), random.between(0.0, 0.02));
    const double exact = signed_distance(a, b, inf), bound = distance_bound(a, b, inf);
    CHECK_LE(bound, exact);
    for (const double limit : {exact - 0.01, exact + 0.01}) {
      const bool is_beyond = distance_bound(a, b, limit) > limit || signed_distance(a, b, limit) > limit;
      CHECK(is_beyond == (exact > limit));
      const double found = signed_distance(a, b, bound, inf, limit);
      CHECK((found <= limit) == (exact <= limit));
      if (exact > limit) CHECK(found == exact);
      n_beyond += is_beyond, n_near += found <= limit;
    }
  }
  CHECK(n_beyond == 300);
  CHECK(n_near == 300);
}

TEST_CASE("the order of two solids does not matter") {
  test::Random random(12);
  for (int i = 0; i < 200; ++i) {
    const Solid a = random.solid(random.pose(0.5)), b = random.solid(random.pose(0.5));
    const double inf = std::numeric_limits<double>::infinity(), ab = signed_distance(a, b, inf);
    if (ab > 0.0) CHECK_LE(std::abs(ab - signed_distance(b, a, inf)), 1e-6);
  }
}

TEST_CASE("what is no solid is refused") {
  CHECK_THROWS(make_solid({}, {-0.1, 0.1, 0.1}, SolidKind::box, 0.0));
  CHECK_THROWS(make_solid({}, {0.1, 0.1, 0.1}, SolidKind::box, -1e-3));
  CHECK_THROWS(make_solid({}, {0.1, 0.2, 0.1}, SolidKind::cylinder, 0.0));
  CHECK_THROWS(make_solid({}, {0.1, 0.1, 0.2}, SolidKind::sphere, 0.0));
}
