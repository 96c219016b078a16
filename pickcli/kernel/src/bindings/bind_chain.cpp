//! \file
//! pickcli.kernel.Chain and its enumerations.
#include <algorithm>

#include "bindings/bindings.hpp"

#include "bindings/arrays.hpp"
#include "kinematics/inverse_dynamics.hpp"
#include "kinematics/line_following.hpp"
#include "kinematics/resolved_rate.hpp"

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
    joints.push_back({static_cast<JointKind>(types[k]),
                      to_pose(&poses[16 * k], {"T_parent_joint", k}),
                      {axes[3 * k], axes[3 * k + 1], axes[3 * k + 2]},
                      q_index[k]});
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

nb::tuple tip_motion(const Chain& chain, nb::handle Q_in, nb::handle dQ_in, nb::handle ddQ_in,
                     nb::handle tip_in) {
  const Doubles Q(Q_in, "Q", {kAny, chain.n()});
  const Py_ssize_t rows = Q.rows();
  const Doubles dQ(dQ_in, "dQ", {rows, chain.n()}), ddQ(ddQ_in, "ddQ", {rows, chain.n()});
  const Doubles tip(tip_in, "T_last_tip", {4, 4});
  const Pose T_last_tip = to_pose(tip.data(), "T_last_tip");
  const std::size_t N = static_cast<std::size_t>(rows), n = static_cast<std::size_t>(chain.n());
  std::vector<double> poses(16 * N), motions(12 * N);
  {
    nb::gil_scoped_release unlocked;
    std::vector<Pose> frames(static_cast<std::size_t>(chain.n_frames()));
    for (std::size_t i = 0; i < N; ++i) {
      chain.fk(Q.data() + i * n, frames.data());
      const Pose T_world_tip = frames.back() * T_last_tip;
      write_pose(T_world_tip, &poses[16 * i]);
      const Motion at = chain.tip_motion(frames.data(), T_world_tip.p, dQ.data() + i * n, ddQ.data() + i * n);
      double* row = &motions[12 * i];
      for (const Vec3& v : {at.velocity, at.angular_velocity, at.acceleration, at.angular_acceleration}) {
        *row++ = v.x;
        *row++ = v.y;
        *row++ = v.z;
      }
    }
  }
  return nb::make_tuple(to_numpy(std::move(poses), {N, 4, 4}), to_numpy(std::move(motions), {N, 4, 3}));
}

//! The limits and weights of an IK call, kept alive with the problem that points to them.
struct IkArguments {
  IkArguments(const Chain& chain, nb::handle tip_in, nb::handle lower_in, nb::handle upper_in,
              nb::handle weights_in)
      : tip(tip_in, "T_last_tip", {4, 4}),
        lower(lower_in, "lower", {chain.n()}),
        upper(upper_in, "upper", {chain.n()}),
        weights(weights_in, "weights", {chain.n()}),
        problem{chain, to_pose(tip.data(), "T_last_tip"), lower.data(), upper.data(), weights.data()} {
    for (int j = 0; j < chain.n(); ++j) {
      if (lower[j] > upper[j])
        throw nb::value_error(("lower[" + std::to_string(j) + "] is above upper").c_str());
      if (!(weights[j] > 0.0))
        throw nb::value_error(("weights[" + std::to_string(j) + "] is not positive").c_str());
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
  if (!(position_tolerance > 0.0 && rotation_tolerance > 0.0))
    throw nb::value_error("tolerances must be positive");
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

std::vector<Pose> to_poses(const Doubles& rows, const char* name) {
  std::vector<Pose> poses;
  for (int i = 0; i < rows.rows(); ++i)
    poses.push_back(to_pose(&rows[16 * static_cast<std::size_t>(i)], {name, i}));
  return poses;
}

Deviation to_deviation(double position, double angle) {
  if (!(position > 0.0 && angle > 0.0)) throw nb::value_error("deviations must be positive");
  return {position, angle};
}

std::vector<RigidBody> to_bodies(const Doubles& masses, const Doubles& centres, const Doubles& inertias) {
  std::vector<RigidBody> bodies;
  for (Py_ssize_t k = 0; k < masses.rows(); ++k) {
    RigidBody body{masses[k], {centres[3 * k], centres[3 * k + 1], centres[3 * k + 2]}, {}};
    std::copy_n(&inertias[9 * k], 9, body.inertia.m.begin());
    bodies.push_back(body);
  }
  return bodies;
}

nb::object inverse_dynamics(const Chain& chain, nb::handle Q_in, nb::handle dQ_in, nb::handle ddQ_in,
                            nb::handle masses_in, nb::handle centres_in, nb::handle inertias_in,
                            double gravity) {
  const Doubles Q(Q_in, "Q", {kAny, chain.n()});
  const Py_ssize_t rows = Q.rows(), L = chain.n_frames();
  const Doubles dQ(dQ_in, "dQ", {rows, chain.n()}), ddQ(ddQ_in, "ddQ", {rows, chain.n()});
  const Doubles masses(masses_in, "masses", {L}), centres(centres_in, "centres", {L, 3});
  const Doubles inertias(inertias_in, "inertias", {L, 3, 3});
  const std::size_t N = static_cast<std::size_t>(rows), n = static_cast<std::size_t>(chain.n());
  InverseDynamics dynamics(chain, to_bodies(masses, centres, inertias));
  std::vector<double> out(N * n);
  {
    nb::gil_scoped_release unlocked;
    for (std::size_t i = 0; i < N; ++i)
      dynamics.efforts(Q.data() + i * n, dQ.data() + i * n, ddQ.data() + i * n, gravity, &out[i * n]);
  }
  return to_numpy(std::move(out), {N, n});
}

nb::object tips(const Chain& chain, nb::handle Q_in, nb::handle tip_in) {
  const Doubles Q(Q_in, "Q", {kAny, chain.n()}), tip(tip_in, "T_last_tip", {4, 4});
  const Pose T_last_tip = to_pose(tip.data(), "T_last_tip");
  const std::size_t N = static_cast<std::size_t>(Q.rows()), n = static_cast<std::size_t>(chain.n());
  std::vector<double> out(16 * N);
  {
    nb::gil_scoped_release unlocked;
    std::vector<Pose> frames(static_cast<std::size_t>(chain.n_frames()));
    for (std::size_t i = 0; i < N; ++i) {
      chain.fk(Q.data() + i * n, frames.data());
      write_pose(frames.back() * T_last_tip, &out[16 * i]);
    }
  }
  return to_numpy(std::move(out), {N, 4, 4});
}

nb::object chords_of_line(const Chain& chain, nb::handle Q_in, nb::handle poses_in, nb::handle tip_in,
                          double position, double angle) {
  const Doubles Q(Q_in, "Q", {kAny, chain.n()}), poses(poses_in, "T_world_tips", {Q.rows(), 4, 4});
  const Doubles tip(tip_in, "T_last_tip", {4, 4});
  if (Q.rows() == 0) throw nb::value_error("Q: a line has at least one configuration");
  const std::vector<Pose> line = to_poses(poses, "T_world_tips");
  const Pose T_last_tip = to_pose(tip.data(), "T_last_tip");
  const Deviation most = to_deviation(position, angle);
  std::vector<std::int32_t> kept;
  {
    nb::gil_scoped_release unlocked;
    for (int i : longest_chords(chain, T_last_tip, Q.data(), line, most)) kept.push_back(i);
  }
  const std::size_t n_kept = kept.size();
  return to_numpy(std::move(kept), {n_kept});
}

nb::tuple deviation_of(nb::handle poses_in) {
  const Doubles poses(poses_in, "T_world_tips", {kAny, 4, 4});
  if (poses.rows() < 2) throw nb::value_error("T_world_tips: a line has two ends");
  const Deviation most = line_deviation(to_poses(poses, "T_world_tips"));
  return nb::make_tuple(most.position, most.angle);
}

nb::tuple follow_targets(const Chain& chain, nb::handle targets_in, nb::handle tip, nb::handle q0_in,
                         nb::handle lower, nb::handle upper, nb::handle weights, nb::handle max_step_in,
                         double position, double angle) {
  const Doubles targets(targets_in, "T_world_targets", {kAny, 4, 4}), q0(q0_in, "q0", {chain.n()});
  const Doubles max_step(max_step_in, "max_step", {chain.n()});
  IkArguments arguments(chain, tip, lower, upper, weights);
  const std::vector<Pose> poses = to_poses(targets, "T_world_targets");
  const Deviation most = to_deviation(position, angle);
  FollowPath path;
  {
    nb::gil_scoped_release unlocked;
    path = follow(arguments.problem, poses, q0.data(), max_step.data(), most);
  }
  return nb::make_tuple(to_numpy_rows(path.configurations, chain.n()), path.reason,
                        nb::make_tuple(path.off.position, path.off.angle));
}

void check_velocities(const Doubles& velocity) {
  for (std::size_t j = 0; j < velocity.size(); ++j)
    if (!(velocity[j] > 0.0)) throw nb::value_error(("velocity[" + std::to_string(j) + "] is not positive").c_str());
}

nb::object resolved_rates(const Chain& chain, nb::handle Q_in, nb::handle own_in, nb::handle twists_in,
                          nb::handle tip_in, nb::handle velocity_in) {
  const Doubles Q(Q_in, "Q", {kAny, chain.n()});
  const Py_ssize_t rows = Q.rows();
  const Doubles own(own_in, "own", {rows, chain.n()}), twists(twists_in, "twists", {rows, 6});
  const Doubles tip(tip_in, "T_last_tip", {4, 4}), velocity(velocity_in, "velocity", {chain.n()});
  check_velocities(velocity);
  ResolvedRate arm(chain, to_pose(tip.data(), "T_last_tip"), velocity.data());
  const std::size_t N = static_cast<std::size_t>(rows), n = static_cast<std::size_t>(chain.n());
  std::vector<double> out(N * n);
  {
    nb::gil_scoped_release unlocked;
    for (std::size_t i = 0; i < N; ++i)
      arm.rate(Q.data() + i * n, own.data() + i * n, twists.data() + 6 * i, &out[i * n]);
  }
  return to_numpy(std::move(out), {N, n});
}

nb::tuple track_tip(const Chain& chain, nb::handle times_in, nb::handle own_in, nb::handle poses_in,
                    nb::handle twists_in, nb::handle own_between_in, nb::handle twists_between_in, int met,
                    nb::handle q_in, nb::handle tip_in, nb::handle lower_in, nb::handle upper_in,
                    nb::handle velocity_in, double fastest) {
  const Doubles times(times_in, "times", {kAny});
  const Py_ssize_t N = times.rows(), n = chain.n();
  if (N < 2) throw nb::value_error("times: a motion has two ends");
  for (Py_ssize_t k = 1; k < N; ++k)
    if (!(times[k] > times[k - 1])) throw nb::value_error("times: not increasing");
  if (met < 0 || met >= N) throw nb::value_error("met: no index of the times");
  if (!(fastest > 0.0)) throw nb::value_error("fastest: not positive");
  const Doubles own(own_in, "own", {N, n}), poses(poses_in, "T_world_tips", {N, 4, 4});
  const Doubles twists(twists_in, "twists", {N, 6}), own_between(own_between_in, "own_between", {N - 1, n});
  const Doubles twists_between(twists_between_in, "twists_between", {N - 1, 6}), q(q_in, "q_met", {n});
  const Doubles tip(tip_in, "T_last_tip", {4, 4}), lower(lower_in, "lower", {n}), upper(upper_in, "upper", {n});
  const Doubles velocity(velocity_in, "velocity", {n});
  check_velocities(velocity);
  ResolvedRate arm(chain, to_pose(tip.data(), "T_last_tip"), velocity.data());
  const WantedMotion wanted{{times.data(), times.data() + N}, to_poses(poses, "T_world_tips"), own.data(),
                            twists.data(), own_between.data(), twists_between.data()};
  TrackedPath path;
  {
    nb::gil_scoped_release unlocked;
    path = track(arm, velocity.data(), wanted, met, q.data(), {lower.data(), upper.data(), fastest});
  }
  const std::size_t rows = static_cast<std::size_t>(N), columns = static_cast<std::size_t>(n);
  return nb::make_tuple(to_numpy(std::move(path.Q), {rows, columns}), path.end, path.at, path.joint);
}

}  // namespace

void bind_chain(nb::module_& m) {
  nb::enum_<JointKind>(m, "JointKind", nb::is_arithmetic(), "How a joint moves its child.")
      .value("REVOLUTE", JointKind::revolute, "About its axis, with limits or without.")
      .value("PRISMATIC", JointKind::prismatic, "Along its axis.")
      .value("FIXED", JointKind::fixed, "Not at all.");
  nb::enum_<FollowEnd>(m, "FollowEnd", nb::is_arithmetic(), "Why following a row of poses ended.")
      .value("DONE", FollowEnd::done, "All were reached.")
      .value("NO_CONVERGENCE", FollowEnd::no_convergence, "No configuration was found for the next one.")
      .value("JOINT_STEP", FollowEnd::joint_step, "A joint would step over the largest step.")
      .value("LIMIT", FollowEnd::limit,
             "None was found for the next one, with a joint pressed against a limit.")
      .value("OFF_LINE", FollowEnd::off_line, "The tip would leave the line on the way to the next one.");
  nb::enum_<TrackEnd>(m, "TrackEnd", nb::is_arithmetic(), "Why tracking a motion of the tip ended.")
      .value("DONE", TrackEnd::done, "All of it was tracked.")
      .value("SINGULAR", TrackEnd::singular, "A joint would be many times too fast.")
      .value("LIMIT", TrackEnd::limit, "A joint would be beyond a limit.");
  m.def("line_deviation", &deviation_of, "T_world_tips"_a,
        nb::sig("def line_deviation(T_world_tips: " APC_F64 ") -> tuple[float, float]"),
        R"(How far poses leave the straight line from the first to the last, at most.

Args:
    T_world_tips: (N, 4, 4) m, N at least 2.

Returns:
    m from the nearest point of the line; rad from how a steady turn about one axis stands there.)");
  nb::class_<Chain>(m, "Chain",
                    R"(A serial chain: at most 63 joints, of which at most 32 entries of q move any.

Frame k is the child link of joint k; the parent of joint k is frame k-1, that of joint 0 the world.)")
      .def(
          "__init__",
          [](Chain* self, nb::handle types, nb::handle poses, nb::handle axes, nb::handle q_index) {
            new (self) Chain(make_chain(types, poses, axes, q_index));
          },
          "joint_types"_a, "T_parent_joint"_a, "axes"_a, "q_index"_a,
          nb::sig("def __init__(self, joint_types: " APC_I32 ", T_parent_joint: " APC_F64 ", axes: " APC_F64
                  ", q_index: " APC_I32 ") -> None"),
          R"(Make a chain from the base outwards.

Args:
    joint_types: (L,) of JointKind.
    T_parent_joint: (L, 4, 4) m, pose of the joint frame in frame k-1 (k = 0: in the world) at position 0.
    axes: (L, 3) in the joint frame, normalised here; ignored for fixed joints.
    q_index: (L,) entry of q that moves the joint, -1 for fixed ones; every entry 0..n-1 is used.

Raises:
    ValueError: What is given is no chain; names the argument.)")
      .def_prop_ro("n", &Chain::n, "Length of a configuration.")
      .def_prop_ro("n_frames", &Chain::n_frames, "Number of frames L.")
      .def(
          "fk",
          [](const Chain& self, nb::handle q) {
            return fk_batch(self, Doubles(q, "q", {self.n()}).data(), 1, true);
          },
          "q"_a, nb::sig("def fk(self, q: " APC_F64 ") -> " APC_F64),
          "Poses (L, 4, 4) of all frames in the world, in m, at q (n,) in rad or m.")
      .def(
          "fk_batch",
          [](const Chain& self, nb::handle Q_in) {
            const Doubles Q(Q_in, "Q", {kAny, self.n()});
            return fk_batch(self, Q.data(), static_cast<std::size_t>(Q.rows()), false);
          },
          "Q"_a, nb::sig("def fk_batch(self, Q: " APC_F64 ") -> " APC_F64),
          "Poses (N, L, 4, 4) of all frames in the world, in m, at each of the configurations Q (N, n).")
      .def("tips", &tips, "Q"_a, "T_last_tip"_a,
           nb::sig("def tips(self, Q: " APC_F64 ", T_last_tip: " APC_F64 ") -> " APC_F64),
           R"(Poses of the tip.

Args:
    Q: (N, n) configurations in rad or m.
    T_last_tip: (4, 4) pose of the tip in frame L-1, m.

Returns:
    (N, 4, 4) in the world, in m.)")
      .def("jacobian", &jacobian, "q"_a, "T_last_tip"_a,
           nb::sig("def jacobian(self, q: " APC_F64 ", T_last_tip: " APC_F64 ") -> " APC_F64),
           R"(Jacobian of the tip.

Args:
    q: (n,) configuration in rad or m.
    T_last_tip: (4, 4) pose of the tip in frame L-1, m.

Returns:
    (6, n): linear x y z in m, then angular x y z in rad, both along the axes of the world.)")
      .def("tip_motion", &tip_motion, "Q"_a, "dQ"_a, "ddQ"_a, "T_last_tip"_a,
           nb::sig("def tip_motion(self, Q: " APC_F64 ", dQ: " APC_F64 ", ddQ: " APC_F64
                   ", T_last_tip: " APC_F64 ") -> tuple[" APC_F64 ", " APC_F64 "]"),
           R"(Poses and motion of the tip along a path or trajectory, in the axes of the world.

Args:
    Q: (N, n) configurations in rad or m.
    dQ: (N, n) their first derivatives by time or by a path's parameter.
    ddQ: (N, n) their second derivatives by the same.
    T_last_tip: (4, 4) pose of the tip in frame L-1, m.

Returns:
    Poses (N, 4, 4) of the tip in the world, and motions (N, 4, 3), whose rows are velocity, angular velocity,
    acceleration and angular acceleration, in m and rad per the derivatives' unit.)")
      .def("resolved_rates", &resolved_rates, "Q"_a, "own"_a, "twists"_a, "T_last_tip"_a, "velocity"_a,
           nb::sig("def resolved_rates(self, Q: " APC_F64 ", own: " APC_F64 ", twists: " APC_F64
                   ", T_last_tip: " APC_F64 ", velocity: " APC_F64 ") -> " APC_F64),
           R"(Joint velocities that move the tip as wanted, those of least norm besides given ones (Whitney 1969).

Args:
    Q: (N, n) configurations in rad or m.
    own: (N, n) velocities that the joints have anyway, per s.
    twists: (N, 6) wanted of the tip along the axes of the world: m/s, then rad/s.
    T_last_tip: (4, 4) pose of the tip in frame L-1, m.
    velocity: (n,) > 0, limits by which the velocities of the joints are measured.

Returns:
    (N, n) per s. In a singular configuration they give another twist, or are not finite.)")
      .def("track_tip", &track_tip, "times"_a, "own"_a, "T_world_tips"_a, "twists"_a, "own_between"_a,
           "twists_between"_a, "met"_a, "q_met"_a, "T_last_tip"_a, "lower"_a, "upper"_a, "velocity"_a, "fastest"_a,
           nb::sig("def track_tip(self, times: " APC_F64 ", own: " APC_F64 ", T_world_tips: " APC_F64
                   ", twists: " APC_F64 ", own_between: " APC_F64 ", twists_between: " APC_F64
                   ", met: int, q_met: " APC_F64 ", T_last_tip: " APC_F64 ", lower: " APC_F64 ", upper: " APC_F64
                   ", velocity: " APC_F64 ", fastest: float) -> tuple[" APC_F64 ", TrackEnd, int, int]"),
           R"(Configurations along a motion of the tip, by integration of ``resolved_rates`` from one of them.

Each step, by Runge and Kutta of the fourth order, is followed by one of least norm onto the pose.

Args:
    times: (N,) s, increasing, N at least 2.
    own: (N, n) velocities that the joints have anyway, per s.
    T_world_tips: (N, 4, 4) m, wanted poses of the tip.
    twists: (N, 6) wanted of the tip along the axes of the world: m/s, then rad/s.
    own_between: (N-1, n) the same half-way between the times.
    twists_between: (N-1, 6) the same half-way between the times.
    met: Index of the time at which the configuration is known.
    q_met: (n,) rad or m, that configuration.
    T_last_tip: (4, 4) pose of the tip in frame L-1, m.
    lower: (n,) rad or m.
    upper: (n,) rad or m.
    velocity: (n,) > 0, limits by which the velocities of the joints are measured.
    fastest: Times these limits, from which on the arm counts as singular.

Returns:
    (N, n) configurations, not all of them known unless it was done; why it ended; if it was not done, the
    index of the time that was not reached, and the joint that is farthest beyond its limit there.)")
      .def("inverse_dynamics", &inverse_dynamics, "Q"_a, "dQ"_a, "ddQ"_a, "masses"_a, "centres"_a, "inertias"_a,
           "gravity"_a,
           nb::sig("def inverse_dynamics(self, Q: " APC_F64 ", dQ: " APC_F64 ", ddQ: " APC_F64 ", masses: " APC_F64
                   ", centres: " APC_F64 ", inertias: " APC_F64 ", gravity: float) -> " APC_F64),
           R"(Efforts of the joints that move rigid links as required, by the equations of Newton and Euler.

Args:
    Q: (N, n) configurations in rad or m.
    dQ: (N, n) their first derivatives by time or by a path's parameter.
    ddQ: (N, n) their second derivatives by the same.
    masses: (L,) kg of the body fixed to each frame.
    centres: (L, 3) centre of mass in its frame, m.
    inertias: (L, 3, 3) about the centre of mass, in the axes of the frame, kg m^2.
    gravity: Acceleration along -z of the world, m/s^2.

Returns:
    (N, n) Nm, or N of prismatic joints.)")
      .def(
          "ik", &ik, "T_world_target"_a, "T_last_tip"_a, "seeds"_a, "lower"_a, "upper"_a, "weights"_a,
          "max_iterations"_a = 60, "position_tolerance"_a = 1e-5, "rotation_tolerance"_a = 1e-4,
          "distinct"_a = 0.05,
          nb::sig("def ik(self, T_world_target: " APC_F64 ", T_last_tip: " APC_F64 ", seeds: " APC_F64
                  ", lower: " APC_F64 ", upper: " APC_F64 ", weights: " APC_F64
                  ", max_iterations: int = 60, position_tolerance: float = 1e-05, "
                  "rotation_tolerance: float = 0.0001, distinct: float = 0.05) -> " APC_F64),
          R"(Configurations that bring the tip to a pose, found from seeds.

By damped least squares (Levenberg-Marquardt). Deterministic: the same arguments give the same bits.

Args:
    T_world_target: (4, 4) where the tip is to be, m.
    T_last_tip: (4, 4) pose of the tip in frame L-1, m.
    seeds: (K, n) configurations to start from.
    lower: (n,) limits that all solutions keep.
    upper: (n,) limits that all solutions keep.
    weights: (n,) > 0; a joint with a larger one moves less.
    max_iterations: For each seed.
    position_tolerance: m.
    rotation_tolerance: rad.
    distinct: rad or m; a solution within it of an earlier one in every joint is left out.

Returns:
    (M, n) in the order of their seeds.)")
      .def("follow", &follow_targets, "T_world_targets"_a, "T_last_tip"_a, "q0"_a, "lower"_a, "upper"_a,
           "weights"_a, "max_step"_a, "position_deviation"_a, "angle_deviation"_a,
           nb::sig("def follow(self, T_world_targets: " APC_F64 ", T_last_tip: " APC_F64 ", q0: " APC_F64
                   ", lower: " APC_F64 ", upper: " APC_F64 ", weights: " APC_F64 ", max_step: " APC_F64
                   ", position_deviation: float, angle_deviation: float) -> tuple[" APC_F64
                   ", FollowEnd, tuple[float, float]]"),
           R"(Follow a row of poses, each solved from the solution before it.

Args:
    T_world_targets: (P, 4, 4) where the tip is to be, one after the other, m.
    T_last_tip: (4, 4) pose of the tip in frame L-1, m.
    q0: (n,) where the arm comes from.
    lower: (n,) limits that all configurations keep.
    upper: (n,) limits that all configurations keep.
    weights: (n,) > 0; a joint with a larger one moves less.
    max_step: (n,) rad or m, largest step of each joint from one pose to the next, and from q0 to the first.
    position_deviation: m that the tip may be off half-way between two poses.
    angle_deviation: rad that it may be off there.

Returns:
    Configurations (n_done, n) of the first n_done poses, why it ended, and by how many m and rad the tip was off
    half-way at the end.)")
      .def("longest_chords", &chords_of_line, "Q"_a, "T_world_tips"_a, "T_last_tip"_a,
           "position_deviation"_a, "angle_deviation"_a,
           nb::sig("def longest_chords(self, Q: " APC_F64 ", T_world_tips: " APC_F64 ", T_last_tip: " APC_F64
                   ", position_deviation: float, angle_deviation: float) -> " APC_I32),
           R"(The waypoints on a straight line that are enough: joint chords between them stay near it.

Args:
    Q: (N, n) configurations that follow the line, N at least 1.
    T_world_tips: (N, 4, 4) poses of the tip on the line, m.
    T_last_tip: (4, 4) pose of the tip in frame L-1, m.
    position_deviation: m that the tip may be off the line, however far along it.
    angle_deviation: rad that it may be off the pose at the same place.

Returns:
    Indices (M,) of rows of Q, the first and the last among them.)");
}

}  // namespace apc
