//! \file
//! pickcli.kernel.RaycastingScene.
#include "bindings/bindings.hpp"

#include "bindings/arrays.hpp"
#include "rendering/raycasting_scene.hpp"

namespace apc {
namespace {

using namespace nb::literals;

constexpr int kMostPixels = 100'000'000;

PinholeCamera to_camera(nb::handle intrinsics_in, nb::handle size_in) {
  const Doubles intrinsics(intrinsics_in, "intrinsics", {4});
  const Integers size(size_in, "size", {2});
  if (!(intrinsics[0] > 0.0 && intrinsics[1] > 0.0))
    throw nb::value_error("intrinsics: fx and fy must be positive");
  if (size[0] < 1 || size[1] < 1 || size[0] > kMostPixels / size[1])
    throw nb::value_error("size: width and height must be at least 1, with at most 1e8 pixels");
  return {intrinsics[0], intrinsics[1], intrinsics[2], intrinsics[3], size[0], size[1]};
}

std::vector<Plane> to_planes(const Doubles& planes, int first, int n) {
  std::vector<Plane> found;
  for (int k = first; k < first + n; ++k) {
    const double* p = planes.data() + 4 * k;
    const Vec3 normal{p[0], p[1], p[2]};
    if (!(std::abs(norm(normal) - 1.0) < 1e-6))
      throw nb::value_error(("planes[" + std::to_string(k) + "]: the normal must have length 1").c_str());
    found.push_back({normal, p[3]});
  }
  return found;
}

void make_scene(RaycastingScene* self, nb::handle poses_in, nb::handle half_in, nb::handle kind_in,
                nb::handle planes_in, nb::handle n_planes_in) {
  const Integers kind(kind_in, "kind", {kAny});
  const Py_ssize_t n = kind.rows();
  const Doubles poses(poses_in, "T_world_solid", {n, 4, 4}), half(half_in, "half_extents", {n, 3});
  const Doubles planes(planes_in, "planes", {kAny, 4});
  const Integers n_planes(n_planes_in, "n_planes", {n});
  std::vector<RenderedSolid> solids;
  int first = 0;
  for (Py_ssize_t i = 0; i < n; ++i) {
    const double* h = &half[3 * static_cast<std::size_t>(i)];
    const int k = kind[static_cast<std::size_t>(i)], cuts = n_planes[static_cast<std::size_t>(i)];
    if (k < 0 || k > 2)
      throw nb::value_error((Name("kind", i).text() + ": 0 is a box, 1 a cylinder, 2 a sphere").c_str());
    if (!(h[0] > 0.0 && h[1] > 0.0 && h[2] > 0.0) || (k > 0 && h[0] != h[1]) || (k == 2 && h[1] != h[2]))
      throw nb::value_error(
          (Name("half_extents", i).text() + ": must be positive, and radii where it is round").c_str());
    if (cuts < 0 || cuts > planes.rows() - first || (cuts > 0 && k != 0))
      throw nb::value_error(
          (Name("n_planes", i).text() + ": not the number of planes that cut this box").c_str());
    solids.push_back({to_pose(&poses[16 * static_cast<std::size_t>(i)], {"T_world_solid", i}),
                      {h[0], h[1], h[2]},
                      static_cast<simd8::SolidKind>(k),
                      to_planes(planes, first, cuts)});
    first += cuts;
  }
  if (first != planes.rows()) throw nb::value_error("n_planes: their sum is not the number of planes");
  new (self) RaycastingScene(std::move(solids));
}

nb::tuple cast_rays(const RaycastingScene& self, nb::handle intrinsics_in, nb::handle size_in,
                    nb::handle pose_in) {
  const PinholeCamera camera = to_camera(intrinsics_in, size_in);
  const Doubles pose(pose_in, "T_world_camera", {4, 4});
  const Pose T = to_pose(pose.data(), "T_world_camera");
  RayHits hits;
  std::vector<float> normals;
  {
    nb::gil_scoped_release unlocked;
    hits = self.cast_rays(camera, T);
    normals = self.normals(camera, T, hits);
  }
  const std::size_t H = static_cast<std::size_t>(camera.height), W = static_cast<std::size_t>(camera.width);
  return nb::make_tuple(to_numpy(std::move(hits.depth), {H, W}), to_numpy(std::move(hits.index), {H, W}),
                        to_numpy(std::move(normals), {H, W, 3}));
}

}  // namespace

void bind_rendering(nb::module_& m) {
  nb::class_<RaycastingScene>(m, "RaycastingScene", R"(Solids as a pinhole camera sees them.

A ray is cast for every pixel inside of the part of the picture that a solid may fill: no mesh, no graphics driver, one
thread, and the same bytes on every processor of a family. Depth is exact up to single precision.

Cameras are OpenCV's: x to the right, y down, z along the optical axis, and the middle of pixel (u, v) is at u, v. A
solid that the camera's centre is inside of is not seen, as it is the camera's own body; of any other one, only the
surface before the camera is.)")
      .def("__init__", &make_scene, "T_world_solid"_a, "half_extents"_a, "kind"_a, "planes"_a, "n_planes"_a,
           nb::sig("def __init__(self, T_world_solid: " APC_F64 ", half_extents: " APC_F64 ", kind: " APC_I32
                   ", planes: " APC_F64 ", n_planes: " APC_I32 ") -> None"),
           R"(Take solids.

Args:
    T_world_solid: (N, 4, 4) poses.
    half_extents: (N, 3) m > 0; of a cylinder (r, r, half length), of a sphere (r, r, r).
    kind: (N,) of SolidKind.
    planes: (P, 4) by which boxes are cut to convex pieces: (normal, offset) of the half-space normal . p <= offset in
        the frame of the box, those of each box together, in the order of the solids.
    n_planes: (N,) how many of them cut each solid; 0 for cylinders and spheres.)")
      .def("cast_rays", &cast_rays, "intrinsics"_a, "size"_a, "T_world_camera"_a,
           nb::sig("def cast_rays(self, intrinsics: " APC_F64 ", size: " APC_I32 ", T_world_camera: " APC_F64
                   ") -> tuple[" APC_F32 ", " APC_I32 ", " APC_F32 "]"),
           R"(See the solids.

Args:
    intrinsics: (4,) fx, fy, cx, cy in px.
    size: (2,) width and height in px.
    T_world_camera: (4, 4) pose of the camera.

Returns:
    Depth along the optical axis in m, (H, W), NaN where nothing is seen; the index of the solid, (H, W), -1 where
    nothing is seen; the outward normal of its surface in the camera's frame, (H, W, 3), NaN where nothing is seen.)");
}

}  // namespace apc
