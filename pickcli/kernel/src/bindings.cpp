// The Python module pickcli.kernel._kernel. What each function means is documented in _kernel.pyi.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/string.h>

#include <memory>

#include "arrays.hpp"
#include "checker.hpp"
#include "ik.hpp"

namespace apc {
namespace {

using namespace nb::literals;

Chain make_chain(nb::handle types_in, nb::handle poses_in, nb::handle axes_in, nb::handle q_index_in) {
  const Integers types(types_in, "joint_types", {kAny});
  const Py_ssize_t n = types.rows();
  const Doubles poses(poses_in, "T_parent_joint", {n, 4, 4}), axes(axes_in, "axes", {n, 3});
  const Integers q_index(q_index_in, "q_index", {n});
  std::vector<Joint> joints;
  for (Py_ssize_t k = 0; k < n; ++k) {
    if (types[k] < 0 || types[k] > 2)
      throw nb::value_error("joint_types: 0 is revolute, 1 prismatic, 2 fixed; there is nothing else");
    joints.push_back({static_cast<JointType>(types[k]), to_pose(&poses[16 * k], "T_parent_joint[" + std::to_string(k) + "]"),
                      {axes[3 * k], axes[3 * k + 1], axes[3 * k + 2]}, q_index[k]});
  }
  return Chain(std::move(joints));
}

nb::object fk_batch(const Chain& chain, const double* Q, std::size_t n_rows, bool is_single) {
  const std::size_t L = static_cast<std::size_t>(chain.n_frames()), n = static_cast<std::size_t>(chain.n());
  std::vector<double> out(n_rows * L * 16);
  {
    nb::gil_scoped_release unlocked;
    std::vector<Pose> frames(L);
    for (std::size_t i = 0; i < n_rows; ++i) {
      chain.fk(Q + i * n, frames.data());
      for (std::size_t k = 0; k < L; ++k) write_pose(frames[k], &out[16 * (i * L + k)]);
    }
  }
  return is_single ? to_numpy(std::move(out), {L, 4, 4}) : to_numpy(std::move(out), {n_rows, L, 4, 4});
}

nb::object jacobian(const Chain& chain, nb::handle q_in, nb::handle tip_in) {
  const Doubles q(q_in, "q", {chain.n()}), tip(tip_in, "T_last_tip", {4, 4});
  std::vector<Pose> frames(static_cast<std::size_t>(chain.n_frames()));
  std::vector<double> J(6 * static_cast<std::size_t>(chain.n()));
  chain.fk(q.data(), frames.data());
  chain.jacobian(frames.data(), frames.back() * to_pose(tip.data(), "T_last_tip").p, J.data());
  return to_numpy(std::move(J), {6, static_cast<std::size_t>(chain.n())});
}

// The limits and weights of an IK call, kept alive with the problem that points to them.
struct IkArguments {
  IkArguments(const Chain& chain, nb::handle tip_in, nb::handle lower_in, nb::handle upper_in, nb::handle weights_in)
      : tip(tip_in, "T_last_tip", {4, 4}), lower(lower_in, "lower", {chain.n()}), upper(upper_in, "upper", {chain.n()}),
        weights(weights_in, "weights", {chain.n()}),
        problem{chain, to_pose(tip.data(), "T_last_tip"), lower.data(), upper.data(), weights.data()} {
    for (int j = 0; j < chain.n(); ++j) {
      if (lower[j] > upper[j]) throw nb::value_error(("lower[" + std::to_string(j) + "] is above upper").c_str());
      if (!(weights[j] > 0.0)) throw nb::value_error(("weights[" + std::to_string(j) + "] is not positive").c_str());
    }
  }
  Doubles tip, lower, upper, weights;
  IkProblem problem;
};

nb::object to_numpy_rows(const std::vector<Configuration>& rows, int n) {
  std::vector<double> flat;
  for (const Configuration& q : rows) flat.insert(flat.end(), q.begin(), q.end());
  return to_numpy(std::move(flat), {rows.size(), static_cast<std::size_t>(n)});
}

nb::object ik(const Chain& chain, nb::handle target_in, nb::handle tip, nb::handle seeds_in, nb::handle lower,
              nb::handle upper, nb::handle weights, int max_iterations, double position_tolerance,
              double rotation_tolerance, double distinct) {
  const Doubles target(target_in, "T_world_target", {4, 4}), seeds(seeds_in, "seeds", {kAny, chain.n()});
  IkArguments arguments(chain, tip, lower, upper, weights);
  if (!(position_tolerance > 0.0 && rotation_tolerance > 0.0)) throw nb::value_error("tolerances must be positive");
  arguments.problem.max_iterations = max_iterations;
  arguments.problem.position_tolerance = position_tolerance;
  arguments.problem.rotation_tolerance = rotation_tolerance;
  const Pose T_world_target = to_pose(target.data(), "T_world_target");
  std::vector<Configuration> found;
  {
    nb::gil_scoped_release unlocked;
    found = solve_all(arguments.problem, T_world_target, seeds.data(), seeds.rows(), distinct);
  }
  return to_numpy_rows(found, chain.n());
}

nb::tuple follow_targets(const Chain& chain, nb::handle targets_in, nb::handle tip, nb::handle q0_in, nb::handle lower,
                         nb::handle upper, nb::handle weights, nb::handle max_step_in) {
  const Doubles targets(targets_in, "T_world_targets", {kAny, 4, 4}), q0(q0_in, "q0", {chain.n()});
  const Doubles max_step(max_step_in, "max_step", {chain.n()});
  IkArguments arguments(chain, tip, lower, upper, weights);
  std::vector<Pose> poses;
  for (int i = 0; i < targets.rows(); ++i)
    poses.push_back(to_pose(&targets[16 * static_cast<std::size_t>(i)], "T_world_targets[" + std::to_string(i) + "]"));
  FollowPath path;
  {
    nb::gil_scoped_release unlocked;
    path = follow(arguments.problem, poses, q0.data(), max_step.data());
  }
  return nb::make_tuple(to_numpy_rows(path.configurations, chain.n()), static_cast<int>(path.reason));
}

std::vector<Sphere> to_spheres(const Doubles& centers, const Doubles& radii) {
  std::vector<Sphere> spheres;
  for (std::size_t i = 0; i < radii.size(); ++i)
    spheres.push_back({{centers[3 * i], centers[3 * i + 1], centers[3 * i + 2]}, radii[i]});
  return spheres;
}

std::vector<int> to_ints(const Integers& values) { return {values.data(), values.data() + values.size()}; }

Robot make_robot(const Chain& chain, nb::handle centers_in, nb::handle radii_in, nb::handle frame_in,
                 nb::handle pairs_in) {
  const Doubles radii(radii_in, "radii", {kAny});
  const Doubles centers(centers_in, "centers", {radii.rows(), 3});
  const Integers frame(frame_in, "frame", {radii.rows()}), pairs(pairs_in, "self_pairs", {kAny, 2});
  std::vector<std::pair<int, int>> self_pairs;
  for (std::size_t i = 0; i + 1 < pairs.size(); i += 2) self_pairs.emplace_back(pairs[i], pairs[i + 1]);
  return Robot(chain, to_spheres(centers, radii), to_ints(frame), self_pairs);
}

void set_world(Checker& checker, nb::handle poses_in, nb::handle half_in, nb::handle group_in, nb::handle ignored_in) {
  const Integers group(group_in, "group", {kAny});
  const Py_ssize_t n = group.rows();
  const Doubles poses(poses_in, "T_world_box", {n, 4, 4}), half(half_in, "half_extents", {n, 3});
  const View<std::uint64_t> ignored(ignored_in, "ignored_frames", {n});
  std::vector<Box> boxes;
  for (Py_ssize_t b = 0; b < n; ++b)
    boxes.push_back({to_pose(&poses[16 * b], "T_world_box[" + std::to_string(b) + "]"),
                     {half[3 * b], half[3 * b + 1], half[3 * b + 2]}, group[b], ignored[b], static_cast<int>(b)});
  checker.set_world(World(std::move(boxes)));
}

void set_held(Checker& checker, nb::handle centers_in, nb::handle radii_in, nb::handle tested_in) {
  const Doubles radii(radii_in, "radii", {kAny});
  const Doubles centers(centers_in, "centers", {radii.rows(), 3});
  const Integers tested(tested_in, "tested_frames", {kAny});
  checker.robot().set_held(to_spheres(centers, radii), to_ints(tested));
}

void check_margin(double margin) {
  if (!(margin >= 0.0 && std::isfinite(margin))) throw nb::value_error("margin must not be negative");
}

void check_resolution(double resolution) {
  if (!(resolution >= 1e-6)) throw nb::value_error("resolution must be at least 1e-6 m");
}

// Half-widths of the tube, or none. Raises ValueError for a negative one.
class Slack {
 public:
  Slack(nb::handle object, std::initializer_list<Py_ssize_t> shape) {
    if (object.is_none()) return;
    values_ = std::make_unique<Doubles>(object, "slack", shape);
    for (std::size_t i = 0; i < values_->size(); ++i)
      if ((*values_)[i] < 0.0) throw nb::value_error("slack must not be negative");
  }
  const double* row(int i, int n) const { return values_ ? values_->data() + i * static_cast<std::size_t>(n) : nullptr; }

 private:
  std::unique_ptr<Doubles> values_;
};

// Single-precision angles lose their meaning beyond this; no joint gets there.
void check_range(const Doubles& q, const char* name) {
  for (std::size_t i = 0; i < q.size(); ++i)
    if (std::abs(q[i]) > 1e6) throw nb::value_error((std::string(name) + ": beyond 1e6 rad or m").c_str());
}

EdgeReport check_edge(const Checker& checker, nb::handle q0_in, nb::handle q1_in, double margin, nb::handle slack_in,
                      double resolution) {
  const Doubles q0(q0_in, "q0", {checker.n()}), q1(q1_in, "q1", {checker.n()});
  const Slack slack(slack_in, {checker.n()});
  check_range(q0, "q0");
  check_range(q1, "q1");
  check_margin(margin);
  check_resolution(resolution);
  return checker.check_edge(q0.data(), q1.data(), margin, slack.row(0, checker.n()), resolution);
}

bool edge_is_free(const Checker& checker, nb::handle q0, nb::handle q1, double margin, nb::handle slack,
                  double resolution) {
  return check_edge(checker, q0, q1, margin, slack, resolution).free;
}

int path_is_free(const Checker& checker, nb::handle Q_in, double margin, nb::handle slack_in, double resolution) {
  const int n = checker.n();
  const Doubles Q(Q_in, "Q", {kAny, n});
  if (Q.size() == 0) throw nb::value_error("Q: a path has at least one configuration");
  const Slack slack(slack_in, {Q.rows() - 1, n});
  check_range(Q, "Q");
  check_margin(margin);
  check_resolution(resolution);
  nb::gil_scoped_release unlocked;
  if (Q.rows() == 1) return checker.check_edge(Q.data(), Q.data(), margin, nullptr, resolution).free ? -1 : 0;
  for (int i = 0; i + 1 < Q.rows(); ++i) {
    const double* q = Q.data() + i * static_cast<std::size_t>(n);
    if (!checker.check_edge(q, q + n, margin, slack.row(i, n), resolution).free) return i;
  }
  return -1;
}

bool is_free(const Checker& checker, nb::handle q_in, double margin) {
  const Doubles q(q_in, "q", {checker.n()});
  check_range(q, "q");
  check_margin(margin);
  bool out;
  checker.are_free(q.data(), 1, margin, &out);
  return out;
}

nb::object are_free(const Checker& checker, nb::handle Q_in, double margin) {
  const Doubles Q(Q_in, "Q", {kAny, checker.n()});
  check_range(Q, "Q");
  check_margin(margin);
  const std::size_t n_rows = static_cast<std::size_t>(Q.rows());
  auto out = std::make_unique<bool[]>(n_rows);
  {
    nb::gil_scoped_release unlocked;
    checker.are_free(Q.data(), Q.rows(), margin, out.get());
  }
  bool* data = out.release();
  nb::capsule owner(data, [](void* p) noexcept { delete[] static_cast<bool*>(p); });
  return nb::cast(nb::ndarray<nb::numpy, bool>(data, {n_rows}, owner));
}

nb::tuple clearance(const Checker& checker, nb::handle q_in, double max_distance) {
  const Doubles q(q_in, "q", {checker.n()});
  const Contact c = checker.clearance(q.data(), max_distance);
  return nb::make_tuple(c.distance, c.frame, c.kind, c.index);
}

nb::object clearances(const Checker& checker, nb::handle Q_in, double max_distance) {
  const Doubles Q(Q_in, "Q", {kAny, checker.n()});
  std::vector<double> out(static_cast<std::size_t>(Q.rows()));
  {
    nb::gil_scoped_release unlocked;
    for (std::size_t i = 0; i < out.size(); ++i)
      out[i] = checker.clearance(Q.data() + i * static_cast<std::size_t>(checker.n()), max_distance).distance;
  }
  const std::size_t n_rows = out.size();
  return to_numpy(std::move(out), {n_rows});
}

void bind_chain(nb::module_& m) {
  nb::class_<Chain>(m, "Chain", "A serial chain of revolute, prismatic and fixed joints.")
      .def("__init__", [](Chain* self, nb::handle types, nb::handle poses, nb::handle axes, nb::handle q_index) {
             new (self) Chain(make_chain(types, poses, axes, q_index));
           }, "joint_types"_a, "T_parent_joint"_a, "axes"_a, "q_index"_a)
      .def_prop_ro("n", &Chain::n)
      .def_prop_ro("n_frames", &Chain::n_frames)
      .def("fk", [](const Chain& self, nb::handle q) {
             return fk_batch(self, Doubles(q, "q", {self.n()}).data(), 1, true);
           }, "q"_a)
      .def("fk_batch", [](const Chain& self, nb::handle Q_in) {
             const Doubles Q(Q_in, "Q", {kAny, self.n()});
             return fk_batch(self, Q.data(), static_cast<std::size_t>(Q.rows()), false);
           }, "Q"_a)
      .def("jacobian", &jacobian, "q"_a, "T_last_tip"_a)
      .def("ik", &ik, "T_world_target"_a, "T_last_tip"_a, "seeds"_a, "lower"_a, "upper"_a, "weights"_a,
           "max_iterations"_a = 60, "position_tolerance"_a = 1e-5, "rotation_tolerance"_a = 1e-4, "distinct"_a = 0.05)
      .def("follow", &follow_targets, "T_world_targets"_a, "T_last_tip"_a, "q0"_a, "lower"_a, "upper"_a, "weights"_a,
           "max_step"_a);
}

void bind_checker(nb::module_& m) {
  nb::class_<EdgeReport>(m, "EdgeReport", "Whether an edge is free, and if not, where and why.")
      .def_ro("free", &EdgeReport::free)
      .def_ro("t", &EdgeReport::t)
      .def_ro("frame", &EdgeReport::frame)
      .def_ro("kind", &EdgeReport::kind)
      .def_ro("index", &EdgeReport::index)
      .def_ro("n_configurations", &EdgeReport::n_configurations);
  nb::class_<Checker>(m, "Checker", "Collision checks of one robot in one world.")
      .def("__init__", [](Checker* self, const Chain& chain, nb::handle centers, nb::handle radii, nb::handle frame,
                          nb::handle self_pairs) {
             new (self) Checker(make_robot(chain, centers, radii, frame, self_pairs));
           }, "chain"_a, "centers"_a, "radii"_a, "frame"_a, "self_pairs"_a)
      .def_prop_ro("rounding", [](const Checker& self) {
             const Robot& robot = self.robot();
             return 2.0 * robot.rounding(1.0) + self.world().rounding(robot.reach(1.0));
           })
      .def("set_world", &set_world, "T_world_box"_a, "half_extents"_a, "group"_a, "ignored_frames"_a)
      .def("set_held", &set_held, "centers"_a, "radii"_a, "tested_frames"_a)
      .def("is_free", &is_free, "q"_a, "margin"_a = 0.0)
      .def("are_free", &are_free, "Q"_a, "margin"_a = 0.0)
      .def("edge_is_free", &edge_is_free, "q0"_a, "q1"_a, "margin"_a = 0.0, "slack"_a = nb::none(),
           "resolution"_a = 2e-4)
      .def("path_is_free", &path_is_free, "Q"_a, "margin"_a = 0.0, "slack"_a = nb::none(), "resolution"_a = 2e-4)
      .def("check_edge", &check_edge, "q0"_a, "q1"_a, "margin"_a = 0.0, "slack"_a = nb::none(),
           "resolution"_a = 2e-4)
      .def("clearance", &clearance, "q"_a, "max_distance"_a = 1.0)
      .def("clearances", &clearances, "Q"_a, "max_distance"_a = 1.0);
}

}  // namespace
}  // namespace apc

NB_MODULE(_kernel, m) {
  m.doc() = "Forward kinematics, inverse kinematics, clearance and proven edges of a serial chain.";
  apc::bind_chain(m);
  apc::bind_checker(m);
  m.def("simd", &apc::simd_name);
  m.def("set_simd", [](const std::string& name) { apc::set_simd(name.c_str()); }, nanobind::arg("name"));
}
