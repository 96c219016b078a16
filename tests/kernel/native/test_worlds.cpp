//! \file
//! Trees of bounds and clouds against going through everything.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "random_cases.hpp"

using namespace apc;

namespace {

std::vector<double> flat(const std::vector<Vec3>& points) {
  std::vector<double> out;
  for (const Vec3& p : points) out.insert(out.end(), {p.x, p.y, p.z});
  return out;
}

std::vector<Vec3> random_points(test::Random& random, int n) {
  std::vector<Vec3> points;
  for (int i = 0; i < n; ++i) points.push_back(random.point(1.2));
  return points;
}

}  // namespace

TEST_CASE("a spatial order holds everything once, also where all stands in one place") {
  test::Random random(41);
  for (const int n : {0, 1, 7, 8, 9, 64, 65, 513, 5000}) {
    for (const bool is_one_place : {false, true}) {
      std::vector<Vec3> points = random_points(random, n);
      if (is_one_place) std::fill(points.begin(), points.end(), Vec3{0.1, 0.2, 0.3});
      std::vector<int> order = spatial_order(points);
      std::sort(order.begin(), order.end());
      std::vector<int> all(static_cast<std::size_t>(n));
      std::iota(all.begin(), all.end(), 0);
      CHECK(order == all);
    }
  }
}

TEST_CASE("a tree of bounds visits all that is near, and not everything") {
  test::Random random(42);
  for (const int n : {0, 1, 8, 9, 70, 600, 5000}) {
    const std::vector<Vec3> points = random_points(random, n);
    std::vector<Bounds> bounds;
    std::vector<int> order = spatial_order(points);
    for (int i : order) {
      const Vec3& p = points[static_cast<std::size_t>(i)];
      bounds.push_back({p, p});
    }
    const BoundsTree tree(bounds, 1e-6);
    for (int k = 0; k < 50; ++k) {
      const Vec3 at = random.point(1.2);
      const double reach = random.between(0.0, 0.5);
      std::vector<char> is_visited(static_cast<std::size_t>(n));
      tree.visit_near(at, [&] { return reach; }, [&](int i) { is_visited[static_cast<std::size_t>(i)] = 1; });
      for (std::size_t i = 0; i < bounds.size(); ++i)
        if (norm(bounds[i].low - at) <= reach) CHECK(is_visited[i]);
      if (n == 5000) CHECK(std::count(is_visited.begin(), is_visited.end(), 1) < n);
    }
  }
}

TEST_CASE("a cloud is as far away as its nearest point, filtered or not") {
  test::Random random(43);
  for (int i = 0; i < 30; ++i) {
    const unsigned robot = static_cast<unsigned>(random.below(1000));
    const std::vector<Vec3> points = random_points(random, 1 + random.below(300));
    const std::vector<double> numbers = flat(points);
    const double radius = random.between(0.0, 0.03);
    std::vector<Obstacle> balls;
    for (const Vec3& p : points)
      balls.push_back({make_solid({{}, p}, {radius, radius, radius}, SolidKind::sphere, 0.0), 0,
                       static_cast<int>(balls.size())});
    for (const double voxel : {0.0, 0.1}) {
      Checker with_balls(test::Random(robot).robot()), with_cloud(test::Random(robot).robot());
      with_balls.world() = World(balls);
      const CloudPoints cloud{numbers.data(), static_cast<int>(points.size()), radius, 0.0, voxel};
      with_cloud.world().set_cloud(std::make_shared<const Cloud>(cloud), 0);
      for (int k = 0; k < 10; ++k) {
        const std::vector<double> q = random.configuration(with_balls.n());
        const Contact near = with_balls.clearance(q.data(), 1.0), found = with_cloud.clearance(q.data(), 1.0);
        CHECK_LE(found.distance, near.distance + 1e-9);
        if (near.distance > 0.0) CHECK_LE(near.distance, found.distance + std::sqrt(3.0) * voxel + 1e-5);
        if (near.kind == ContactKind::world && voxel == 0.0) CHECK(found.kind == ContactKind::cloud);
        bool is_free = false;
        with_cloud.are_free(q.data(), 1, 0.0, &is_free);
        if (is_free) CHECK(near.distance > 0.0);
      }
    }
  }
}

TEST_CASE("an edge that is proven free among a cloud keeps away from every point of it") {
  test::Random random(44);
  int n_free = 0, n_hit = 0;
  for (int i = 0; i < 60; ++i) {
    Checker checker(random.robot());
    const std::vector<double> numbers = flat(random_points(random, 150));
    const double half_edge = random.below(2) ? 0.02 : 0.0;
    const CloudPoints cloud{numbers.data(), 150, 0.01, half_edge, 0.0};
    checker.world().set_cloud(std::make_shared<const Cloud>(cloud), 0);
    const std::vector<double> a = random.configuration(checker.n());
    std::vector<double> b = random.configuration(checker.n());
    for (std::size_t j = 0; j < b.size(); ++j) b[j] = a[j] + 0.1 * (b[j] - a[j]);
    const EdgeReport report = checker.check_edge(a.data(), b.data(), 0.005, nullptr, 2e-4);
    ++(report.free ? n_free : n_hit);
    if (!report.free) {
      CHECK(report.kind == ContactKind::cloud);
      CHECK(report.index >= 0);
      CHECK(report.index < 150);
      continue;
    }
    for (int k = 0; k <= 100; ++k) {
      std::vector<double> q = a;
      for (std::size_t j = 0; j < q.size(); ++j) q[j] += k / 100.0 * (b[j] - a[j]);
      CHECK(checker.clearance(q.data(), 1.0).distance > 0.005);
    }
  }
  CHECK(n_free > 10);
  CHECK(n_hit > 10);
}

TEST_CASE("what is no cloud is refused") {
  const double point[3] = {1.0, 1.0, 1.0};
  CHECK_THROWS(Cloud({point, 1, -0.1, 0.0, 0.0}));
  CHECK_THROWS(Cloud({point, 1, 0.1, -0.1, 0.0}));
  CHECK_THROWS(Cloud({point, 1, 0.1, 0.0, -0.1}));
  CHECK_THROWS(Cloud({point, 1, 0.1, 0.0, 1e-9}));
}
