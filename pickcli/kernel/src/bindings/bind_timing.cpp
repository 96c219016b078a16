//! \file
//! pickcli.kernel.fastest_pace, smoothed_pace, estimated_duration, quintic_peaks, quintic_states
//! and simplified_polyline.
#include "bindings/bindings.hpp"

#include <algorithm>

#include "bindings/arrays.hpp"
#include "timing/look_ahead.hpp"
#include "timing/polyline.hpp"
#include "timing/quintic.hpp"
#include "timing/topp.hpp"

namespace apc {
namespace {

using namespace nb::literals;

//! Positive steps from each value to the next, and at least one of them.
void check_increasing(const Doubles& values, const char* name) {
  bool is_increasing = values.rows() >= 2;
  for (int i = 0; i + 1 < values.rows(); ++i) is_increasing = is_increasing && values[i] < values[i + 1];
  if (!is_increasing)
    throw nb::value_error((std::string(name) + ": not two or more increasing values").c_str());
}

void check_positive(const Doubles& values, const char* name) {
  for (std::size_t i = 0; i < values.size(); ++i)
    if (!(values[i] > 0.0)) throw nb::value_error((std::string(name) + ": not positive").c_str());
}

constexpr double kMostCells = 1e8;  // of a motion in time: more is a mistake in the arguments

nb::tuple fastest_pace_of(nb::handle s_in, nb::handle dq_in, nb::handle ddq_in, nb::handle acceleration_in,
                          nb::handle speed_in, nb::handle line_speed_in, nb::handle is_line_in,
                          double cruise) {
  const Doubles s(s_in, "s", {kAny}), dq(dq_in, "dq", {s.rows(), kAny});
  const Py_ssize_t M = s.rows(), n = static_cast<Py_ssize_t>(dq.size()) / std::max<Py_ssize_t>(M, 1);
  check_increasing(s, "s");
  if (n < 1) throw nb::value_error("dq: no joints");
  const Doubles ddq(ddq_in, "ddq", {M, n}), acceleration(acceleration_in, "acceleration", {M - 1, n});
  const Doubles speed(speed_in, "speed", {M}), line_speed(line_speed_in, "line_speed", {M - 1});
  const Integers is_line(is_line_in, "is_line", {M - 1});
  check_positive(acceleration, "acceleration");
  if (!(cruise >= 0.0)) throw nb::value_error("cruise: negative");
  const PathGrid grid{static_cast<std::size_t>(M),
                      static_cast<std::size_t>(n),
                      s.data(),
                      dq.data(),
                      ddq.data(),
                      acceleration.data(),
                      speed.data(),
                      line_speed.data(),
                      is_line.data(),
                      cruise};
  PaceProfile profile;
  {
    nb::gil_scoped_release unlocked;
    profile = fastest_pace(grid);
  }
  const std::size_t P = profile.t.size();
  return nb::make_tuple(to_numpy(std::move(profile.t), {P}), to_numpy(std::move(profile.s), {P}),
                        to_numpy(std::move(profile.v), {P}));
}

nb::tuple smoothed_pace(nb::handle t_in, nb::handle s_in, nb::handle v_in, double step,
                        std::size_t n_window) {
  const Doubles t(t_in, "t", {kAny}), s(s_in, "s", {t.rows()}), v(v_in, "v", {t.rows()});
  check_increasing(t, "t");
  if (!(step > 0.0 && t[t.size() - 1] / step < kMostCells)) throw nb::value_error("step: not positive, or tiny");
  if (n_window < 1 || n_window > kMostCells) throw nb::value_error("n_window: not at least 1, or huge");
  SmoothPace pace;
  {
    nb::gil_scoped_release unlocked;
    pace = smoothed(t.data(), s.data(), v.data(), t.size(), step, n_window);
  }
  const std::size_t K = pace.s.size();
  return nb::make_tuple(to_numpy(std::move(pace.s), {K}), to_numpy(std::move(pace.ds), {K}),
                        to_numpy(std::move(pace.dds), {K}));
}

//! Beyond these, products of values and powers of steps are no longer finite.
constexpr double kLargest = 1e60, kSmallestStep = 1e-60;

void check_magnitude(const Doubles& values, const char* name) {
  for (std::size_t i = 0; i < values.size(); ++i)
    if (std::abs(values[i]) > kLargest) throw nb::value_error((std::string(name) + ": beyond 1e60").c_str());
}

void check_steps(const Doubles& times) {
  for (int i = 0; i + 1 < times.rows(); ++i)
    if (times[i + 1] - times[i] < kSmallestStep) throw nb::value_error("times: a step is below 1e-60");
}

nb::tuple peaks_of(nb::handle times_in, nb::handle p_in, nb::handle v_in, nb::handle a_in) {
  const Doubles times(times_in, "times", {kAny}), p(p_in, "positions", {times.rows(), kAny});
  check_increasing(times, "times");
  check_steps(times);
  const std::size_t N = static_cast<std::size_t>(times.rows()), n = p.size() / N;
  const Py_ssize_t rows = times.rows(), columns = static_cast<Py_ssize_t>(n);
  const Doubles v(v_in, "velocities", {rows, columns}), a(a_in, "accelerations", {rows, columns});
  check_magnitude(times, "times");
  check_magnitude(p, "positions");
  check_magnitude(v, "velocities");
  check_magnitude(a, "accelerations");
  std::vector<double> velocity((N - 1) * n), acceleration((N - 1) * n), jerk((N - 1) * n);
  {
    nb::gil_scoped_release unlocked;
    for (std::size_t k = 0; k < velocity.size(); ++k) {
      const std::size_t i = k / n;
      const Peaks peaks =
          quintic_peaks({p[k], v[k], a[k]}, {p[k + n], v[k + n], a[k + n]}, times[i + 1] - times[i]);
      velocity[k] = peaks.velocity;
      acceleration[k] = peaks.acceleration;
      jerk[k] = peaks.jerk;
    }
  }
  return nb::make_tuple(to_numpy(std::move(velocity), {N - 1, n}),
                        to_numpy(std::move(acceleration), {N - 1, n}), to_numpy(std::move(jerk), {N - 1, n}));
}

nb::object states_of(nb::handle times_in, nb::handle p_in, nb::handle v_in, nb::handle a_in, nb::handle t_in,
                     int highest) {
  const Doubles times(times_in, "times", {kAny}), p(p_in, "positions", {times.rows(), kAny});
  check_increasing(times, "times");
  const std::size_t N = times.size(), n = p.size() / N;
  const Py_ssize_t rows = times.rows(), columns = static_cast<Py_ssize_t>(n);
  const Doubles v(v_in, "velocities", {rows, columns}), a(a_in, "accelerations", {rows, columns});
  const Doubles t(t_in, "t", {kAny});
  if (highest < 0 || highest > 2) throw nb::value_error("highest: derivatives 0 to 2 are known");
  const std::size_t M = t.size(), orders = static_cast<std::size_t>(highest) + 1;
  std::vector<double> out(orders * M * n);
  {
    nb::gil_scoped_release unlocked;
    quintic_states({N, n, times.data(), p.data(), v.data(), a.data()}, t.data(), M, highest, out.data());
  }
  return to_numpy(std::move(out), {orders, M, n});
}

double duration_of(nb::handle waypoints_in, nb::handle velocity_in, nb::handle acceleration_in,
                   double corner_deviation) {
  const Doubles velocity(velocity_in, "velocity", {kAny}),
      acceleration(acceleration_in, "acceleration", {velocity.rows()});
  const Doubles waypoints(waypoints_in, "waypoints", {kAny, velocity.rows()});
  check_positive(velocity, "velocity");
  check_positive(acceleration, "acceleration");
  if (!(corner_deviation > 0.0)) throw nb::value_error("corner_deviation: not positive");
  return estimated_duration({static_cast<std::size_t>(waypoints.rows()), velocity.size(), waypoints.data(),
                             velocity.data(), acceleration.data(), corner_deviation});
}

nb::object simplified_polyline(nb::handle waypoints_in, nb::handle tolerances_in, double same, double nowhere) {
  const Doubles waypoints(waypoints_in, "waypoints", {kAny, kAny});
  if (waypoints.rows() < 1) throw nb::value_error("waypoints: none");
  const Doubles tolerances(tolerances_in, "tolerances", {waypoints.rows()});
  check_positive(tolerances, "tolerances");
  if (!(same > 0.0 && nowhere > 0.0)) throw nb::value_error("same, nowhere: not positive");
  const std::size_t N = static_cast<std::size_t>(waypoints.rows());
  std::vector<std::int32_t> kept =
      simplified(waypoints.data(), N, waypoints.size() / N, tolerances.data(), {same, nowhere});
  const std::size_t K = kept.size();
  return to_numpy(std::move(kept), {K});
}

}  // namespace

void bind_timing(nb::module_& m) {
  m.def("simplified_polyline", &simplified_polyline, "waypoints"_a, "tolerances"_a, "same"_a, "nowhere"_a,
        nb::sig("def simplified_polyline(waypoints: " APC_F64 ", tolerances: " APC_F64
                ", same: float, nowhere: float) -> " APC_I32),
        R"(Indices of the waypoints that shape a path, after Douglas and Peucker (1973).

Args:
    waypoints: (N, n) configurations, N >= 1.
    tolerances: (N,) > 0, how far a dropped waypoint may be off the chord between its kept neighbours, joint units.
    same: Waypoints nearer than this count as one, joint units.
    nowhere: A path no longer than this has no motion, joint units.

Returns:
    (K,) indices, increasing: the first, the last and all that are needed. Those between two kept ones advance
    along their chord, so reversals are kept.)");
  m.def("fastest_pace", &fastest_pace_of, "s"_a, "dq"_a, "ddq"_a, "acceleration"_a, "speed"_a, "line_speed"_a,
        "is_line"_a, "cruise"_a = 0.0,
        nb::sig("def fastest_pace(s: " APC_F64 ", dq: " APC_F64 ", ddq: " APC_F64 ", acceleration: " APC_F64
                ", speed: " APC_F64 ", line_speed: " APC_F64 ", is_line: " APC_I32
                ", cruise: float = 0.0) -> tuple[" APC_F64 ", " APC_F64 ", " APC_F64 "]"),
        R"(Time-optimal motion from rest to rest along a path, by TOPP-RA (Pham and Pham 2018).

Args:
    s: (M,) gridpoints, increasing.
    dq: (M, n) dq/ds at the gridpoints.
    ddq: (M, n) its derivative by s.
    acceleration: (M-1, n) > 0, rad/s^2 or m/s^2, limits of the joints on each interval.
    speed: (M,) 1/s, limits of ds/dt.
    line_speed: (M-1,) 1/s, limits of ds/dt inside intervals that are lines.
    is_line: (M-1,) whether nothing bends there; the profile of a line is exact: accelerate, cruise, brake.
    cruise: s that the cruise on a line lasts at least.

Returns:
    t, s and ds/dt, each (P,); ds/dt is linear in t between the points.)");
  m.def("smoothed_pace", &smoothed_pace, "t"_a, "s"_a, "v"_a, "step"_a, "n_window"_a,
        nb::sig("def smoothed_pace(t: " APC_F64 ", s: " APC_F64 ", v: " APC_F64
                ", step: float, n_window: int) -> tuple[" APC_F64 ", " APC_F64 ", " APC_F64 "]"),
        R"(A motion with its speed averaged over a window, which bounds its jerk.

Args:
    t: (P,) s, increasing from 0.
    s: (P,) path parameters.
    v: (P,) ds/dt, linear in t between the points, 0 at both ends.
    step: s between the times of the result.
    n_window: Steps of the window, at least 1.

Returns:
    s, ds/dt and d2s/dt2 at even times, each (K,): a window and a step longer than the motion, d2s/dt2 linear in
    between.)");
  m.def("estimated_duration", &duration_of, "waypoints"_a, "velocity"_a, "acceleration"_a,
        "corner_deviation"_a,
        nb::sig("def estimated_duration(waypoints: " APC_F64 ", velocity: " APC_F64 ", acceleration: " APC_F64
                ", corner_deviation: float) -> float"),
        R"(About how many seconds a polyline with blended corners takes from rest to rest.

The look-ahead of machine tools: on each edge the speed is bounded by the slowest joint, in each corner by the
acceleration that a blend needs; a pass backwards and one forwards make the speeds reachable; each edge then
takes its trapezoid. Jerk is left out.

Args:
    waypoints: (N, n) vertices, rad or m.
    velocity: (n,) > 0, rad/s or m/s.
    acceleration: (n,) > 0, rad/s^2 or m/s^2.
    corner_deviation: rad or m, by which a blend may leave its corner.)");
  m.def("quintic_peaks", &peaks_of, "times"_a, "positions"_a, "velocities"_a, "accelerations"_a,
        nb::sig("def quintic_peaks(times: " APC_F64 ", positions: " APC_F64 ", velocities: " APC_F64
                ", accelerations: " APC_F64 ") -> tuple[" APC_F64 ", " APC_F64 ", " APC_F64 "]"),
        R"(Largest values on the quintics between points in time.

Args:
    times: (N,) s, increasing.
    positions: (N, n) rad or m.
    velocities: (N, n) per s.
    accelerations: (N, n) per s^2.

Returns:
    Of every piece, each (N-1, n): the largest abs(velocity), from above; abs(acceleration) and abs(jerk),
    exact.)");
  m.def("quintic_states", &states_of, "times"_a, "positions"_a, "velocities"_a, "accelerations"_a, "t"_a,
        "highest"_a = 2,
        nb::sig("def quintic_states(times: " APC_F64 ", positions: " APC_F64 ", velocities: " APC_F64
                ", accelerations: " APC_F64 ", t: " APC_F64 ", highest: int = 2) -> " APC_F64),
        R"(States on the quintics between points in time.

Args:
    times: (N,) s, increasing.
    positions: (N, n) rad or m.
    velocities: (N, n) per s.
    accelerations: (N, n) per s^2.
    t: (M,) s, clamped to the first and the last time.
    highest: Derivative by time, 0 to 2.

Returns:
    (highest + 1, M, n).)");
}

}  // namespace apc
