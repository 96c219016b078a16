//! \file
//! Paces along paths, and the largest values on quintics.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "random_cases.hpp"
#include "timing/quintic.hpp"
#include "timing/topp.hpp"

using namespace apc;

TEST_CASE("the pace along a line is the trapezoid that is known") {
  const std::vector<double> s{0.0, 2.0}, dq{1.0, 1.0}, ddq{0.0, 0.0}, acceleration{4.0}, speed{1.0, 1.0},
      line{1.0};
  const std::int32_t is_line[1] = {1};
  const PaceProfile found = fastest_pace(
      {2, 1, s.data(), dq.data(), ddq.data(), acceleration.data(), speed.data(), line.data(), is_line, 0.0});
  CHECK(found.t.size() == 4);
  CHECK_LE(std::abs(found.t.back() - (2.0 + 0.25)), 1e-12);  // length / speed + speed / acceleration
  CHECK_LE(std::abs(*std::max_element(found.v.begin(), found.v.end()) - 1.0), 1e-12);
  CHECK(found.v.front() == 0.0);
  CHECK(found.v.back() == 0.0);
}

TEST_CASE("a pace along a bent path keeps the limits of acceleration") {
  test::Random random(41);
  for (int i = 0; i < 40; ++i) {
    constexpr std::size_t M = 40, n = 3;
    std::vector<double> s, dq, ddq, acceleration((M - 1) * n, 5.0), speed(M, 2.0), line(M - 1, 2.0);
    const double turn = random.between(0.5, 3.0);
    for (std::size_t k = 0; k < M; ++k) {
      s.push_back(static_cast<double>(k) / 20.0);
      for (std::size_t j = 0; j < n; ++j) {
        const double at = turn * s.back() + static_cast<double>(j);
        dq.push_back(std::cos(at));
        ddq.push_back(-turn * std::sin(at));
      }
    }
    const std::vector<std::int32_t> is_line(M - 1, 0);
    const PaceProfile found = fastest_pace({M, n, s.data(), dq.data(), ddq.data(), acceleration.data(),
                                            speed.data(), line.data(), is_line.data(), 0.0});
    CHECK(found.s.size() == M);
    for (std::size_t k = 0; k + 1 < M; ++k) {
      CHECK(found.t[k + 1] > found.t[k]);
      CHECK_LE(found.v[k], 2.0 + 1e-12);
      const double u =
          (found.v[k + 1] * found.v[k + 1] - found.v[k] * found.v[k]) / (2.0 * (s[k + 1] - s[k]));
      for (std::size_t j = 0; j < n; ++j)
        CHECK_LE(std::abs(dq[k * n + j] * u + ddq[k * n + j] * found.v[k] * found.v[k]), 5.0 + 1e-6);
    }
  }
}

TEST_CASE("no value on a quintic is above its peaks") {
  test::Random random(42);
  for (int i = 0; i < 200; ++i) {
    const JointState a{random.between(-3, 3), random.between(-2, 2), random.between(-9, 9)};
    const JointState b{random.between(-3, 3), random.between(-2, 2), random.between(-9, 9)};
    const double h = random.between(0.004, 0.5);
    const Peaks peaks = quintic_peaks(a, b, h);
    const double way = b.p - a.p, v0 = a.v * h, v1 = b.v * h, a0 = a.a * h * h, a1 = b.a * h * h;
    const double c2 = a0 / 2, c3 = 10 * way - 6 * v0 - 4 * v1 - 1.5 * a0 + 0.5 * a1;
    const double c4 = -15 * way + 8 * v0 + 7 * v1 + 1.5 * a0 - a1,
                 c5 = 6 * way - 3 * v0 - 3 * v1 - 0.5 * a0 + 0.5 * a1;
    double velocity = 0.0, acceleration = 0.0, jerk = 0.0;
    for (int k = 0; k <= 400; ++k) {
      const double u = k / 400.0;
      velocity =
          std::max(velocity, std::abs(v0 + u * (2 * c2 + u * (3 * c3 + u * (4 * c4 + u * 5 * c5)))) / h);
      acceleration =
          std::max(acceleration, std::abs(2 * c2 + u * (6 * c3 + u * (12 * c4 + u * 20 * c5))) / (h * h));
      jerk = std::max(jerk, std::abs(6 * c3 + u * (24 * c4 + u * 60 * c5)) / (h * h * h));
    }
    CHECK_LE(velocity, peaks.velocity * (1.0 + 1e-12));
    CHECK_LE(acceleration, peaks.acceleration * (1.0 + 1e-12));
    CHECK_LE(jerk, peaks.jerk * (1.0 + 1e-12));
    CHECK_LE(peaks.acceleration, acceleration * (1.0 + 1e-3));
    CHECK_LE(peaks.jerk, jerk * (1.0 + 1e-3));
  }
}

TEST_CASE("what is above its floor is the same peak as without one") {
  test::Random random(43);
  for (int i = 0; i < 500; ++i) {
    const JointState a{random.between(-3, 3), random.between(-2, 2), random.between(-9, 9)};
    const JointState b{random.between(-3, 3), random.between(-2, 2), random.between(-9, 9)};
    const double h = random.between(0.004, 0.5), share = random.between(0.5, 3.0);
    const Peaks whole = quintic_peaks(a, b, h);
    const Peaks floor{share * whole.velocity, share * whole.acceleration, share * whole.jerk};
    const Peaks found = quintic_peaks(a, b, h, floor);
    const auto is_right = [&](double peak, double all) { return peak == all || (peak == 0.0 && share > 1.0); };
    CHECK(is_right(found.velocity, whole.velocity));
    CHECK(is_right(found.acceleration, whole.acceleration));
    CHECK(is_right(found.jerk, whole.jerk));
  }
}
