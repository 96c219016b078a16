//! \file
//! Proof of edges by adaptive bisection, eight intervals at a time.
#include <algorithm>
#include <cmath>

#include "collision/checker.hpp"
#include "collision/interval_queue.hpp"
#include "collision/workspace.hpp"
#include "simd/dispatch.hpp"

namespace apc {
namespace {

using simd8::kLanes;

//! Margins with what single precision may be off, for configurations whose prismatic joints stay within
//! +-travel (summed).
void set_margins(simd8::Batch& batch, const Robot& robot, const World& world, double margin, double travel) {
  const double position = robot.rounding(travel), reach = robot.reach(travel);
  batch.world_margin = static_cast<float>(margin + position + world.rounding(reach));
  batch.self_margin = static_cast<float>(margin + robot.self_rounding(travel));
  const double turned =
      20.0 * simd8::kUnitRoundoff * robot.single_precision().n_joints;  // an axis' direction
  batch.lever_error = static_cast<float>(2.0 * position + 2.0 * turned * reach);
}

double travel_of(const Robot& robot, const double* q) {
  double travel = 0.0;
  for (const Joint& joint : robot.chain().joints())
    if (joint.type == JointKind::prismatic) travel += std::abs(q[joint.q_index]);
  return travel;
}

// Rounded up: the products and sums of the bound on motions are in single precision.
constexpr double kUp = 1.0 + 1e-5;

//! One edge q0 + t (q1 - q0) as batches for the batch test.
class Edge {
 public:
  Edge(const Checker& checker, const double* q0, const double* q1, double margin, const double* slack,
       double resolution)
      : robot_(checker.robot().single_precision()),
        world_(checker.world().single_precision()),
        scratch_(workspace_.scratch(simd8::scratch_bytes(robot_))) {
    for (int j = 0; j < checker.n(); ++j) batch_.q0[j] = q0[j], batch_.dq[j] = q1[j] - q0[j];
    const Robot& robot = checker.robot();
    const double travel = std::max(travel_of(robot, q0), travel_of(robot, q1));
    set_margins(batch_, robot, checker.world(), margin, travel);
    batch_.resolution = static_cast<float>(resolution);
    batch_.is_edge = true;
    for (int k = 0; k < robot_.n_joints; ++k) {
      const int j = robot_.joints[k].q_index;
      batch_.speed[k] = static_cast<float>(kUp * std::abs(batch_.dq[j]));
      batch_.slack[k] = slack ? static_cast<float>(kUp * slack[j]) : 0.0f;
    }
  }

  //! Doubtful: the first eight midpoints are looked at before anything is proven, without bounding motions.
  EdgeReport check(bool is_doubtful) {
    EdgeReport report;
    IntervalQueue queue(workspace_.intervals);
    for (bool is_first = true; queue.pending() > 0; is_first = false) {
      Interval lanes[kLanes];
      queue.take(lanes);
      fill_batch(lanes);
      report.n_configurations += kLanes;
      simd8::BatchResult result;
      const bool looks = is_first && is_doubtful;
      if ((looks && hits(lanes, false, result, report)) || hits(lanes, true, result, report)) break;
      for (int i = 0; i < kLanes; ++i)
        if (result.world[i] | result.self[i])
          queue.halve({lanes[i].middle, lanes[i].half, result.world[i], result.self[i]});
    }
    return report;
  }

 private:
  //! Tests the batch, its intervals or their midpoints alone. A hit goes into the report.
  bool hits(const Interval* lanes, bool moves, simd8::BatchResult& result, EdgeReport& report) {
    batch_.moves = moves;
    test_(robot_, world_, batch_, scratch_, result);
    if (result.hit_lane < 0) return false;
    report.free = false;
    report.t = lanes[result.hit_lane].middle;
    report.frame = result.frame, report.kind = static_cast<ContactKind>(result.kind),
    report.index = result.index;
    return true;
  }

  void fill_batch(const Interval* lanes) {
    for (int i = 0; i < kLanes; ++i) {
      batch_.middle[i] = lanes[i].middle;
      batch_.half_width[i] = static_cast<float>(lanes[i].half);
      batch_.world[i] = lanes[i].world;
      batch_.self[i] = lanes[i].self;
    }
  }

  const simd8::RobotData& robot_;
  const simd8::WorldData world_;
  const simd8::Test test_ = collision_test();
  Workspace& workspace_ = Workspace::mine();
  void* const scratch_;
  simd8::Batch batch_;
};

}  // namespace

EdgeReport Checker::check_edge(const double* q0, const double* q1, double margin, const double* slack,
                               double resolution, bool is_doubtful) const {
  return Edge(*this, q0, q1, margin, slack, resolution).check(is_doubtful);
}

int Checker::first_blocked_edge(const double* Q, int n_rows, double margin, const double* slack,
                                double resolution) const {
  const std::size_t n = static_cast<std::size_t>(this->n());
  bool are_proven[kLanes] = {};
  for (int i = 0; i + 1 < n_rows; ++i) {
    const double* q = Q + static_cast<std::size_t>(i) * n;
    const double* loose = slack ? slack + static_cast<std::size_t>(i) * n : nullptr;
    const int lane = i % kLanes;
    if (lane == 0) {
      std::fill_n(are_proven, kLanes, false);
      if (i + kLanes < n_rows) prove_edges(q, margin, loose, resolution, are_proven);
    }
    if (!are_proven[lane] && !check_edge(q, q + n, margin, loose, resolution).free) return i;
  }
  return -1;
}

void Checker::prove_edges(const double* Q, double margin, const double* slack, double resolution,
                          bool* are_proven) const {
  const std::size_t n = static_cast<std::size_t>(this->n());
  const simd8::RobotData& robot = robot_.single_precision();
  simd8::Batch batch;
  alignas(64) double middles[kMaxJoints][kLanes];
  batch.q = middles;
  batch.is_edge = false;
  batch.moves = true;
  batch.resolution = static_cast<float>(resolution);
  double way[kMaxJoints] = {}, loose[kMaxJoints] = {}, travel = travel_of(robot_, Q);
  for (int i = 0; i < kLanes; ++i) {
    const double *q0 = Q + static_cast<std::size_t>(i) * n, *q1 = q0 + n;
    for (std::size_t j = 0; j < n; ++j) {
      middles[j][i] = 0.5 * (q0[j] + q1[j]);
      way[j] = std::max(way[j], std::abs(q1[j] - q0[j]));
      if (slack) loose[j] = std::max(loose[j], slack[static_cast<std::size_t>(i) * n + j]);
    }
    travel = std::max(travel, travel_of(robot_, q1));
    batch.world[i] = batch.self[i] = ~simd8::Frames{0};
    batch.half_width[i] = 0.5f;
  }
  for (int k = 0; k < robot.n_joints; ++k) {
    const int j = robot.joints[k].q_index;
    batch.speed[k] = static_cast<float>(kUp * way[j]);
    batch.slack[k] = static_cast<float>(kUp * loose[j]);
  }
  set_margins(batch, robot_, world_, margin, travel);
  simd8::BatchResult result;
  void* scratch = Workspace::mine().scratch(simd8::scratch_bytes(robot));
  collision_test()(robot, world_.single_precision(), batch, scratch, result);
  for (int i = 0; i < kLanes; ++i) are_proven[i] = !(result.world[i] | result.self[i]);
}

void Checker::are_free(const double* Q, int n_rows, double margin, bool* out) const {
  const int n = this->n();
  simd8::Batch batch;
  alignas(64) double columns[kMaxJoints][kLanes];
  batch.q = columns;
  batch.is_edge = batch.moves = false;
  const simd8::Test test = collision_test();
  void* scratch = Workspace::mine().scratch(simd8::scratch_bytes(robot_.single_precision()));
  for (int first = 0; first < n_rows;) {
    const int n_lanes = std::min(kLanes, n_rows - first);
    double travel = 0.0;
    for (int i = 0; i < kLanes; ++i) {
      const double* q = Q + n * static_cast<std::size_t>(first + std::min(i, n_lanes - 1));
      for (int j = 0; j < n; ++j) columns[j][i] = q[j];
      travel = std::max(travel, travel_of(robot_, q));
      batch.world[i] = batch.self[i] = i < n_lanes ? ~simd8::Frames{0} : 0;
      batch.half_width[i] = 0.0f;
    }
    set_margins(batch, robot_, world_, margin, travel);
    simd8::BatchResult result;
    test(robot_.single_precision(), world_.single_precision(), batch, scratch, result);
    for (int i = 0; i < n_lanes; ++i) out[first + i] = !(result.world[i] | result.self[i]);
    first += n_lanes;
  }
}

}  // namespace apc
