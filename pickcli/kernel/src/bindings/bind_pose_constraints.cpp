//! \file
//! pickcli.kernel: PoseConstraint, its kinds, and what is computed of many of them.
#include "bindings/bindings.hpp"

#include <nanobind/stl/vector.h>

#include <algorithm>

#include "bindings/arrays.hpp"
#include "collision/checker.hpp"
#include "collision/pose_blocks.hpp"
#include "control/pose_constraints.hpp"
#include "control/projection.hpp"

namespace apc {
namespace {

using namespace nb::literals;

Vec3 vector_of(nb::handle in, const char* name) {
  const Doubles v(in, name, {3});
  return {v[0], v[1], v[2]};
}

Vec3 unit_of(nb::handle in, const char* name) {
  const Vec3 v = vector_of(in, name);
  const double length = norm(v);
  if (!(std::abs(length - 1.0) < 1e-6)) throw nb::value_error((std::string(name) + ": not of unit length").c_str());
  return (1.0 / length) * v;
}

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

nb::object prove_blocks(const Checker& checker, SurfaceKind surface, nb::handle T_in, nb::handle wanted_in,
                       nb::handle R_in, double cone, nb::handle centers_in, nb::handle radii_in, nb::handle frames_in,
                       nb::handle low_in, nb::handle high_in, double margin, double smallest, int most_cells) {
  const Doubles T(T_in, "T_world_surface", {4, 4}), R(R_in, "R_nominal", {3, 3});
  const Doubles centers(centers_in, "centers", {kAny, 3});
  const Doubles radii(radii_in, "radii", {centers.rows()}), low(low_in, "low", {kAny, 6});
  const Doubles high(high_in, "high", {low.rows(), 6});
  const Integers frames(frames_in, "frames", {centers.rows()});
  check_margin(margin);
  if (!(smallest > 0.0)) throw nb::value_error("smallest: must be over 0");
  if (!(cone >= 0.0 && cone < 4.0)) throw nb::value_error("cone: must be an angle from 0 on");
  for (std::size_t i = 0; i < radii.size(); ++i)
    if (!(radii[i] >= 0.0)) throw nb::value_error("radii: must not be negative");
  for (std::size_t i = 0; i < low.size(); ++i)
    if (!(low[i] <= high[i])) throw nb::value_error("low: above high");
  EnvelopeChart chart{surface, to_pose(T.data(), "T_world_surface"), unit_of(wanted_in, "wanted"), {}, cone};
  const double as_pose[16] = {R[0], R[1], R[2], 0, R[3], R[4], R[5], 0, R[6], R[7], R[8], 0, 0, 0, 0, 1};
  chart.R_nominal = to_pose(as_pose, "R_nominal").R;
  if (surface != SurfaceKind::plane) {
    const Vec3 off = cross(chart.wanted, chart.T_world_surface.R.column(2));
    if (norm(off) > 1e-6) throw nb::value_error("wanted: not along the axis of a round surface");
    for (int i = 0; i < low.rows(); ++i)
      if (!(low[6 * static_cast<std::size_t>(i) + 2] >= 0.0)) throw nb::value_error("low: a negative distance");
  }
  for (int i = 0; surface == SurfaceKind::sphere && i < low.rows(); ++i) {
    const std::size_t at = 6 * static_cast<std::size_t>(i) + 1;
    if (!(low[at] >= -1.5707963268 && high[at] <= 1.5707963268)) throw nb::value_error("low, high: an elevation over a right angle");
  }
  std::vector<ToolSphere> spheres;
  for (std::size_t i = 0; i < radii.size(); ++i) {
    if (frames[i] < 0 || frames[i] > kMaxFrames) throw nb::value_error("frames: out of range");
    spheres.push_back({{centers[3 * i], centers[3 * i + 1], centers[3 * i + 2]}, radii[i], frames[i]});
  }
  const std::size_t M = static_cast<std::size_t>(low.rows());
  std::vector<std::int32_t> are_free(M);
  {
    nb::gil_scoped_release unlocked;
    const ProofEffort effort{margin, smallest, most_cells};
    for (std::size_t i = 0; i < M; ++i) {
      const int blocked =
          first_unproven(chart, spheres, checker.world(), low.data() + 6 * i, high.data() + 6 * i, effort);
      are_free[i] = blocked < 0;
      // What is in the way of a block probably is in that of the next one.
      if (blocked > 0) std::rotate(spheres.begin(), spheres.begin() + blocked, spheres.begin() + blocked + 1);
    }
  }
  return to_numpy(std::move(are_free), {M});
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
  nb::enum_<SurfaceKind>(m, "SurfaceKind", nb::is_arithmetic(), "What the palm of a tool is about, and its coordinates.")
      .value("PLANE", SurfaceKind::plane, "x, y, z.")
      .value("CYLINDER", SurfaceKind::cylinder, "Azimuth, height, distance from the axis.")
      .value("SPHERE", SurfaceKind::sphere, "Azimuth, elevation, distance from the middle.");
  m.def("prove_pose_blocks", &prove_blocks, "checker"_a, "surface"_a, "T_world_surface"_a, "wanted"_a, "R_nominal"_a,
        "cone"_a, "centers"_a, "radii"_a, "frames"_a, "low"_a, "high"_a, "margin"_a, "smallest"_a, "most_cells"_a,
        nb::sig("def prove_pose_blocks(checker: Checker, surface: SurfaceKind, T_world_surface: " APC_F64 ", wanted: " APC_F64
                ", R_nominal: " APC_F64 ", cone: float, centers: " APC_F64 ", radii: " APC_F64 ", frames: " APC_I32
                ", low: " APC_F64 ", high: " APC_F64 ", margin: float, smallest: float, most_cells: int) -> "
                APC_I32),
        R"(Prove a tool without its arm free at every pose of blocks of an envelope.

Args:
    checker: Its world, and which solids each frame may touch.
    surface: What the palm is about.
    T_world_surface: (4, 4) frame of the surface, m.
    wanted: (3,) unit, in the world: the axis across the normal from which roll is measured.
    R_nominal: (3, 3) the tool in the frame of that axis and the approach.
    cone: rad, half of the opening of the approach's cone.
    centers: (S, 3) m, spheres of the tool in the frame of the palm.
    radii: (S,) m.
    frames: (S,) of each sphere.
    low: (M, 6) least coordinates of the surface, roll and rotation vector across the normal, in m and rad.
    high: (M, 6) the greatest ones.
    margin: m, kept from everything.
    smallest: m of clearance beyond the margin that is not looked for.
    most_cells: Into which a block is divided.

Returns:
    (M,) 1 where a block is proven free, else 0.)");
}

}  // namespace apc
