//! \file
//! What single precision may be off by is inside of the stated bounds, and those are small.
#include <doctest/doctest.h>

#include <string>
#include <vector>

#include "random_cases.hpp"
#include "simd/dispatch.hpp"

using namespace apc;

TEST_CASE("a configuration that is free with the rounding's margin is free in double precision") {
  test::Random random(1);
  int n_free = 0, n_hit = 0;
  for (int i = 0; i < 60; ++i) {
    Checker checker(random.robot());
    checker.world() = random.world(12);
    for (int k = 0; k < 20; ++k) {
      const std::vector<double> q = random.configuration(checker.n());
      const double distance = checker.clearance(q.data(), 1.0).distance;
      for (const double margin : {0.0, 0.05}) {
        bool is_free = false;
        checker.are_free(q.data(), 1, margin, &is_free);
        const double rounding =
            checker.robot().rounding(1.0) + checker.world().rounding(checker.robot().reach(1.0));
        if (is_free)
          CHECK(distance > margin);
        else
          CHECK_LE(distance, margin + 3.0 * rounding);
        ++(is_free ? n_free : n_hit);
      }
    }
  }
  CHECK(n_free > 100);
  CHECK(n_hit > 100);
}

TEST_CASE("the margin is rounded the safe way: a sphere at exactly the margin is not free") {
  const Chain chain({{JointKind::prismatic, {}, {1.0, 0.0, 0.0}, 0}});
  Checker checker(Robot(chain, {{{0.0, 0.0, 0.0}, 0.1}}, {0}, {}));
  const Solid wall = make_solid({{}, {1.5, 0.0, 0.0}}, {0.5, 1.0, 1.0}, SolidKind::box, 0.0);
  checker.world() = World({{wall, 0, 0}});
  for (const double margin : {0.0, 1e-3, 0.01, 0.1, 0.3}) {
    const double touching = 1.0 - 0.1 - margin;
    for (const double off : {0.0, 1e-9, 1e-8}) {
      const double q = touching + off;
      bool is_free = true;
      checker.are_free(&q, 1, margin, &is_free);
      CHECK(!is_free);
    }
    const double clear = touching - 1e-5;
    bool is_free = false;
    checker.are_free(&clear, 1, margin, &is_free);
    CHECK(is_free);
  }
}

TEST_CASE("the bounds of rounding are micrometres for an arm of a metre") {
  test::Random random(2);
  for (int i = 0; i < 20; ++i) {
    const Robot robot = random.robot();
    CHECK(robot.rounding(1.0) > 0.0);
    CHECK_LE(robot.rounding(1.0), 3e-5);
    CHECK_LE(robot.rounding(0.0), robot.rounding(1.0));
  }
}

TEST_CASE("both builds of the batch test give the same bits") {
  const std::string before = simd_name();
  test::Random random(3);
  for (int i = 0; i < 20; ++i) {
    Checker checker(random.robot());
    checker.world() = random.world(12);
    const std::vector<double> a = random.configuration(checker.n()), b = random.configuration(checker.n());
    set_simd("baseline");
    const EdgeReport first = checker.check_edge(a.data(), b.data(), 0.0, nullptr, 2e-4);
    set_simd(before.c_str());
    const EdgeReport second = checker.check_edge(a.data(), b.data(), 0.0, nullptr, 2e-4);
    CHECK(first.free == second.free);
    CHECK(first.t == second.t);
    CHECK(first.frame == second.frame);
    CHECK(first.index == second.index);
    CHECK(first.n_configurations == second.n_configurations);
  }
  CHECK_THROWS(set_simd("abacus"));
}
