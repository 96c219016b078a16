//! \file
//! Constraints on the tool, projections onto them, blocks of poses that are proven free, and gradients of distances.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "collision/near_pairs.hpp"
#include "collision/pose_blocks.hpp"
#include "control/projection.hpp"
#include "random_cases.hpp"

using namespace apc;
using apc::test::Random;

namespace {

constexpr double kStep = 1e-6;

PoseConstraint random_constraint(Random& random) {
  PoseConstraint constraint;
  constraint.kind = static_cast<PoseConstraintKind>(random.below(5));
  constraint.reference = {static_cast<ReferenceKind>(random.below(3)), random.point(0.5), random.direction()};
  constraint.tool = random.direction();
  constraint.fixed = random.direction();
  constraint.bound = random.between(-0.5, 0.9);
  return constraint;
}

//! Moved by a velocity and turned by an angular velocity along axis k of the object, for a step.
Pose moved(const Pose& T, std::size_t k, double step) {
  const Vec3 axis{k % 3 == 0 ? 1.0 : 0.0, k % 3 == 1 ? 1.0 : 0.0, k % 3 == 2 ? 1.0 : 0.0};
  if (k < 3) return {T.R, T.p + step * axis};
  return {rotation(axis, step) * T.R, T.p};
}

}  // namespace

TEST_CASE("gradients of constraints are those of differences") {
  Random random(1);
  for (int i = 0; i < 2000; ++i) {
    const PoseConstraint constraint = random_constraint(random);
    const Pose T = random.pose(0.5);
    const auto found = constraint.gradient(T);
    for (std::size_t k = 0; k < 6; ++k) {
      const double ahead = constraint.value(moved(T, k, kStep)), behind = constraint.value(moved(T, k, -kStep));
      CHECK(found[k] == doctest::Approx((ahead - behind) / (2.0 * kStep)).epsilon(1e-5).scale(1.0));
    }
  }
}

TEST_CASE("on a line or a point there is no normal, and nothing is divided by zero") {
  for (const auto kind : {ReferenceKind::line, ReferenceKind::point}) {
    const PoseConstraint constraint{
        PoseConstraintKind::tool_to_normal, {kind, {}, {0, 0, 1}}, {0, 0, 1}, {1, 0, 0}, 0.5};
    for (double each : constraint.gradient(Pose{})) CHECK(std::isfinite(each));
    CHECK(std::isfinite(constraint.value(Pose{})));
  }
}

TEST_CASE("a projection meets the constraints within limits, no farther than where it began to be met") {
  Random random(2);
  int n_met = 0;
  for (int i = 0; i < 60; ++i) {
    const Robot robot = random.robot();
    const Chain& chain = robot.chain();
    const std::size_t n = static_cast<std::size_t>(chain.n());
    const std::vector<double> lower(n, -3.0), upper(n, 3.0), weights(n, 1.0);
    const std::vector<double> at = random.configuration(chain.n()), reference = random.configuration(chain.n());
    std::vector<Pose> frames(static_cast<std::size_t>(chain.n_frames()));
    chain.fk(at.data(), frames.data());
    // A box and a cone about where the tool is at one configuration, so that there is a solution.
    const Pose object = random.pose(0.3), T = inverse(object) * frames.back();
    std::vector<PoseConstraint> constraints;
    for (int k = 0; k < 3; ++k) {
      const Vec3 axis{k == 0 ? 1.0 : 0.0, k == 1 ? 1.0 : 0.0, k == 2 ? 1.0 : 0.0};
      const Reference plane{ReferenceKind::plane, T.p, axis};
      constraints.push_back({PoseConstraintKind::distance_at_most, plane, axis, axis, 0.05});
      constraints.push_back({PoseConstraintKind::distance_at_least, plane, axis, axis, -0.05});
    }
    constraints.push_back(
        {PoseConstraintKind::tool_to_fixed, {}, {0, 0, 1}, T.R * Vec3{0, 0, 1}, std::cos(0.2)});
    constraints.back().reference.axis = {0, 0, 1};
    const ProjectionProblem problem{chain,        Pose{},       object,         constraints,
                                    lower.data(), upper.data(), weights.data(), reference.data()};
    const Projection found = project(problem, at.data());
    REQUIRE(found.is_met);
    double before = 0.0;
    for (std::size_t j = 0; j < n; ++j) {
      CHECK((found.q[j] >= lower[j] && found.q[j] <= upper[j]));
      before += (at[j] - reference[j]) * (at[j] - reference[j]);
    }
    CHECK(found.squared_distance <= before + 1e-12);
    n_met += found.squared_distance < 0.99 * before;
    chain.fk(found.q.data(), frames.data());
    for (const PoseConstraint& each : constraints) CHECK(each.value(inverse(object) * frames.back()) <= 0.0);
  }
  CHECK(n_met > 30);  // most come nearer
}

TEST_CASE("in blocks that are proven no sphere of the tool comes nearer than the margin at any pose") {
  Random random(3);
  int n_proven = 0;
  for (int i = 0; i < 300; ++i) {
    const World world = random.world(3);
    EnvelopeChart chart{static_cast<SurfaceKind>(random.below(3)), random.pose(0.8), {}, {}, random.between(0.0, 0.4)};
    chart.wanted = chart.surface == SurfaceKind::plane ? chart.T_world_surface.R.column(0) : chart.T_world_surface.R.column(2);
    std::vector<ToolSphere> spheres;
    for (int k = 0; k < 4; ++k) spheres.push_back({random.point(0.15), random.between(0.01, 0.04), 0});
    double low[6], high[6];
    for (std::size_t k = 0; k < 3; ++k) {
      low[k] = k == 2 ? 0.05 : random.between(-1.0, 0.0);
      high[k] = low[k] + random.between(0.0, k == 2 ? 0.1 : 0.3);
    }
    high[3] = random.between(0.0, 0.5);
    high[4] = high[5] = chart.cone;
    for (std::size_t k = 3; k < 6; ++k) low[k] = -high[k];
    const ProofEffort effort{0.003, 1e-3, 20'000};
    if (first_unproven(chart, spheres, world, low, high, effort) >= 0) continue;
    ++n_proven;
    for (int s = 0; s < 500; ++s) {
      double at[6];
      for (std::size_t k = 0; k < 6; ++k) at[k] = random.between(low[k], high[k]);
      if (std::hypot(at[4], at[5]) > chart.cone) continue;
      const Pose T = chart.palm(at);
      for (const ToolSphere& sphere : spheres)
        for (const Obstacle& obstacle : world.obstacles())
          CHECK(signed_distance(T * sphere.center, obstacle.solid) - sphere.radius >= effort.margin);
    }
  }
  CHECK(n_proven > 30);
}

TEST_CASE("a sphere of the tool in a solid is found wherever it is in the block") {
  Random random(4);
  const Solid ball = make_solid(Pose{}, {0.05, 0.05, 0.05}, SolidKind::sphere, 0.0);
  const World world({{ball, 0, 0}});
  for (int i = 0; i < 200; ++i) {
    EnvelopeChart chart{SurfaceKind::plane, Pose{}, {1, 0, 0}, {}, 0.1};
    const double low[6] = {-0.3, -0.3, -0.3, -0.1, -0.1, -0.1}, high[6] = {0.3, 0.3, 0.3, 0.1, 0.1, 0.1};
    const std::vector<ToolSphere> spheres{{random.point(0.2), 0.01, 0}};
    CHECK(first_unproven(chart, spheres, world, low, high, {0.003, 1e-3, 100'000}) == 0);
  }
}

TEST_CASE("distances of near pairs change as their gradients say") {
  Random random(5);
  int n_compared = 0;
  for (int i = 0; i < 60; ++i) {
    Checker checker(random.robot());
    checker.world() = random.world(4);
    const std::vector<double> q = random.configuration(checker.n());
    const std::vector<NearPair> found = near_pairs(checker, q.data(), 0.5);
    for (std::size_t j = 0; j < q.size(); ++j) {
      std::vector<double> ahead = q, behind = q;
      ahead[j] += kStep;
      behind[j] -= kStep;
      const auto after = near_pairs(checker, ahead.data(), 0.5), before = near_pairs(checker, behind.data(), 0.5);
      if (after.size() != found.size() || before.size() != found.size()) continue;
      for (std::size_t k = 0; k < found.size(); ++k) {
        const double a = after[k].contact.distance, b = before[k].contact.distance, d = found[k].contact.distance;
        if (after[k].contact.index != found[k].contact.index || std::abs(a + b - 2.0 * d) > 1e-10) continue;
        CHECK(found[k].gradient[j] == doctest::Approx((a - b) / (2.0 * kStep)).epsilon(1e-3).scale(1.0));
        ++n_compared;
      }
    }
  }
  CHECK(n_compared > 500);
}
