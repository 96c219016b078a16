//! \file
//! pickcli.kernel.Checker.
#include "bindings/bindings.hpp"

#include <memory>

#include "bindings/arrays.hpp"
#include "collision/checker.hpp"
#include "collision/near_pairs.hpp"

namespace apc {
namespace {

using namespace nb::literals;

std::vector<Sphere> to_spheres(const Doubles& centers, const Doubles& radii) {
  std::vector<Sphere> spheres;
  for (std::size_t i = 0; i < radii.size(); ++i)
    spheres.push_back({{centers[3 * i], centers[3 * i + 1], centers[3 * i + 2]}, radii[i]});
  return spheres;
}

std::vector<int> to_ints(const Integers& values) { return {values.data(), values.data() + values.size()}; }

Robot make_robot(const Chain& chain, nb::handle centers_in, nb::handle radii_in, nb::handle frame_in,
                 nb::handle pairs_in, nb::handle fine_centers_in, nb::handle fine_radii_in,
                 nb::handle fine_frame_in) {
  const Doubles radii(radii_in, "radii", {kAny});
  const Doubles centers(centers_in, "centers", {radii.rows(), 3});
  const Integers frame(frame_in, "frame", {radii.rows()}), pairs(pairs_in, "self_pairs", {kAny, 2});
  std::vector<std::pair<int, int>> self_pairs;
  for (std::size_t i = 0; i + 1 < pairs.size(); i += 2) self_pairs.emplace_back(pairs[i], pairs[i + 1]);
  if (fine_centers_in.is_none() && fine_radii_in.is_none() && fine_frame_in.is_none())
    return Robot(chain, to_spheres(centers, radii), to_ints(frame), self_pairs);
  const Doubles fine_radii(fine_radii_in, "fine_radii", {kAny});
  const Doubles fine_centers(fine_centers_in, "fine_centers", {fine_radii.rows(), 3});
  const Integers fine_frame(fine_frame_in, "fine_frame", {fine_radii.rows()});
  return Robot(chain, to_spheres(centers, radii), to_ints(frame), self_pairs,
               to_spheres(fine_centers, fine_radii), to_ints(fine_frame));
}

SolidKind to_kind(int kind, const Name& name) {
  if (kind < 0 || kind > 2)
    throw nb::value_error((name.text() + ": 0 is a box, 1 a cylinder, 2 a sphere").c_str());
  return static_cast<SolidKind>(kind);
}

Solid to_solid(const Pose& T, const Vec3& half, SolidKind kind, double rounding, const Name& name) {
  try {
    return make_solid(T, half, kind, rounding);
  } catch (const std::invalid_argument& error) {
    throw nb::value_error((name.text() + ": " + error.what()).c_str());
  }
}

//! A row of numbers, or none: then all are zero.
template <typename T>
class Optional {
 public:
  Optional(nb::handle object, const char* name, Py_ssize_t n) {
    if (!object.is_none())
      values_ = std::make_unique<View<T>>(object, name, std::initializer_list<Py_ssize_t>{n});
  }
  T operator[](Py_ssize_t i) const { return values_ ? (*values_)[static_cast<std::size_t>(i)] : T{}; }

 private:
  std::unique_ptr<View<T>> values_;
};

void set_world(Checker& checker, nb::handle poses_in, nb::handle half_in, nb::handle ignored_in,
               nb::handle kind_in, nb::handle rounding_in) {
  const View<std::uint64_t> ignored(ignored_in, "ignored_frames", {kAny});
  const Py_ssize_t n = ignored.rows();
  const Doubles poses(poses_in, "T_world_box", {n, 4, 4}), half(half_in, "half_extents", {n, 3});
  const Optional<std::int32_t> kind(kind_in, "kind", n);
  const Optional<double> rounding(rounding_in, "rounding", n);
  std::vector<Obstacle> obstacles;
  for (Py_ssize_t b = 0; b < n; ++b) {
    const Solid solid =
        to_solid(to_pose(&poses[16 * b], {"T_world_box", b}), {half[3 * b], half[3 * b + 1], half[3 * b + 2]},
                 to_kind(kind[b], {"kind", b}), rounding[b], {"half_extents", b});
    obstacles.push_back({solid, ignored[b], static_cast<int>(b)});
  }
  checker.world().set_obstacles(std::move(obstacles));
}

void set_cloud(Checker& checker, nb::handle centers_in, double radius, double edge, double voxel,
               std::uint64_t ignored) {
  const Doubles centers(centers_in, "centers", {kAny, 3});
  const CloudPoints points{centers.data(), centers.rows(), radius, 0.5 * edge, voxel};
  checker.world().set_cloud(std::make_shared<const Cloud>(points), ignored);
}

void share_cloud(Checker& checker, const Checker& other, std::uint64_t ignored) {
  checker.world().set_cloud(other.world().cloud(), ignored);
}

void set_held(Checker& checker, nb::handle centers_in, nb::handle radii_in, nb::handle tested_in) {
  const Doubles radii(radii_in, "radii", {kAny});
  const Doubles centers(centers_in, "centers", {radii.rows(), 3});
  const Integers tested(tested_in, "tested_frames", {kAny});
  checker.robot().set_held(to_spheres(centers, radii), to_ints(tested));
}

void set_held_solid(Checker& checker, nb::handle pose_in, nb::handle half_in, nb::handle tested_in, int kind,
                    double rounding) {
  const Doubles pose(pose_in, "T_last_solid", {4, 4}), half(half_in, "half_extents", {3});
  const Integers tested(tested_in, "tested_frames", {kAny});
  const Solid solid = to_solid(to_pose(pose.data(), "T_last_solid"), {half[0], half[1], half[2]},
                               to_kind(kind, "kind"), rounding, "half_extents");
  checker.robot().set_held(solid, to_ints(tested));
}

//! Half-widths of the tube, or none. Raises ValueError for a negative one.
class Slack {
 public:
  Slack(nb::handle object, std::initializer_list<Py_ssize_t> shape) {
    if (object.is_none()) return;
    values_ = std::make_unique<Doubles>(object, "slack", shape);
    for (std::size_t i = 0; i < values_->size(); ++i)
      if ((*values_)[i] < 0.0) throw nb::value_error("slack must not be negative");
  }
  const double* row(int i, int n) const {
    return values_ ? values_->data() + static_cast<std::size_t>(i) * static_cast<std::size_t>(n) : nullptr;
  }

 private:
  std::unique_ptr<Doubles> values_;
};

EdgeReport check_edge(const Checker& checker, nb::handle q0_in, nb::handle q1_in, double margin,
                      nb::handle slack_in, double resolution) {
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

int first_blocked_edge(const Checker& checker, nb::handle Q_in, double margin, nb::handle slack_in,
                 double resolution) {
  const int n = checker.n();
  const Doubles Q(Q_in, "Q", {kAny, n});
  if (Q.size() == 0) throw nb::value_error("Q: a path has at least one configuration");
  const Slack slack(slack_in, {Q.rows() - 1, n});
  check_range(Q, "Q");
  check_margin(margin);
  check_resolution(resolution);
  nb::gil_scoped_release unlocked;
  if (Q.rows() == 1) return checker.check_edge(Q.data(), Q.data(), margin, nullptr, resolution).free ? -1 : 0;
  return checker.first_blocked_edge(Q.data(), Q.rows(), margin, slack.row(0, n), resolution);
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

void check_max_distance(double max_distance) {
  if (!(max_distance >= 0.0)) throw nb::value_error("max_distance must not be negative");
}

nb::tuple clearance(const Checker& checker, nb::handle q_in, double max_distance) {
  const Doubles q(q_in, "q", {checker.n()});
  check_range(q, "q");
  check_max_distance(max_distance);
  const Contact c = checker.clearance(q.data(), max_distance);
  return nb::make_tuple(c.distance, c.frame, c.kind, c.index);
}

nb::object clearances(const Checker& checker, nb::handle Q_in, double max_distance) {
  const Doubles Q(Q_in, "Q", {kAny, checker.n()});
  check_range(Q, "Q");
  check_max_distance(max_distance);
  std::vector<double> out(static_cast<std::size_t>(Q.rows()));
  {
    nb::gil_scoped_release unlocked;
    checker.clearances(Q.data(), Q.rows(), max_distance, out.data());
  }
  const std::size_t n_rows = out.size();
  return to_numpy(std::move(out), {n_rows});
}

nb::tuple pairs_near(const Checker& checker, nb::handle q_in, double influence) {
  const Doubles q(q_in, "q", {checker.n()});
  check_range(q, "q");
  check_max_distance(influence);
  const std::vector<NearPair> found = near_pairs(checker, q.data(), influence);
  const std::size_t K = found.size(), n = static_cast<std::size_t>(checker.n());
  std::vector<double> distances, gradients;
  std::vector<std::int32_t> parts;
  for (const NearPair& pair : found) {
    distances.push_back(pair.contact.distance);
    gradients.insert(gradients.end(), pair.gradient.begin(), pair.gradient.end());
    parts.insert(parts.end(), {pair.contact.frame, static_cast<int>(pair.contact.kind), pair.contact.index});
  }
  return nb::make_tuple(to_numpy(std::move(distances), {K}), to_numpy(std::move(gradients), {K, n}),
                        to_numpy(std::move(parts), {K, 3}));
}

nb::tuple clearest(const Checker& checker, nb::handle Q_in, int n_most, double max_distance) {
  const Doubles Q(Q_in, "Q", {kAny, checker.n()});
  check_range(Q, "Q");
  check_max_distance(max_distance);
  if (n_most < 0) throw nb::value_error("n_most must not be negative");
  std::vector<int> rows;
  std::vector<double> distances;
  {
    nb::gil_scoped_release unlocked;
    for (const ClearRow& each : checker.clearest(Q.data(), Q.rows(), n_most, max_distance))
      rows.push_back(each.row), distances.push_back(each.distance);
  }
  const std::size_t n_rows = rows.size();
  return nb::make_tuple(to_numpy(std::move(rows), {n_rows}), to_numpy(std::move(distances), {n_rows}));
}

}  // namespace

namespace {

void bind_setters(nb::class_<Checker>& checker) {
  checker
      .def(
          "bare", [](const Checker& self) { return Checker(self.robot().bare()); },
          "The same robot with nothing around it and nothing held: a fraction of the time that its spheres take.")
      .def("set_world", &set_world, "T_world_box"_a, "half_extents"_a, "ignored_frames"_a,
           "kind"_a = nb::none(), "rounding"_a = nb::none(),
           nb::sig("def set_world(self, T_world_box: " APC_F64 ", half_extents: " APC_F64
                   ", ignored_frames: " APC_U64 ", kind: " APC_I32 " | None = None, rounding: " APC_F64
                   " | None = None) -> None"),
           R"(Replace the solids of the world; its cloud stays.

Args:
    T_world_box: (B, 4, 4) poses of the solids' boxes, m.
    half_extents: (B, 3) of the boxes, m; see SolidKind.
    ignored_frames: (B,) bit f set: frame f is never tested against the solid; bit L is the held item.
    kind: (B,) of SolidKind; all are boxes unless given.
    rounding: (B,) m, adds every point within that distance; 0 unless given.)")
      .def("set_cloud", &set_cloud, "centers"_a, "radius"_a, "edge"_a = 0.0, "voxel"_a = 0.0,
           "ignored_frames"_a = 0,
           nb::sig("def set_cloud(self, centers: " APC_F64
                   ", radius: float, edge: float = 0.0, voxel: float = 0.0, ignored_frames: int = 0) -> None"),
           R"(Replace the cloud of the world, points or the cubes of an occupancy grid; the solids stay.

Nothing comes nearer to any point of the cloud than radius and the margin that is asked for. Where voxel is
given, the points in one of its cells become one ball around them, which holds no less. Distances are those
from the cloud as it is kept, in single precision and rounded outwards.

Args:
    centers: (N, 3) m, in the world; none: no cloud.
    radius: m around each that counts as it.
    edge: m, of a cube around each, along the axes of the world; 0: points.
    voxel: m, edge of the cells of the filter; 0: every point is kept.
    ignored_frames: Bit f set: frame f is never tested against the cloud; bit L is the held item.)")
      .def("share_cloud", &share_cloud, "other"_a, "ignored_frames"_a = 0,
           nb::sig("def share_cloud(self, other: Checker, ignored_frames: int = 0) -> None"),
           R"(Replace the cloud of the world by that of another checker, which is not copied.

Args:
    other: The other checker.
    ignored_frames: Bit f set: frame f is never tested against the cloud; bit L is the held item.)")
      .def("set_held", &set_held, "centers"_a, "radii"_a, "tested_frames"_a,
           nb::sig("def set_held(self, centers: " APC_F64 ", radii: " APC_F64 ", tested_frames: " APC_I32
                   ") -> None"),
           R"(Replace the held item by spheres, rigid in frame L-1; empty arrays: nothing is held.

Args:
    centers: (H, 3) in frame L-1, m.
    radii: (H,) m.
    tested_frames: (T,) frames that the spheres must stay clear of.)")
      .def("set_held_solid", &set_held_solid, "T_last_solid"_a, "half_extents"_a, "tested_frames"_a,
           "kind"_a = 0, "rounding"_a = 0.0,
           nb::sig("def set_held_solid(self, T_last_solid: " APC_F64 ", half_extents: " APC_F64
                   ", tested_frames: " APC_I32 ", kind: int = 0, rounding: float = 0.0) -> None"),
           R"(Replace the held item by one solid, rigid in frame L-1.

Its distance from the frames is exact. That from the world is judged by the widest slab between the two that a
few directions give: never too large, and too small by a few per mille at most.

Args:
    T_last_solid: (4, 4) pose in frame L-1, m.
    half_extents: (3,) m; see SolidKind.
    tested_frames: (T,) frames that the solid must stay clear of.
    kind: Of SolidKind.
    rounding: m, adds every point within that distance.)");
}

void bind_checks(nb::class_<Checker>& checker) {
  checker
      .def("is_free", &is_free, "q"_a, "margin"_a = 0.0,
           nb::sig("def is_free(self, q: " APC_F64 ", margin: float = 0.0) -> bool"),
           "Whether everything at q (n,) keeps more than margin, in m.")
      .def("are_free", &are_free, "Q"_a, "margin"_a = 0.0,
           nb::sig("def are_free(self, Q: " APC_F64 ", margin: float = 0.0) -> " APC_BOOL),
           "Whether everything keeps more than margin, in m, at each of Q (N, n): (N,).")
      .def("edge_is_free", &edge_is_free, "q0"_a, "q1"_a, "margin"_a = 0.0, "slack"_a = nb::none(),
           "resolution"_a = 2e-4,
           nb::sig("def edge_is_free(self, q0: " APC_F64 ", q1: " APC_F64
                   ", margin: float = 0.0, slack: " APC_F64
                   " | None = None, resolution: float = 0.0002) -> bool"),
           R"(Whether every configuration on a straight segment, and in a tube around it, is proven free.

True is a proof. False means that some point of it comes closer than margin plus what slack moves it plus
resolution, where splitting the edge further ends.

Args:
    q0: (n,) where the edge begins.
    q1: (n,) where it ends.
    margin: m that everything keeps more than.
    slack: (n,) rad or m, half width of the tube in each joint; none unless given.
    resolution: m, distance up to which an edge is split.)")
      .def("first_blocked_edge", &first_blocked_edge, "Q"_a, "margin"_a = 0.0, "slack"_a = nb::none(),
           "resolution"_a = 2e-4,
           nb::sig("def first_blocked_edge(self, Q: " APC_F64 ", margin: float = 0.0, slack: " APC_F64
                   " | None = None, resolution: float = 0.0002) -> int"),
           R"(Index of the first edge of a polyline that is not proven free, -1 if all are.

Args:
    Q: (N, n) vertices; a single one counts as an edge of no length.
    margin: m that everything keeps more than.
    slack: (N-1, n) rad or m, half width of the tube around each edge; none unless given.
    resolution: m, distance up to which an edge is split.)")
      .def("check_edge", &check_edge, "q0"_a, "q1"_a, "margin"_a = 0.0, "slack"_a = nb::none(),
           "resolution"_a = 2e-4,
           nb::sig("def check_edge(self, q0: " APC_F64 ", q1: " APC_F64
                   ", margin: float = 0.0, slack: " APC_F64
                   " | None = None, resolution: float = 0.0002) -> EdgeReport"),
           R"(Whether a straight segment, and a tube around it, is proven free, and where it is not.

Args:
    q0: (n,) where the edge begins.
    q1: (n,) where it ends.
    margin: m that everything keeps more than.
    slack: (n,) rad or m, half width of the tube in each joint; none unless given.
    resolution: m, distance up to which an edge is split.

Returns:
    Whether it is free, as from edge_is_free; if not, the place on the edge.)")
      .def("clearance", &clearance, "q"_a, "max_distance"_a = 1.0,
           nb::sig("def clearance(self, q: " APC_F64
                   ", max_distance: float = 1.0) -> tuple[float, int, ContactKind, int]"),
           R"(Signed distance of the nearest pair at a configuration, in double precision.

Against a box it is negative by the depth of the sphere below the nearest face.

Args:
    q: (n,) configuration.
    max_distance: m beyond which nothing is looked for.

Returns:
    Distance in m, frame, kind and index as in EdgeReport; (max_distance, -1, NONE, -1) if nothing is
    nearer.)")
      .def("clearances", &clearances, "Q"_a, "max_distance"_a = 1.0,
           nb::sig("def clearances(self, Q: " APC_F64 ", max_distance: float = 1.0) -> " APC_F64),
           "The distances (N,) in m that clearance finds at each of Q (N, n).")
      .def("near_pairs", &pairs_near, "q"_a, "influence"_a,
           nb::sig("def near_pairs(self, q: " APC_F64 ", influence: float) -> tuple[" APC_F64 ", " APC_F64 ", " APC_I32
                   "]"),
           R"(Pairs of frames and solids or other frames that are near each other, with gradients of their distances.

Args:
    q: (n,) configuration.
    influence: m, beyond which no pair counts.

Returns:
    (K,) signed distances in m, of the few nearest spheres of each pair; (K, n) their gradients, in m per rad or
    m; and (K, 3) frame, kind (a ContactKind) and index of each pair, as in EdgeReport.

Raises:
    ValueError: A solid is held.)")
      .def("clearest", &clearest, "Q"_a, "n_most"_a, "max_distance"_a = 1.0,
           nb::sig("def clearest(self, Q: " APC_F64 ", n_most: int, max_distance: float = 1.0) -> tuple[" APC_I32
                   ", " APC_F64 "]"),
           R"(The configurations with the largest clearances, in a fraction of the time that all clearances take.

Args:
    Q: (N, n) configurations.
    n_most: How many are wanted.
    max_distance: m beyond which nothing is looked for.

Returns:
    Rows (K,) of Q, K = min(N, n_most), the clearest first, equal ones in their order; and their clearances
    (K,) in m.)");
}

}  // namespace

void bind_checker(nb::module_& m) {
  nb::class_<Checker> checker(
      m, "Checker",
      R"(Collision checks of a chain whose frames carry spheres, in a world of boxes, cylinders and spheres.

Checks may run in several threads; set_world and set_held must not run meanwhile.)");
  checker
      .def(
          "__init__",
          [](Checker* self, const Chain& chain, nb::handle centers, nb::handle radii, nb::handle frame,
             nb::handle self_pairs, nb::handle fine_centers, nb::handle fine_radii, nb::handle fine_frame) {
            new (self) Checker(make_robot(chain, centers, radii, frame, self_pairs, fine_centers, fine_radii,
                                          fine_frame));
          },
          "chain"_a, "centers"_a, "radii"_a, "frame"_a, "self_pairs"_a, "fine_centers"_a = nb::none(),
          "fine_radii"_a = nb::none(), "fine_frame"_a = nb::none(),
          nb::sig("def __init__(self, chain: Chain, centers: " APC_F64 ", radii: " APC_F64 ", frame: " APC_I32
                  ", self_pairs: " APC_I32 ", fine_centers: " APC_F64 " | None = None, fine_radii: " APC_F64
                  " | None = None, fine_frame: " APC_I32 " | None = None) -> None"),
          R"(Make a checker in an empty world.

Args:
    chain: The robot's.
    centers: (S, 3) of spheres in their frames, m.
    radii: (S,) m.
    frame: (S,) in 0..L-1, that carries each.
    self_pairs: (P, 2) pairs of frames that must stay clear of each other.
    fine_centers: (F, 3) of tighter spheres, m. Two frames are clear of each other where either their spheres
        are or these, of a frame that has any; what is held is tested against these alone.
    fine_radii: (F,) m.
    fine_frame: (F,) in 0..L-1, that carries each.)")
      .def_prop_ro(
          "rounding",
          [](const Checker& self) {
            const Robot& robot = self.robot();
            return robot.self_rounding(1.0) + self.world().rounding(robot.reach(1.0));
          },
          R"(Bound in m on what is_free, are_free and edges add to the margin for single precision.

It holds for at most 1 m of prismatic travel, and grows with travel.)");
  bind_setters(checker);
  bind_checks(checker);
}

}  // namespace apc
