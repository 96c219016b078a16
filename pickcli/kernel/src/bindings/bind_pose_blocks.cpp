//! \file
//! pickcli.kernel: SurfaceKind, and prove_pose_blocks.
#include "bindings/bindings.hpp"

#include <algorithm>
#include <vector>

#include "bindings/arrays.hpp"
#include "collision/checker.hpp"
#include "collision/pose_blocks.hpp"

namespace apc {
namespace {

using namespace nb::literals;

constexpr double kRightAngle = 1.5707963268;  // rad, rounded up

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
    if (!(low[at] >= -kRightAngle && high[at] <= kRightAngle))
      throw nb::value_error("low, high: an elevation over a right angle");
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

void bind_pose_blocks(nb::module_& m) {
  nb::enum_<SurfaceKind>(m, "SurfaceKind", nb::is_arithmetic(),
                         "What the palm of a tool is about, and its coordinates.")
      .value("PLANE", SurfaceKind::plane, "x, y, z.")
      .value("CYLINDER", SurfaceKind::cylinder, "Azimuth, height, distance from the axis.")
      .value("SPHERE", SurfaceKind::sphere, "Azimuth, elevation, distance from the middle.");
  m.def("prove_pose_blocks", &prove_blocks, "checker"_a, "surface"_a, "T_world_surface"_a, "wanted"_a, "R_nominal"_a,
        "cone"_a, "centers"_a, "radii"_a, "frames"_a, "low"_a, "high"_a, "margin"_a, "smallest"_a, "most_cells"_a,
        nb::sig("def prove_pose_blocks(checker: Checker, surface: SurfaceKind, T_world_surface: " APC_F64
                ", wanted: " APC_F64
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
