// Proof of edges by adaptive bisection, eight intervals at a time.
#include <algorithm>
#include <cmath>

#include "agenda.hpp"
#include "checker.hpp"
#include "dispatch.hpp"

namespace apc {
namespace {

using eight::kLanes;

// Margins with what single precision may be off, for configurations whose prismatic joints stay within
// +-travel (summed).
void set_margins(eight::Batch& batch, const Robot& robot, const World& world, double margin, double travel) {
  const double position = robot.rounding(travel), reach = robot.reach(travel);
  batch.world_margin = static_cast<float>(margin + position + world.rounding(reach));
  batch.self_margin = static_cast<float>(margin + robot.self_rounding(travel));
  const double turned = 20.0 * eight::kUnitRoundoff * robot.single().n_joints;  // an axis' direction
  batch.lever_error = static_cast<float>(2.0 * position + 2.0 * turned * reach);
}

double travel_of(const Robot& robot, const double* q) {
  double travel = 0.0;
  for (const Joint& joint : robot.chain().joints())
    if (joint.type == JointType::prismatic) travel += std::abs(q[joint.q_index]);
  return travel;
}

// One edge q0 + t (q1 - q0) as batches for the hot test.
class Edge {
 public:
  Edge(const Checker& checker, const double* q0, const double* q1, double margin, const double* slack,
       double resolution)
      : checker_(checker), q0_(q0), n_(checker.n()) {
    for (int j = 0; j < n_; ++j) dq_[j] = q1[j] - q0[j];
    const Robot& robot = checker.robot();
    const double travel = std::max(travel_of(robot, q0), travel_of(robot, q1));
    set_margins(batch_, robot, checker.world(), margin, travel);
    batch_.resolution = static_cast<float>(resolution);
    batch_.is_edge = true;
    // Rounded up: the products and sums of the bound are in single precision.
    constexpr double up = 1.0 + 1e-5;
    for (int k = 0; k < robot.single().n_joints; ++k) {
      const int j = robot.single().joints[k].q_index;
      batch_.speed[k] = static_cast<float>(up * std::abs(dq_[j]));
      batch_.slack[k] = slack ? static_cast<float>(up * slack[j]) : 0.0f;
    }
  }

  EdgeReport check() {
    EdgeReport report;
    Agenda agenda;
    while (agenda.pending() > 0) {
      Interval lanes[kLanes];
      agenda.take(lanes);
      const eight::Verdict verdict = test(lanes);
      report.n_configurations += kLanes;
      if (verdict.hit_lane >= 0) {
        report.free = false;
        report.t = lanes[verdict.hit_lane].middle;
        report.frame = verdict.frame, report.kind = verdict.kind, report.index = verdict.index;
        break;
      }
      for (int i = 0; i < kLanes; ++i)
        if (verdict.world[i] | verdict.self[i])
          agenda.halve({lanes[i].middle, lanes[i].half, verdict.world[i], verdict.self[i]});
    }
    return report;
  }

 private:
  eight::Verdict test(const Interval* lanes) {
    double middle[kLanes];
    for (int i = 0; i < kLanes; ++i) {
      middle[i] = lanes[i].middle;
      batch_.half_width[i] = static_cast<float>(lanes[i].half);
      batch_.world[i] = lanes[i].world;
      batch_.self[i] = lanes[i].self;
    }
    for (int j = 0; j < n_; ++j)
      for (int i = 0; i < kLanes; ++i) batch_.q[j][i] = q0_[j] + middle[i] * dq_[j];
    return run_eight(checker_.robot().single(), checker_.world().single(), batch_);
  }

  const Checker& checker_;
  const double* q0_;
  const int n_;
  double dq_[kMaxJoints];
  eight::Batch batch_;
};

}  // namespace

EdgeReport Checker::check_edge(const double* q0, const double* q1, double margin, const double* slack,
                               double resolution) const {
  return Edge(*this, q0, q1, margin, slack, resolution).check();
}

void Checker::are_free(const double* Q, int n_rows, double margin, bool* out) const {
  const int n = this->n();
  eight::Batch batch;
  batch.is_edge = false;
  for (int first = 0; first < n_rows;) {
    const int n_lanes = std::min(kLanes, n_rows - first);
    double travel = 0.0;
    for (int i = 0; i < kLanes; ++i) {
      const double* q = Q + n * static_cast<std::size_t>(first + std::min(i, n_lanes - 1));
      for (int j = 0; j < n; ++j) batch.q[j][i] = q[j];
      travel = std::max(travel, travel_of(robot_, q));
      batch.world[i] = batch.self[i] = i < n_lanes ? ~eight::Frames{0} : 0;
      batch.half_width[i] = 0.0f;
    }
    set_margins(batch, robot_, world_, margin, travel);
    const eight::Verdict verdict = run_eight(robot_.single(), world_.single(), batch);
    for (int i = 0; i < n_lanes; ++i) out[first + i] = !(verdict.world[i] | verdict.self[i]);
    first += n_lanes;
  }
}

}  // namespace apc
