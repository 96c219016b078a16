#include "control/projection.hpp"

#include <algorithm>
#include <cmath>

#include "control/hierarchical_qp.hpp"

namespace apc {
namespace {

constexpr double kSettled = 1e-3;      // of weighted joints: a step that short ends the descent
constexpr int kRestorations = 4;       // Newton steps that lead back to the constraints, of which two mostly suffice
constexpr int kFirstRestorations = 20;  // from a seed that is farther away
constexpr double kLonger = 2.0, kShorter = 0.3;  // the next step after one that is taken, and after one that is not
constexpr double kWorthwhile = 0.1;    // of what a step promises, it has to keep

//! The levels of one iteration, whose sizes never change.
class Iteration {
 public:
  explicit Iteration(const ProjectionProblem& problem)
      : problem_(problem), n_(static_cast<std::size_t>(problem.chain.n())),
        frames_(static_cast<std::size_t>(problem.chain.n_frames())), J_(6 * n_), levels_(3) {
    const std::size_t m = problem.constraints.size();
    levels_[0] = level(n_);
    levels_[1] = level(m);
    levels_[2] = level(n_);
    for (std::size_t j = 0; j < n_; ++j) {
      levels_[0].rows(j, j) = 1.0;
      levels_[2].rows(j, j) = std::sqrt(problem.weights[j]);
    }
    std::fill(levels_[1].lower.begin(), levels_[1].lower.end(), -HUGE_VAL);
  }

  //! The largest value of a constraint at q; its rows stand for the step from there.
  double linearize(const Configuration& q) {
    const Chain& chain = problem_.chain;
    chain.fk(q.data(), frames_.data());
    const Pose T_world_tip = frames_.back() * problem_.T_last_tip;
    chain.jacobian(frames_.data(), T_world_tip.p, J_.data());
    const Pose T_object_world = inverse(problem_.T_world_object), T = T_object_world * T_world_tip;
    double worst = -HUGE_VAL;
    for (std::size_t i = 0; i < problem_.constraints.size(); ++i) {
      const PoseConstraint& constraint = problem_.constraints[i];
      const double e = constraint.value(T);
      worst = std::max(worst, e);
      const std::array<double, 6> g = constraint.gradient(T);
      const Vec3 v = problem_.T_world_object.R * Vec3{g[0], g[1], g[2]};
      const Vec3 w = problem_.T_world_object.R * Vec3{g[3], g[4], g[5]};
      const double in_world[6] = {v.x, v.y, v.z, w.x, w.y, w.z};
      for (std::size_t j = 0; j < n_; ++j) {
        double sum = 0.0;
        for (std::size_t a = 0; a < 6; ++a) sum += in_world[a] * J_[a * n_ + j];
        levels_[1].rows(i, j) = sum;
      }
      levels_[1].upper[i] = -e - problem_.tolerance;
    }
    return worst;
  }

  //! The step (n,) from q that comes nearest to the reference in the linearized constraints, each joint by at most
  //! `longest`; the shortest one into them if is_restoring. Empty if the hierarchy was not solved.
  std::vector<double> step(const Configuration& q, double longest, bool is_restoring) {
    for (std::size_t j = 0; j < n_; ++j) {
      const double scale = std::sqrt(problem_.weights[j]), most = longest / scale;
      levels_[0].lower[j] = std::max(problem_.lower[j] - q[j], -most);
      levels_[0].upper[j] = std::min(problem_.upper[j] - q[j], most);
      levels_[2].lower[j] = levels_[2].upper[j] = is_restoring ? 0.0 : scale * (problem_.reference[j] - q[j]);
    }
    const HierarchySolution solved = solve_hierarchy(levels_, std::vector<double>(n_, 0.0));
    return solved.failure.empty() ? solved.x : std::vector<double>{};
  }

  //! Lead q to the constraints by Newton's method; whether it gets there.
  bool restore(Configuration& q, int most) {
    for (int i = 0; linearize(q) > -problem_.tolerance / 2; ++i) {
      if (i == most) return false;
      const std::vector<double> dq = step(q, problem_.longest_step, true);
      if (dq.empty()) return false;
      add(dq, q);
    }
    return true;
  }

  //! Take a step within limits.
  void add(const std::vector<double>& dq, Configuration& q) const {
    for (std::size_t j = 0; j < n_; ++j) q[j] = std::clamp(q[j] + dq[j], problem_.lower[j], problem_.upper[j]);
  }

 private:
  PriorityLevel level(std::size_t m) const {
    return {Matrix(m, n_), std::vector<double>(m, 0.0), std::vector<double>(m, 0.0)};
  }

  const ProjectionProblem& problem_;
  const std::size_t n_;
  std::vector<Pose> frames_;
  std::vector<double> J_;
  std::vector<PriorityLevel> levels_;
};

double squared_distance(const ProjectionProblem& problem, const Configuration& q) {
  double sum = 0.0;
  for (std::size_t j = 0; j < q.size(); ++j) {
    const double off = q[j] - problem.reference[j];
    sum += problem.weights[j] * off * off;
  }
  return sum;
}

}  // namespace

Projection project(const ProjectionProblem& problem, const double* seed) {
  const std::size_t n = static_cast<std::size_t>(problem.chain.n());
  Configuration q(seed, seed + n);
  for (std::size_t j = 0; j < n; ++j) q[j] = std::clamp(q[j], problem.lower[j], problem.upper[j]);
  Iteration iteration(problem);
  const bool is_met = iteration.restore(q, kFirstRestorations);
  double distance = squared_distance(problem, q), longest = problem.longest_step;
  for (int i = 0; is_met && i < problem.max_iterations; ++i) {
    iteration.linearize(q);
    const std::vector<double> dq = iteration.step(q, longest, false);
    if (dq.empty()) break;
    Configuration next = q;
    iteration.add(dq, next);
    const double promised = distance - squared_distance(problem, next);
    if (promised < kSettled * kSettled) break;
    const bool is_back = iteration.restore(next, kRestorations);
    const double found = squared_distance(problem, next);
    const bool is_taken = is_back && distance - found >= kWorthwhile * promised;
    if (is_taken) {
      q = next;
      distance = found;
    }
    longest *= is_taken ? kLonger : kShorter;
    longest = std::min(longest, problem.longest_step);
    if (longest < kSettled) break;
  }
  return {q, distance, is_met};
}

}  // namespace apc
