//! \file
//! pickcli.kernel: JointState, ParabolicLimits, ParabolicSegment, ParabolicTrajectory, and steering.
#include "bindings/bindings.hpp"

#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/vector.h>

#include "bindings/arrays.hpp"
#include "timing/parabolic.hpp"

namespace apc {
namespace {

using namespace nb::literals;

std::vector<double> row_of(nb::handle in, const char* name, Py_ssize_t n = kAny) {
  const Doubles row(in, name, {n});
  return {row.data(), row.data() + row.size()};
}

nb::object to_row(std::vector<double> values) {
  const std::size_t n = values.size();
  return to_numpy(std::move(values), {n});
}

nb::object to_rows(std::vector<double> values, std::size_t n) {
  const std::size_t n_rows = values.size() / n;
  return to_numpy(std::move(values), {n_rows, n});
}

void make_state(MotionState* self, nb::handle q_in, nb::handle v_in) {
  std::vector<double> q = row_of(q_in, "q");
  std::vector<double> v = row_of(v_in, "v", static_cast<Py_ssize_t>(q.size()));
  new (self) MotionState{std::move(q), std::move(v)};
}

void make_limits(ParabolicLimits* self, nb::handle velocity_in, nb::handle acceleration_in, nb::handle jerk_in,
                 double pause) {
  std::vector<double> velocity = row_of(velocity_in, "velocity");
  const Py_ssize_t n = static_cast<Py_ssize_t>(velocity.size());
  std::vector<double> acceleration = row_of(acceleration_in, "acceleration", n), jerk = row_of(jerk_in, "jerk", n);
  for (const auto* each : {&velocity, &acceleration, &jerk})
    for (double limit : *each)
      if (!(limit > 0.0)) throw nb::value_error("limits must be positive");
  if (!(pause >= 0.0 && pause < 1e3)) throw nb::value_error("pause: not in 0..1000 s");
  new (self) ParabolicLimits{std::move(velocity), std::move(acceleration), std::move(jerk), pause};
}

constexpr double kLongest = 1e5;  // s: a longer segment is a mistake in the arguments

void check_duration(double duration) {
  if (!(duration >= 0.0 && duration <= kLongest)) throw nb::value_error("duration: not in 0..1e5 s");
}

void make_segment(ParabolicSegment* self, nb::handle q0_in, nb::handle v0_in, nb::handle speed_in,
                  nb::handle v1_in, nb::handle up_in, nb::handle down_in, double duration) {
  const Doubles q0(q0_in, "q0", {kAny});
  const Py_ssize_t n = q0.rows();
  const Doubles v0(v0_in, "v0", {n}), speed(speed_in, "speed", {n}), v1(v1_in, "v1", {n}), up(up_in, "up", {n}),
      down(down_in, "down", {n});
  check_duration(duration);
  std::vector<Ramps> joints;
  for (std::size_t j = 0; j < q0.size(); ++j)
    joints.push_back({q0[j], v0[j], speed[j], v1[j], up[j], down[j]});
  new (self) ParabolicSegment(std::move(joints), duration);
}

//! A property: the same number of every joint.
template <double Ramps::*member>
nb::object of_joints(const ParabolicSegment& segment) {
  std::vector<double> values;
  for (const Ramps& joint : segment.joints()) values.push_back(joint.*member);
  return to_row(std::move(values));
}

nb::tuple evaluate(const ParabolicSegment& segment, nb::handle t_in) {
  const Doubles t(t_in, "t", {kAny});
  const std::size_t n = segment.n();
  std::vector<double> q(t.size() * n), v(t.size() * n);
  for (std::size_t i = 0; i < t.size(); ++i) segment.evaluate(t[i], &q[i * n], &v[i * n]);
  return nb::make_tuple(to_numpy(std::move(q), {t.size(), n}), to_numpy(std::move(v), {t.size(), n}));
}

void check_joints(const MotionState& state, const ParabolicLimits& limits) {
  if (state.q.size() != limits.velocity.size())
    throw nb::value_error("states and limits must have the same joints");
}

std::optional<ParabolicSegment> min_time(const MotionState& start, const MotionState& end,
                                         const ParabolicLimits& limits, double at_most) {
  check_joints(start, limits);
  check_joints(end, limits);
  return steer_min_time(start, end, limits, at_most);
}

std::optional<ParabolicSegment> fixed_time(const MotionState& start, const MotionState& end,
                                           const ParabolicLimits& limits, double duration) {
  check_joints(start, limits);
  check_joints(end, limits);
  check_duration(duration);
  return steer_fixed_time(start, end, limits, duration);
}

std::optional<std::pair<ParabolicSegment, ParabolicSegment>> via(
    const MotionState& start, const std::vector<const MotionState*>& middles, const MotionState& end,
    const ParabolicLimits& limits, double there, double back) {
  check_joints(start, limits);
  check_joints(end, limits);
  for (const MotionState* middle : middles) check_joints(*middle, limits);
  check_duration(there);
  check_duration(back);
  return steer_via(start, middles, end, limits, there, back);
}

void check_segments(const Segments& segments) {
  if (segments.empty() || segments.front().n() == 0) throw nb::value_error("segments: there must be one at least");
  for (const ParabolicSegment& segment : segments)
    if (segment.n() != segments.front().n()) throw nb::value_error("segments: not all of the same joints");
}

nb::tuple tube_of(const Segments& segments, double step) {
  check_segments(segments);
  if (!(step >= 1e-6)) throw nb::value_error("step: not at least 1e-6 s");
  Tube made = tube(segments, step);
  const std::size_t n = segments.front().n();
  return nb::make_tuple(to_rows(std::move(made.Q), n), to_rows(std::move(made.slack), n));
}

nb::object positions_of(const Segments& segments, nb::handle t_in) {
  check_segments(segments);
  const Doubles t(t_in, "t", {kAny});
  for (std::size_t i = 1; i < t.size(); ++i)
    if (t[i] < t[i - 1]) throw nb::value_error("t: not increasing");
  return to_numpy(positions(segments, t.data(), t.size()), {t.size(), segments.front().n()});
}

nb::object accelerations_of(const Segments& segments) {
  check_segments(segments);
  return to_rows(accelerations(segments), segments.front().n());
}

double window_of(const Segments& segments, const ParabolicLimits& limits) {
  check_segments(segments);
  if (segments.front().n() != limits.velocity.size())
    throw nb::value_error("segments and limits must have the same joints");
  return jerk_window(segments, limits);
}

void bind_segment(nb::module_& m) {
  nb::class_<ParabolicSegment>(
      m, "ParabolicSegment",
      R"(Ramps of n joints in one common time, with a cruise in between.

Each joint ramps to a speed of its own, keeps it, and ramps to its final speed. All joints start and end together
and are otherwise independent, so only the slowest one needs its limits; the others have time to spare (Hauser and
Ng-Thow-Hing 2010, with the speeds of all joints free at both ends). Ramps begin and end on ticks, so a filtered
motion never switches between two ticks.)")
      .def("__init__", &make_segment, "q0"_a, "v0"_a, "speed"_a, "v1"_a, "up"_a, "down"_a, "duration"_a,
           nb::sig("def __init__(self, q0: " APC_F64 ", v0: " APC_F64 ", speed: " APC_F64 ", v1: " APC_F64
                   ", up: " APC_F64 ", down: " APC_F64 ", duration: float) -> None"),
           R"(Make a segment.

Args:
    q0: (n,) positions at the start, rad or m.
    v0: (n,) velocities at the start.
    speed: (n,) velocities of the cruise.
    v1: (n,) velocities at the end.
    up: (n,) s from the start, in which the velocity changes from v0 to speed.
    down: (n,) s before the end, in which the velocity changes from speed to v1.
    duration: s.)")
      .def_prop_ro("q0", &of_joints<&Ramps::q0>, nb::sig("def q0(self) -> " APC_F64), "(n,) positions at the start.")
      .def_prop_ro("speed", &of_joints<&Ramps::speed>, nb::sig("def speed(self) -> " APC_F64),
                   "(n,) velocities of the cruise.")
      .def_prop_ro("up", &of_joints<&Ramps::up>, nb::sig("def up(self) -> " APC_F64),
                   "(n,) s of the first ramp, from the start.")
      .def_prop_ro("down", &of_joints<&Ramps::down>, nb::sig("def down(self) -> " APC_F64),
                   "(n,) s of the last ramp, before the end.")
      .def_prop_ro("duration", &ParabolicSegment::duration, "s.")
      .def("evaluate", &evaluate, "t"_a,
           nb::sig("def evaluate(self, t: " APC_F64 ") -> tuple[" APC_F64 ", " APC_F64 "]"),
           "Positions and velocities (M, n) at t (M,), s since the segment began.")
      .def("state", &ParabolicSegment::state, "t"_a, "Positions and velocities at t s since the segment began.")
      .def("part", &ParabolicSegment::part, "start"_a, "end"_a,
           "The segment between two times, s since it began.");
}

void bind_trajectory(nb::module_& m) {
  nb::class_<ParabolicTrajectory>(
      m, "ParabolicTrajectory",
      R"(Parabolic segments, each beginning as the one before it ends; at rest at both ends.

Accelerations jump between the segments and inside them; filter_jerk makes a trajectory with limited jerk of it.)")
      .def(
          "__init__",
          [](ParabolicTrajectory* self, Segments segments) {
            check_segments(segments);
            new (self) ParabolicTrajectory(std::move(segments));
          },
          "segments"_a, "Join segments, in their order.")
      .def_prop_ro("segments", &ParabolicTrajectory::segments, nb::rv_policy::copy, "The segments, in their order.")
      .def_prop_ro("duration", &ParabolicTrajectory::duration, "s from rest to rest, before jerk is limited.")
      .def(
          "total",
          [](const ParabolicTrajectory& self, const ParabolicLimits& limits) {
            return self.duration() + window_of(self.segments(), limits);
          },
          "limits"_a, "Duration once the jerk limits are kept, s: with the jerk window.")
      .def("state", &ParabolicTrajectory::state, "t"_a, "Positions and velocities at t s since the start.")
      .def("between", &ParabolicTrajectory::between, "start"_a, "end"_a,
           R"(The segments between two times, cut where the times fall into them.

Args:
    start: s since the start, on a tick.
    end: s since the start, on a tick.)")
      .def(
          "replaced",
          [](const ParabolicTrajectory& self, double start, double end, const Segments& segments) {
            check_segments(segments);
            return self.replaced(start, end, segments);
          },
          "start"_a, "end"_a, "segments"_a,
          R"(The trajectory with other segments between two times.

Args:
    start: s since the start, on a tick.
    end: s since the start, on a tick.
    segments: Segments that lead from the state at start to the state at end.)");
}

void bind_steering(nb::module_& m) {
  m.def("steer_min_time", &min_time, "start"_a, "end"_a, "limits"_a, "at_most"_a,
        R"(The segment of least time between two states, without regard to obstacles.

Args:
    start: State in which it begins.
    end: State in which it ends.
    limits: Velocity and acceleration limits, and the pause.
    at_most: Longest duration that is wanted, s.

Returns:
    The segment; None if it takes longer than at_most, or if a joint has no segment of any of the times tried.)");
  m.def("steer_fixed_time", &fixed_time, "start"_a, "end"_a, "limits"_a, "duration"_a,
        R"(The segment of a given duration between two states.

Args:
    start: State in which it begins.
    end: State in which it ends.
    limits: Velocity and acceleration limits, and the pause.
    duration: s, a whole number of ticks.

Returns:
    The segment, or None if a joint has none of that duration.)");
  m.def("steer_via", &via, "start"_a, "middles"_a, "end"_a, "limits"_a, "there"_a, "back"_a,
        R"(Two segments by way of a state in between, which every joint chooses on its own.

Every joint takes the first of the middle states for which it has both segments.

Args:
    start: State in which the first segment begins.
    middles: States to choose from, the preferred first.
    end: State in which the second segment ends.
    limits: Velocity and acceleration limits, and the pause.
    there: Duration of the first segment, s.
    back: Duration of the second segment, s.

Returns:
    Both segments, or None if a joint has no choice.)");
}

void bind_curves(nb::module_& m) {
  m.def("tube", &tube_of, "segments"_a, "step"_a,
        nb::sig("def tube(segments: collections.abc.Sequence[ParabolicSegment], step: float) -> tuple[" APC_F64
                ", " APC_F64 "]"),
        R"(Chords of segments, and how far the segments leave them.

A curve of acceleration a leaves a chord of h s by a h^2 / 8 at most.

Args:
    segments: Segments, one after the other.
    step: Longest chord, s.

Returns:
    Chord ends (K, n) and slack (K - 1, n): on each chord the motion stays within the slack, joint by joint.)");
  m.def("parabolic_positions", &positions_of, "segments"_a, "t"_a,
        nb::sig("def parabolic_positions(segments: collections.abc.Sequence[ParabolicSegment], t: " APC_F64 ") -> " APC_F64),
        "Positions (M, n) on segments, one after the other, at increasing t (M,), s since the first began.");
  m.def("parabolic_accelerations", &accelerations_of, "segments"_a,
        nb::sig("def parabolic_accelerations(segments: collections.abc.Sequence[ParabolicSegment]) -> " APC_F64),
        "Accelerations (K, n) on segments, one after the other, a row for each of K ticks.");
  m.def("jerk_window", &window_of, "segments"_a, "limits"_a,
        R"(Time over which segments must be averaged to keep the jerk limits: a pause, or up to two.

The jerk of an average over w s is the change of acceleration in w s, over w. Over two pauses it keeps the limit
whatever the segments do; over one, unless a joint turns from ramp to ramp.

Args:
    segments: Segments, one after the other.
    limits: Acceleration and jerk limits, and the pause.

Returns:
    s, a whole number of ticks.)");
}

}  // namespace

void bind_parabolic(nb::module_& m) {
  nb::class_<MotionState>(m, "JointState", "Positions and velocities of all joints at one time.")
      .def("__init__", &make_state, "q"_a, "v"_a,
           nb::sig("def __init__(self, q: " APC_F64 ", v: " APC_F64 ") -> None"),
           "The state at q (n,), rad or m, with velocities v (n,).")
      .def_static(
          "at_rest",
          [](nb::handle q_in) {
            std::vector<double> q = row_of(q_in, "q");
            const std::size_t n = q.size();
            return MotionState{std::move(q), std::vector<double>(n)};
          },
          "q"_a, nb::sig("def at_rest(q: " APC_F64 ") -> JointState"), "The state at rest in q (n,).")
      .def_prop_ro(
          "q", [](const MotionState& self) { return to_row(self.q); }, nb::sig("def q(self) -> " APC_F64),
          "(n,) rad or m.")
      .def_prop_ro(
          "v", [](const MotionState& self) { return to_row(self.v); }, nb::sig("def v(self) -> " APC_F64),
          "(n,) rad/s or m/s.");
  nb::class_<ParabolicLimits>(m, "ParabolicLimits", "What each joint may do.")
      .def("__init__", &make_limits, "velocity"_a, "acceleration"_a, "jerk"_a, "pause"_a,
           nb::sig("def __init__(self, velocity: " APC_F64 ", acceleration: " APC_F64 ", jerk: " APC_F64
                   ", pause: float) -> None"),
           R"(State limits.

Args:
    velocity: (n,) rad/s or m/s.
    acceleration: (n,) rad/s^2 or m/s^2.
    jerk: (n,) rad/s^3 or m/s^3.
    pause: s without acceleration between a ramp up and a ramp down.)")
      .def_prop_ro(
          "velocity", [](const ParabolicLimits& self) { return to_row(self.velocity); },
          nb::sig("def velocity(self) -> " APC_F64), "(n,) rad/s or m/s.")
      .def_prop_ro(
          "acceleration", [](const ParabolicLimits& self) { return to_row(self.acceleration); },
          nb::sig("def acceleration(self) -> " APC_F64), "(n,) rad/s^2 or m/s^2.")
      .def_prop_ro(
          "jerk", [](const ParabolicLimits& self) { return to_row(self.jerk); },
          nb::sig("def jerk(self) -> " APC_F64), "(n,) rad/s^3 or m/s^3.")
      .def_ro("pause", &ParabolicLimits::pause, "s without acceleration between a ramp up and a ramp down.");
  bind_segment(m);
  bind_trajectory(m);
  bind_steering(m);
  bind_curves(m);
}

}  // namespace apc
