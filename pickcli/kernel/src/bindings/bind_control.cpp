//! \file
//! pickcli.kernel: PriorityLevel, HierarchySolution, and solve_hierarchy.
#include "bindings/bindings.hpp"

#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include "bindings/arrays.hpp"
#include "control/hierarchical_qp.hpp"

namespace apc {
namespace {

using namespace nb::literals;

constexpr double kUnbounded = 1e300;

//! Bounds (m,), of which those of 1e300 and more are none.
std::vector<double> bounds_of(const Doubles& in) {
  std::vector<double> bounds(in.data(), in.data() + in.size());
  for (double& bound : bounds)
    if (std::abs(bound) >= kUnbounded) bound = std::copysign(HUGE_VAL, bound);
  return bounds;
}

void make_level(PriorityLevel* self, nb::handle rows_in, nb::handle lower_in, nb::handle upper_in) {
  const Doubles rows(rows_in, "rows", {kAny, kAny});
  const Py_ssize_t m = rows.rows();
  const Doubles lower(lower_in, "lower", {m}), upper(upper_in, "upper", {m});
  PriorityLevel level;
  const std::size_t n = m > 0 ? rows.size() / static_cast<std::size_t>(m) : 0;
  level.rows = Matrix(static_cast<std::size_t>(m), n);
  level.rows.values.assign(rows.data(), rows.data() + rows.size());
  level.lower = bounds_of(lower);
  level.upper = bounds_of(upper);
  for (std::size_t i = 0; i < level.lower.size(); ++i)
    if (!(level.lower[i] <= level.upper[i]))
      throw nb::value_error(("lower: row " + std::to_string(i) + " is above its upper bound").c_str());
    else if (level.lower[i] == HUGE_VAL || level.upper[i] == -HUGE_VAL)
      throw nb::value_error(("lower, upper: row " + std::to_string(i) + " has an infinite bound that nothing meets").c_str());
  new (self) PriorityLevel(std::move(level));
}

HierarchySolution solve(const std::vector<const PriorityLevel*>& levels_in, nb::handle start_in) {
  const Doubles start(start_in, "start", {kAny});
  std::vector<PriorityLevel> levels;
  for (const PriorityLevel* level : levels_in) {
    levels.push_back(*level);
    if (level->rows.n_rows == 0) levels.back().rows.n_columns = start.size();
    if (levels.back().rows.n_columns != start.size())
      throw nb::value_error(("levels: rows of level " + std::to_string(levels.size()) + " have " +
                             std::to_string(level->rows.n_columns) + " columns, start has " +
                             std::to_string(start.size()))
                                .c_str());
  }
  return solve_hierarchy(levels, std::vector<double>(start.data(), start.data() + start.size()));
}

}  // namespace

void bind_control(nb::module_& m) {
  nb::class_<PriorityLevel>(m, "PriorityLevel", "Rows lower <= A x <= upper of one priority.")
      .def("__init__", &make_level, "rows"_a, "lower"_a, "upper"_a,
           nb::sig("def __init__(self, rows: " APC_F64 ", lower: " APC_F64 ", upper: " APC_F64 ") -> None"),
           R"(Make a level.

Args:
    rows: (m, n).
    lower: (m,) lower bounds; -1e300 and less are none.
    upper: (m,) upper bounds; 1e300 and more are none. Rows with two equal bounds are equalities.)");
  nb::class_<HierarchySolution>(m, "HierarchySolution", "What a hierarchy of levels has in common.")
      .def_prop_ro(
          "x", [](const HierarchySolution& s) { return to_numpy(std::vector<double>(s.x), {s.x.size()}); },
          nb::sig("def x(self) -> " APC_F64), "(n,) the solution.")
      .def_prop_ro(
          "violations",
          [](const HierarchySolution& s) {
            nb::list found;
            for (const auto& each : s.violations) found.append(to_numpy(std::vector<double>(each), {each.size()}));
            return found;
          },
          nb::sig("def violations(self) -> list[" APC_F64 "]"),
          "Of each level (m,), how far rows are above their upper bounds, or, negative, below the lower ones.")
      .def_ro("n_iterations", &HierarchySolution::n_iterations, "Changes of the active sets of all levels.")
      .def_ro("failure", &HierarchySolution::failure, "\"\" if it is solved, else which level is not, and why.");
  m.def("solve_hierarchy", &solve, "levels"_a, "start"_a,
        nb::sig("def solve_hierarchy(levels: collections.abc.Sequence[PriorityLevel], start: " APC_F64
                ") -> HierarchySolution"),
        R"(Minimize lexicographically the norms of the levels' violations, those of the first one first.

Args:
    levels: Levels of strict priority, the most important one first.
    start: (n,) where the search begins; where the least norms do not determine x, it stays near.)");
}

}  // namespace apc
