//! \file
//! pickcli.kernel.BlendedPolyline.
#include <memory>

#include "bindings/arrays.hpp"
#include "bindings/bindings.hpp"
#include "timing/blended_polyline.hpp"

namespace apc {
namespace {

using namespace nb::literals;

std::vector<double> to_vector(const Doubles& values) {
  return {values.data(), values.data() + values.size()};
}

BlendedPolyline make_polyline(nb::handle corners_in, nb::handle s_in, nb::handle half_in,
                              nb::handle directions_in, nb::handle turns_in) {
  const Doubles s(s_in, "corner_s", {kAny});
  const Py_ssize_t K = s.rows();
  if (K < 1) throw nb::value_error("corner_s: a polyline has at least one corner");
  const Doubles corners(corners_in, "corners", {K, kAny}), half(half_in, "half_lengths", {K});
  const Py_ssize_t n = static_cast<Py_ssize_t>(corners.size()) / K;
  const Doubles directions(directions_in, "directions", {K + 1, n}), turns(turns_in, "turns", {K, n});
  for (Py_ssize_t k = 0; k + 1 < K; ++k)
    if (!(s[k] < s[k + 1])) throw nb::value_error("corner_s: not increasing values");
  return BlendedPolyline(
      {to_vector(corners), to_vector(s), to_vector(half), to_vector(directions), to_vector(turns)});
}

nb::object evaluate(const BlendedPolyline& curve, nb::handle s_in, int highest) {
  const Doubles s(s_in, "s", {kAny});
  if (highest < 0 || highest > 3) throw nb::value_error("highest: derivatives 0 to 3 are known");
  const std::size_t M = s.size(), rows = static_cast<std::size_t>(highest) + 1;
  std::vector<double> out(rows * M * curve.n());
  curve.evaluate(s.data(), M, highest, out.data());
  return to_numpy(std::move(out), {rows, M, curve.n()});
}

using Bound = void (BlendedPolyline::*)(const double*, const double*, std::size_t, double*) const;

//! A bound of every interval, (M, columns) or, of one column, (M,).
nb::object bound(const BlendedPolyline& curve, Bound of, nb::handle start_in, nb::handle end_in,
                 bool by_joint) {
  const Doubles start(start_in, "start", {kAny}), end(end_in, "end", {start.rows()});
  const std::size_t M = start.size(), columns = by_joint ? curve.n() : 1;
  std::vector<double> out(M * columns);
  (curve.*of)(start.data(), end.data(), M, out.data());
  return by_joint ? to_numpy(std::move(out), {M, columns}) : to_numpy(std::move(out), {M});
}

nb::object are_lines(const BlendedPolyline& curve, nb::handle start_in, nb::handle end_in) {
  const Doubles start(start_in, "start", {kAny}), end(end_in, "end", {start.rows()});
  const std::size_t M = start.size();
  auto out = std::make_unique<bool[]>(M);
  curve.are_lines(start.data(), end.data(), M, out.get());
  bool* data = out.release();
  nb::capsule owner(data, [](void* p) noexcept { delete[] static_cast<bool*>(p); });
  return nb::cast(nb::ndarray<nb::numpy, bool>(data, {M}, owner));
}

nb::object time_scale(const BlendedPolyline& curve, nb::handle t_in, nb::handle s_in, nb::handle ds_in,
                      nb::handle dds_in, nb::handle velocity_in, nb::handle acceleration_in,
                      nb::handle jerk_in, nb::handle scale_in) {
  const Doubles t(t_in, "t", {kAny});
  const Py_ssize_t K = t.rows(), n = static_cast<Py_ssize_t>(curve.n());
  if (K < 2) throw nb::value_error("t: a pace has at least two points");
  const Doubles s(s_in, "s", {K}), ds(ds_in, "ds", {K}), dds(dds_in, "dds", {K}),
      scale(scale_in, "scale", {K - 1});
  const Doubles velocity(velocity_in, "velocity", {n}), acceleration(acceleration_in, "acceleration", {n});
  const Doubles jerk(jerk_in, "jerk", {n});
  std::vector<double> out(static_cast<std::size_t>(K) - 1);
  needed_time_scale(curve, {static_cast<std::size_t>(K), t.data(), s.data(), ds.data(), dds.data()},
                    {velocity.data(), acceleration.data(), jerk.data()}, scale.data(), out.data());
  const std::size_t rows = out.size();
  return to_numpy(std::move(out), {rows});
}

void bind_bounds(nb::class_<BlendedPolyline>& curve) {
  curve
      .def(
          "knots",
          [](const BlendedPolyline& self) {
            std::vector<double> knots = self.knots();
            const std::size_t M = knots.size();
            return to_numpy(std::move(knots), {M});
          },
          nb::sig("def knots(self) -> " APC_F64),
          R"(Sorted s (M,) of both ends, of all stops, and of nodes within the blends, dense where the path bends fast.

Between two knots that lie in no blend the path is a straight line.)")
      .def("are_lines", &are_lines, "start"_a, "end"_a,
           nb::sig("def are_lines(self, start: " APC_F64 ", end: " APC_F64 ") -> " APC_BOOL),
           "Whether nothing bends (M,) on each of the intervals start (M,) to end (M,), which lie between "
           "knots.")
      .def(
          "second_derivative_bound",
          [](const BlendedPolyline& self, nb::handle start, nb::handle end) {
            return bound(self, &BlendedPolyline::bound_second, start, end, true);
          },
          "start"_a, "end"_a,
          nb::sig("def second_derivative_bound(self, start: " APC_F64 ", end: " APC_F64 ") -> " APC_F64),
          "Upper bounds (M, n) of the second derivative's size on each of the intervals start (M,) to end "
          "(M,).")
      .def(
          "third_derivative_bound",
          [](const BlendedPolyline& self, nb::handle start, nb::handle end) {
            return bound(self, &BlendedPolyline::bound_third, start, end, true);
          },
          "start"_a, "end"_a,
          nb::sig("def third_derivative_bound(self, start: " APC_F64 ", end: " APC_F64 ") -> " APC_F64),
          "Upper bounds (M, n) of the third derivative's size on each of the intervals start (M,) to end "
          "(M,).")
      .def(
          "deviation",
          [](const BlendedPolyline& self, nb::handle start, nb::handle end) {
            return bound(self, &BlendedPolyline::bound_deviation, start, end, false);
          },
          "start"_a, "end"_a,
          nb::sig("def deviation(self, start: " APC_F64 ", end: " APC_F64 ") -> " APC_F64),
          "Upper bounds (M,) of the Euclidean distance from the polyline on intervals start (M,) to end "
          "(M,).");
}

}  // namespace

void bind_blend(nb::module_& m) {
  nb::class_<BlendedPolyline> curve(m, "BlendedPolyline",
                                    R"(A polyline whose corners are smoothed, by its arc length s.

At corner k the direction changes by a turn within h_k: the slope of the ramp is the quintic smoothstep there.
Lengths are Euclidean in joint units, rad and m alike.)");
  curve
      .def(
          "__init__",
          [](BlendedPolyline* self, nb::handle corners, nb::handle corner_s, nb::handle half_lengths,
             nb::handle directions, nb::handle turns) {
            new (self) BlendedPolyline(make_polyline(corners, corner_s, half_lengths, directions, turns));
          },
          "corners"_a, "corner_s"_a, "half_lengths"_a, "directions"_a, "turns"_a,
          nb::sig("def __init__(self, corners: " APC_F64 ", corner_s: " APC_F64 ", half_lengths: " APC_F64
                  ", directions: " APC_F64 ", turns: " APC_F64 ") -> None"),
          R"(Make a curve; nothing is computed that is given.

Args:
    corners: (K, n), K >= 1.
    corner_s: (K,) arc length of every corner, increasing from 0.
    half_lengths: (K,) h of every corner; 0 where nothing is smoothed.
    directions: (K + 1, n) unit vectors before and after every corner.
    turns: (K, n) change of direction at every corner.)")
      .def("evaluate", &evaluate, "s"_a, "highest"_a = 3,
           nb::sig("def evaluate(self, s: " APC_F64 ", highest: int = 3) -> " APC_F64),
           R"(The configuration and its derivatives by s.

Args:
    s: (M,), clamped to the curve.
    highest: Derivative, 0 to 3.

Returns:
    (highest + 1, M, n).)")
      .def("needed_time_scale", &time_scale, "t"_a, "s"_a, "ds"_a, "dds"_a, "velocity"_a, "acceleration"_a,
           "jerk"_a, "scale"_a,
           nb::sig("def needed_time_scale(self, t: " APC_F64 ", s: " APC_F64 ", ds: " APC_F64 ", dds: " APC_F64
                   ", velocity: " APC_F64 ", acceleration: " APC_F64 ", jerk: " APC_F64 ", scale: " APC_F64
                   ") -> " APC_F64),
           R"(Factors of time at which a motion along the curve, by quintics between points, keeps its limits.

Args:
    t: (K,) s, increasing.
    s: (K,) where on the curve.
    ds: (K,) 1/s, its first derivative by time.
    dds: (K,) 1/s^2, its second.
    velocity: (n,) limits, rad/s or m/s.
    acceleration: (n,) limits, rad/s^2 or m/s^2.
    jerk: (n,) limits, rad/s^3 or m/s^3.
    scale: (K-1,) of all limits, between each point and the next.

Returns:
    (K-1,) between each point and the next, at least 1.)");
  bind_bounds(curve);
}

}  // namespace apc
