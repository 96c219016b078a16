//! \file
//! Proven edges: what is called free is free at any point, and what is not has a point that is too near.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "planning/rrt_connect.hpp"
#include "random_cases.hpp"

using namespace apc;

namespace {

std::vector<double> along(const std::vector<double>& a, const std::vector<double>& b, double t) {
  std::vector<double> q;
  for (std::size_t j = 0; j < a.size(); ++j) q.push_back(a[j] + t * (b[j] - a[j]));
  return q;
}

}  // namespace

TEST_CASE("an edge that is proven free keeps its margin wherever it is looked at") {
  test::Random random(21);
  int n_free = 0, n_hit = 0;
  for (int i = 0; i < 80; ++i) {
    Checker checker(random.robot());
    checker.world() = random.world(8);
    const std::vector<double> a = random.configuration(checker.n()),
                              b = along(a, random.configuration(checker.n()), 0.3);
    const double margin = random.between(0.0, 0.02);
    const EdgeReport report = checker.check_edge(a.data(), b.data(), margin, nullptr, 2e-4);
    ++(report.free ? n_free : n_hit);
    if (!report.free) {
      const double there = checker.clearance(along(a, b, report.t).data(), 1.0).distance;
      CHECK_LE(there, margin + 3e-4);
      CHECK(report.kind == ContactKind::world);
      CHECK(report.frame >= 0);
      CHECK(report.index >= 0);
      continue;
    }
    CHECK(report.kind == ContactKind::none);
    CHECK(report.t == -1.0);
    for (int k = 0; k <= 200; ++k)
      CHECK(checker.clearance(along(a, b, k / 200.0).data(), 1.0).distance > margin);
  }
  CHECK(n_free > 10);
  CHECK(n_hit > 10);
}

TEST_CASE("a tube that is proven free is free at its corners") {
  test::Random random(22);
  int n_free = 0;
  for (int i = 0; i < 80; ++i) {
    Checker checker(random.robot());
    checker.world() = random.world(5);
    const std::vector<double> a = random.configuration(checker.n()),
                              b = along(a, random.configuration(checker.n()), 0.1);
    const std::vector<double> slack(a.size(), 0.01);
    if (!checker.check_edge(a.data(), b.data(), 0.0, slack.data(), 2e-4).free) continue;
    ++n_free;
    for (int k = 0; k < 100; ++k) {
      std::vector<double> q = along(a, b, random.between(0.0, 1.0));
      for (std::size_t j = 0; j < q.size(); ++j) q[j] += random.below(2) ? slack[j] : -slack[j];
      CHECK(checker.clearance(q.data(), 1.0).distance > 0.0);
    }
  }
  CHECK(n_free > 10);
}

TEST_CASE("a wall in the middle of a doubtful edge is seen before anything is proven") {
  const Chain chain({{JointKind::prismatic, {}, {1.0, 0.0, 0.0}, 0}});
  Checker checker(Robot(chain, {{{0.0, 0.0, 0.0}, 0.05}}, {0}, {}));
  const Solid wall = make_solid({{}, {0.5, 0.0, 0.0}}, {0.1, 1.0, 1.0}, SolidKind::box, 0.0);
  checker.world() = World({{wall, 0, 3}});
  const double from = 0.0, to = 1.0;
  for (const double slack : {0.0, 0.01}) {
    const EdgeReport report = checker.check_edge(&from, &to, 0.0, &slack, 2e-4, true);
    CHECK(!report.free);
    CHECK(report.index == 3);
    CHECK(report.n_configurations == 8);
    CHECK_LE(std::abs(report.t - 0.5), 0.15 + 1e-9);
  }
}

TEST_CASE("a thin plate between two samples is found") {
  const Chain chain({{JointKind::prismatic, {}, {1.0, 0.0, 0.0}, 0}});
  Checker checker(Robot(chain, {{{0.0, 0.0, 0.0}, 1e-3}}, {0}, {}));
  test::Random random(23);
  for (int i = 0; i < 50; ++i) {
    const double x = random.between(0.05, 0.95);
    const Solid plate = make_solid({{}, {x, 0.0, 0.0}}, {1e-5, 1.0, 1.0}, SolidKind::box, 0.0);
    checker.world() = World({{plate, 0, 7}});
    const double from = 0.0, to = 1.0;
    const EdgeReport report = checker.check_edge(&from, &to, 0.0, nullptr, 2e-4);
    CHECK(!report.free);
    CHECK(report.index == 7);
    CHECK_LE(std::abs(report.t - x), 2e-3);
  }
}

TEST_CASE("the same query of RRT-Connect gives the same bits, and its edges are proven") {
  test::Random random(24);
  Checker checker(random.robot());
  checker.world() = random.world(3);
  std::vector<double> a, b;
  const auto is_free = [&](const std::vector<double>& q) {
    return checker.clearance(q.data(), 1.0).distance > 0.01;
  };
  do a = random.configuration(checker.n());
  while (!is_free(a));
  do b = random.configuration(checker.n());
  while (!is_free(b));
  const std::vector<double> lower(a.size(), -3.0), upper(a.size(), 3.0);
  const ConnectQuery query{a.data(), b.data(), 1, lower.data(), upper.data(), 0.5, 0.0, 2e-4, 5, 2000};
  const std::vector<double> path = rrt_connect(checker, query);
  CHECK(path == rrt_connect(checker, query));
  CHECK(path.size() >= 2 * a.size());
  for (std::size_t i = 0; i + a.size() < path.size(); i += a.size())
    CHECK(checker.check_edge(&path[i], &path[i + a.size()], 0.0, nullptr, 2e-4).free);
}

TEST_CASE("a long search of RRT-Connect begins anew and stays the same to the bit") {
  // A point in a square with a wall across, which has a gap that is seldom drawn.
  const Chain chain({{JointKind::prismatic, {}, {1.0, 0.0, 0.0}, 0},
                     {JointKind::prismatic, {}, {0.0, 1.0, 0.0}, 1}});
  Checker checker(Robot(chain, {{{0.0, 0.0, 0.0}, 1e-3}}, {1}, {}));
  const Solid low = make_solid({{}, {0.5, -0.5, 0.0}}, {0.1, 0.8, 1.0}, SolidKind::box, 0.0);
  const Solid high = make_solid({{}, {0.5, 1.12, 0.0}}, {0.1, 0.8, 1.0}, SolidKind::box, 0.0);
  checker.world() = World({{low, 0, 0}, {high, 0, 1}});
  const std::vector<double> start{0.05, 0.9}, goals{0.95, 0.9, 0.95, 0.1}, lower{0.0, 0.0}, upper{1.0, 1.0};
  const int n_attempt = 494;  // of a diagonal that is 2.8 steps long
  int n_anew = 0;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    const auto found = [&](int most) {
      return rrt_connect(checker, {start.data(), goals.data(), 2, lower.data(), upper.data(), 0.5, 0.0, 2e-4,
                                   seed, most});
    };
    const std::vector<double> path = found(20 * n_attempt);
    REQUIRE(!path.empty());
    CHECK(path == found(40 * n_attempt));
    n_anew += found(n_attempt).empty();
    CHECK(std::equal(start.begin(), start.end(), path.begin()));
    CHECK(path[path.size() - 2] == 0.95);
    for (std::size_t i = 0; i + 2 < path.size(); i += 2)
      CHECK(checker.check_edge(&path[i], &path[i + 2], 0.0, nullptr, 2e-4).free);
  }
  CHECK(n_anew > 5);
}
