//! \file
//! pickcli.kernel: PoseConstraint, its kinds, and what is computed of many of them.
#include "bindings/bindings.hpp"

#include <nanobind/stl/vector.h>

#include <algorithm>

#include "bindings/arrays.hpp"
#include "control/pose_constraints.hpp"
#include "control/projection.hpp"

namespace apc {
namespace {

using namespace nb::literals;

void make_constraint(PoseConstraint* self, PoseConstraintKind kind, ReferenceKind reference, nb::handle origin,
                     nb::handle axis, nb::handle tool, nb::handle fixed, double bound) {
  if (!std::isfinite(bound)) throw nb::value_error("bound: not finite");
  new (self) PoseConstraint{kind,
                            {reference, vector_of(origin, "origin"), unit_of(axis, "axis")},
                            unit_of(tool, "tool"),
                            unit_of(fixed, "fixed"),
                            bound};
}

using Constraints = std::vector<const PoseConstraint*>;

nb::object values(const Constraints& constraints, nb::handle T_in) {
  const Doubles T(T_in, "T_object_tool", {kAny, 4, 4});
  const std::size_t N = static_cast<std::size_t>(T.rows()), m = constraints.size();
  std::vector<double> found(N * m);
  for (std::size_t k = 0; k < N; ++k) {
    const Pose pose = to_pose(T.data() + 16 * k, {"T_object_tool", static_cast<Py_ssize_t>(k)});
    for (std::size_t i = 0; i < m; ++i) found[k * m + i] = constraints[i]->value(pose);
  }
  return to_numpy(std::move(found), {N, m});
}

nb::object gradients(const Constraints& constraints, nb::handle T_in) {
  const Pose T = to_pose(Doubles(T_in, "T_object_tool", {4, 4}).data(), "T_object_tool");
  std::vector<double> rows;
  for (const PoseConstraint* constraint : constraints)
    for (double each : constraint->gradient(T)) rows.push_back(each);
  return to_numpy(std::move(rows), {constraints.size(), 6});
}

nb::tuple project_all(const Constraints& constraints_in, const Chain& chain, nb::handle tip_in, nb::handle object_in,
                      nb::handle seeds_in, nb::handle reference_in, nb::handle lower_in, nb::handle upper_in,
                      nb::handle weights_in, int max_iterations) {
  const Doubles tip(tip_in, "T_last_tip", {4, 4}), object(object_in, "T_world_object", {4, 4});
  const Doubles seeds(seeds_in, "seeds", {kAny, chain.n()}), reference(reference_in, "reference", {chain.n()});
  const Doubles lower(lower_in, "lower", {chain.n()}), upper(upper_in, "upper", {chain.n()});
  const Doubles weights(weights_in, "weights", {chain.n()});
  if (max_iterations < 1) throw nb::value_error("max_iterations: must be at least 1");
  const std::size_t n = static_cast<std::size_t>(chain.n()), K = static_cast<std::size_t>(seeds.rows());
  for (std::size_t j = 0; j < n; ++j) {
    if (!(weights[j] > 0.0)) throw nb::value_error("weights: must be over 0");
    if (!(lower[j] <= upper[j])) throw nb::value_error("lower: above upper");
  }
  std::vector<PoseConstraint> constraints;
  for (const PoseConstraint* each : constraints_in) constraints.push_back(*each);
  ProjectionProblem problem{chain,
                            to_pose(tip.data(), "T_last_tip"),
                            to_pose(object.data(), "T_world_object"),
                            constraints,
                            lower.data(),
                            upper.data(),
                            weights.data(),
                            reference.data()};
  problem.max_iterations = max_iterations;
  std::vector<double> Q(K * n), distances(K);
  std::vector<std::int32_t> are_met(K);
  {
    nb::gil_scoped_release unlocked;
    for (std::size_t k = 0; k < K; ++k) {
      const Projection found = project(problem, seeds.data() + k * n);
      std::copy(found.q.begin(), found.q.end(), Q.begin() + static_cast<std::ptrdiff_t>(k * n));
      distances[k] = std::sqrt(found.squared_distance);
      are_met[k] = found.is_met;
    }
  }
  return nb::make_tuple(to_numpy(std::move(Q), {K, n}), to_numpy(std::move(distances), {K}),
                        to_numpy(std::move(are_met), {K}));
}

}  // namespace

void bind_pose_constraints(nb::module_& m) {
  nb::enum_<ReferenceKind>(m, "ReferenceKind", nb::is_arithmetic(), "From what a distance is measured.")
      .value("PLANE", ReferenceKind::plane, "A plane: signed, positive on the side of its normal.")
      .value("LINE", ReferenceKind::line, "A line, e.g. the axis of a cylinder.")
      .value("POINT", ReferenceKind::point, "A point, e.g. the centre of a sphere.");
  nb::enum_<PoseConstraintKind>(m, "PoseConstraintKind", nb::is_arithmetic(),
                                R"(What a constraint on the pose of a tool bounds.

d is the distance of the tool's origin from the reference, n the unit normal there, away from the reference.)")
      .value("DISTANCE_AT_MOST", PoseConstraintKind::distance_at_most, "d - bound.")
      .value("DISTANCE_AT_LEAST", PoseConstraintKind::distance_at_least, "bound - d.")
      .value("TOOL_TO_FIXED", PoseConstraintKind::tool_to_fixed, "bound - (R tool) . fixed.")
      .value("TOOL_TO_NORMAL", PoseConstraintKind::tool_to_normal, "bound - (R tool) . n.")
      .value("NORMAL_TO_FIXED", PoseConstraintKind::normal_to_fixed, "bound - n . fixed.");
  nb::class_<PoseConstraint>(m, "PoseConstraint", "An inequality e(T) <= 0 on the pose of a tool in an object's frame.")
      .def("__init__", &make_constraint, "kind"_a, "reference"_a, "origin"_a, "axis"_a, "tool"_a, "fixed"_a, "bound"_a,
           nb::sig("def __init__(self, kind: PoseConstraintKind, reference: ReferenceKind, origin: " APC_F64
                   ", axis: " APC_F64 ", tool: " APC_F64 ", fixed: " APC_F64 ", bound: float) -> None"),
           R"(Make a constraint.

Args:
    kind: What is bounded.
    reference: Kind of the reference.
    origin: (3,) m, a point of it in the object frame.
    axis: (3,) unit, normal of the plane or direction of the line; anything for a point.
    tool: (3,) unit, a direction in the tool frame.
    fixed: (3,) unit, a direction in the object frame.
    bound: m for distances, else the cosine of the largest angle.)");
  m.def("pose_constraint_values", &values, "constraints"_a, "T_object_tool"_a,
        nb::sig("def pose_constraint_values(constraints: collections.abc.Sequence[PoseConstraint], T_object_tool: "
                APC_F64 ") -> " APC_F64),
        R"(Values of constraints at poses.

Args:
    constraints: m of them.
    T_object_tool: (N, 4, 4).

Returns:
    (N, m) m or cosines; a constraint is met where its value is not over 0.)");
  m.def("pose_constraint_gradients", &gradients, "constraints"_a, "T_object_tool"_a,
        nb::sig("def pose_constraint_gradients(constraints: collections.abc.Sequence[PoseConstraint], T_object_tool: "
                APC_F64 ") -> " APC_F64),
        R"(Gradients of constraints at a pose.

Args:
    constraints: m of them.
    T_object_tool: (4, 4).

Returns:
    (m, 6) derivatives by the velocity of the tool's origin in m, and by its angular velocity in rad, both along
    the axes of the object frame.)");
  m.def("project_to_constraints", &project_all, "constraints"_a, "chain"_a, "T_last_tip"_a, "T_world_object"_a,
        "seeds"_a, "reference"_a, "lower"_a, "upper"_a, "weights"_a, "max_iterations"_a = 40,
        nb::sig("def project_to_constraints(constraints: collections.abc.Sequence[PoseConstraint], chain: Chain, "
                "T_last_tip: " APC_F64 ", T_world_object: " APC_F64 ", seeds: " APC_F64 ", reference: " APC_F64
                ", lower: " APC_F64 ", upper: " APC_F64 ", weights: " APC_F64
                ", max_iterations: int = 40) -> tuple[" APC_F64 ", " APC_F64 ", " APC_I32 "]"),
        R"(Configurations near a reference whose tool poses meet all constraints, each by a descent from a seed.

By a descent along the constraints, each step a hierarchical QP of limits, constraints and distance.
Deterministic: the same arguments give the same bits.

Args:
    constraints: What the pose of the tip in the object frame has to meet.
    chain: The arm.
    T_last_tip: (4, 4) pose of the tip in frame L-1, m.
    T_world_object: (4, 4), m.
    seeds: (K, n) where the descents begin, in rad or m.
    reference: (n,) to which the distance is measured.
    lower: (n,) limits that all configurations keep.
    upper: (n,) limits that all configurations keep.
    weights: (n,) > 0, cost of the squared distance of each joint.
    max_iterations: Of each descent.

Returns:
    (K, n) the configurations, (K,) their weighted distances from the reference, and (K,) 1 where all
    constraints are met, else 0.)");
}

}  // namespace apc
