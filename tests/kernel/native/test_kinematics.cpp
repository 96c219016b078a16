//! \file
//! Forward kinematics, Jacobian and inverse kinematics of random chains.
#include <doctest/doctest.h>

#include <cmath>
#include <vector>

#include "kinematics/inverse_dynamics.hpp"
#include "kinematics/line_following.hpp"
#include "kinematics/resolved_rate.hpp"
#include "random_cases.hpp"

using namespace apc;

TEST_CASE("the Jacobian is what small steps do") {
  test::Random random(31);
  for (int i = 0; i < 30; ++i) {
    const Robot robot = random.robot();
    const Chain& chain = robot.chain();
    std::vector<double> q = random.configuration(chain.n()), J(6 * static_cast<std::size_t>(chain.n()));
    std::vector<Pose> frames(static_cast<std::size_t>(chain.n_frames())), moved = frames;
    chain.fk(q.data(), frames.data());
    chain.jacobian(frames.data(), frames.back().p, J.data());
    for (int j = 0; j < chain.n(); ++j) {
      constexpr double step = 1e-6;
      q[static_cast<std::size_t>(j)] += step;
      chain.fk(q.data(), moved.data());
      q[static_cast<std::size_t>(j)] -= step;
      const Vec3 d = (1.0 / step) * (moved.back().p - frames.back().p);
      const Vec3 turn = (1.0 / step) * rotation_vector(moved.back().R * transposed(frames.back().R));
      const double expected[6] = {d.x, d.y, d.z, turn.x, turn.y, turn.z};
      for (int row = 0; row < 6; ++row)
        CHECK_LE(std::abs(J[static_cast<std::size_t>(row * chain.n() + j)] - expected[row]), 1e-5);
    }
  }
}

TEST_CASE("at rest a joint exerts what the weight's potential energy changes by") {
  test::Random random(37);
  for (int i = 0; i < 30; ++i) {
    const Robot robot = random.robot();
    const Chain& chain = robot.chain();
    const std::size_t n = static_cast<std::size_t>(chain.n()), n_frames = chain.joints().size();
    std::vector<RigidBody> bodies;
    for (std::size_t k = 0; k < n_frames; ++k)
      bodies.push_back({random.between(0.0, 3.0), random.point(0.2), {}});
    std::vector<double> q = random.configuration(chain.n()), rest(n, 0.0), efforts(n);
    InverseDynamics(chain, bodies).efforts(q.data(), rest.data(), rest.data(), 9.81, efforts.data());
    const auto energy = [&] {
      std::vector<Pose> frames(n_frames);
      chain.fk(q.data(), frames.data());
      double sum = 0.0;
      for (std::size_t k = 0; k < n_frames; ++k) sum += 9.81 * bodies[k].mass * (frames[k] * bodies[k].centre).z;
      return sum;
    };
    for (std::size_t j = 0; j < n; ++j) {
      constexpr double step = 1e-5;
      q[j] += step;
      const double after = energy();
      q[j] -= 2.0 * step;
      const double before = energy();
      q[j] += step;
      CHECK_LE(std::abs((after - before) / (2.0 * step) - efforts[j]), 1e-5);
    }
  }
}

TEST_CASE("inverse dynamics has one body for each frame") {
  const Chain chain({{JointKind::revolute, {}, {0.0, 0.0, 1.0}, 0}});
  CHECK_THROWS(InverseDynamics(chain, {}));
}

TEST_CASE("a configuration that is found reaches its target within the limits") {
  test::Random random(32);
  int n_found = 0;
  for (int i = 0; i < 30; ++i) {
    const Robot robot = random.robot();
    const Chain& chain = robot.chain();
    const std::size_t n = static_cast<std::size_t>(chain.n());
    const std::vector<double> lower(n, -3.0), upper(n, 3.0), weights(n, 1.0),
        goal = random.configuration(chain.n());
    std::vector<double> q = goal;
    for (double& each : q) each += random.between(-0.1, 0.1);
    for (double& each : q) each = std::min(std::max(each, -3.0), 3.0);
    std::vector<Pose> frames(static_cast<std::size_t>(chain.n_frames()));
    chain.fk(goal.data(), frames.data());
    const Pose target = frames.back();
    const IkProblem problem{chain, {}, lower.data(), upper.data(), weights.data()};
    if (solve(problem, target, q.data()) != IkResult::converged) continue;
    ++n_found;
    chain.fk(q.data(), frames.data());
    CHECK_LE(norm(frames.back().p - target.p), 1e-5);
    CHECK_LE(norm(rotation_vector(frames.back().R * transposed(target.R))), 1e-4);
    for (std::size_t j = 0; j < n; ++j) {
      CHECK(q[j] >= lower[j]);
      CHECK(q[j] <= upper[j]);
    }
  }
  CHECK(n_found > 20);
}

TEST_CASE("what is no chain is refused") {
  CHECK_THROWS(Chain({}));
  CHECK_THROWS(Chain({{JointKind::revolute, {}, {0.0, 0.0, 0.0}, 0}}));
  CHECK_THROWS(Chain({{JointKind::revolute, {}, {0.0, 0.0, 1.0}, 1}}));
  CHECK_THROWS(Chain({{JointKind::fixed, {}, {0.0, 0.0, 1.0}, 0}}));
}

TEST_CASE("a tip that is to stay lets the arm stay") {
  test::Random random(53);
  for (int i = 0; i < 20; ++i) {
    const Robot robot = random.robot();
    const Chain& chain = robot.chain();
    const std::size_t n = static_cast<std::size_t>(chain.n());
    if (n < 7) continue;
    const std::vector<double> q = random.configuration(chain.n()), velocity(n, 2.0), own(3 * n, 0.0);
    std::vector<Pose> frames(static_cast<std::size_t>(chain.n_frames()));
    chain.fk(q.data(), frames.data());
    const std::vector<double> lower(n, -100.0), upper(n, 100.0), still(18, 0.0);
    ResolvedRate arm(chain, Pose{}, velocity.data());
    const WantedMotion wanted{{0.0, 0.1, 0.2}, {3, frames.back()}, own.data(), still.data(), own.data(), still.data()};
    const TrackedPath path = track(arm, velocity.data(), wanted, 1, q.data(), {lower.data(), upper.data(), 3.0});
    if (path.end != TrackEnd::done) continue;  // singular
    for (std::size_t row = 0; row < 3; ++row)
      for (std::size_t j = 0; j < n; ++j) CHECK_LE(std::abs(path.Q[row * n + j] - q[j]), 1e-9);
  }
}
