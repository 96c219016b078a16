//! \file
//! pickcli.kernel.rrt_connect and shorten.
#include "bindings/bindings.hpp"

#include "bindings/arrays.hpp"
#include "planning/rrt_connect.hpp"
#include "planning/shorten.hpp"

namespace apc {
namespace {

using namespace nb::literals;

nb::object to_polyline(std::vector<double> points, int n) {
  const std::size_t n_rows = points.size() / static_cast<std::size_t>(n);
  return to_numpy(std::move(points), {n_rows, static_cast<std::size_t>(n)});
}

nb::object rrt_connect_in(const Checker& checker, nb::handle start_in, nb::handle goals_in,
                          nb::handle lower_in, nb::handle upper_in, std::uint64_t seed, int max_iterations,
                          double step, double margin, double resolution) {
  const int n = checker.n();
  const Doubles start(start_in, "start", {n}), goals(goals_in, "goals", {kAny, n});
  const Doubles lower(lower_in, "lower", {n}), upper(upper_in, "upper", {n});
  check_range(start, "start");
  check_range(goals, "goals");
  check_range(lower, "lower");
  check_range(upper, "upper");
  if (goals.size() == 0) throw nb::value_error("goals: there must be one at least");
  if (!(step >= 1e-6)) throw nb::value_error("step must be at least 1e-6");
  check_margin(margin);
  check_resolution(resolution);
  std::vector<double> path;
  {
    nb::gil_scoped_release unlocked;
    path = rrt_connect(checker, {start.data(), goals.data(), goals.rows(), lower.data(), upper.data(), step,
                                 margin, resolution, seed, max_iterations});
  }
  return to_polyline(std::move(path), n);
}

nb::object shorten_in(const Checker& checker, nb::handle Q_in, nb::handle shortcuts_in,
                      nb::handle velocity_in, double calm, double worthwhile, double margin,
                      double resolution) {
  const int n = checker.n();
  const Doubles Q(Q_in, "Q", {kAny, n}), shortcuts(shortcuts_in, "shortcuts", {kAny, 2});
  const Doubles velocity(velocity_in, "velocity", {n});
  if (Q.rows() < 2) throw nb::value_error("Q: a path has at least two configurations");
  check_range(Q, "Q");
  for (std::size_t k = 0; k < shortcuts.size(); ++k)
    if (!(shortcuts[k] >= 0.0 && shortcuts[k] <= 1.0 && (k % 2 == 0 || shortcuts[k - 1] <= shortcuts[k])))
      throw nb::value_error("shortcuts: two increasing shares in 0..1 each");
  for (int j = 0; j < n; ++j)
    if (!(velocity[static_cast<std::size_t>(j)] > 0.0)) throw nb::value_error("velocity must be positive");
  check_margin(margin);
  check_resolution(resolution);
  std::vector<double> path;
  {
    nb::gil_scoped_release unlocked;
    path = shorten(checker, {Q.data(),
                             Q.rows(),
                             shortcuts.data(),
                             shortcuts.rows(),
                             {velocity.data(), calm},
                             worthwhile,
                             margin,
                             resolution});
  }
  return to_polyline(std::move(path), n);
}

}  // namespace

void bind_planning(nb::module_& m) {
  m.def("rrt_connect", &rrt_connect_in, "checker"_a, "start"_a, "goals"_a, "lower"_a, "upper"_a, "seed"_a,
        "max_iterations"_a, "step"_a, "margin"_a = 0.0, "resolution"_a = 2e-4,
        nb::sig("def rrt_connect(checker: Checker, start: " APC_F64 ", goals: " APC_F64 ", lower: " APC_F64
                ", upper: " APC_F64 ", seed: int, max_iterations: int, step: float, margin: float = 0.0, "
                                    "resolution: float = 0.0002) -> " APC_F64),
        R"(Waypoints from a start to one of several goals by RRT-Connect.

Kuffner and LaValle 2000, but the smaller tree grows, from nodes before an obstacle only towards what is near
(Yershova et al. 2005), and long searches begin anew with shorter edges. Every edge is proven as by
Checker.edge_is_free; start and goals are not asked about. The same arguments give the same bits.

Args:
    checker: Proves the edges.
    start: (n,) root of the first tree.
    goals: (G, n) roots of the second tree.
    lower: (n,) between which configurations are drawn.
    upper: (n,) between which configurations are drawn.
    seed: Of the draws.
    max_iterations: After which nothing was found.
    step: Longest edge of a tree, Euclidean in joint space; 1e-6 at least.
    margin: m, as of Checker.edge_is_free.
    resolution: m, as of Checker.edge_is_free.

Returns:
    (K, n), or (0, n) if none was found.)");
  m.def("shorten", &shorten_in, "checker"_a, "Q"_a, "shortcuts"_a, "velocity"_a, "calm"_a, "worthwhile"_a,
        "margin"_a = 0.0, "resolution"_a = 2e-4,
        nb::sig(
            "def shorten(checker: Checker, Q: " APC_F64 ", shortcuts: " APC_F64 ", velocity: " APC_F64
            ", calm: float, worthwhile: float, margin: float = 0.0, resolution: float = 0.0002) -> " APC_F64),
        R"(A polyline with the same ends that costs no more, by shortcuts (Geraerts and Overmars 2007).

An edge dq costs the largest abs(dq_j) / velocity_j, and calm times the length of dq / velocity. Vertices that
a proven edge skips go; then the shortcuts are tried in their order; then vertices go again. Every new edge,
also what is left of one that was cut, is proven as by Checker.edge_is_free; those of Q are taken to be.

Args:
    checker: Proves the edges.
    Q: (N, n) vertices.
    shortcuts: (S, 2) increasing shares, 0..1, of the cost of the polyline as it is then: each joins the
        points there.
    velocity: (n,) > 0, rad/s or m/s.
    calm: Share.
    worthwhile: Share of the whole cost that a shortcut must save to be taken.
    margin: m, as of Checker.edge_is_free.
    resolution: m, as of Checker.edge_is_free.

Returns:
    (K, n) vertices.)");
}

}  // namespace apc
