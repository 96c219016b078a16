//! \file
//! pickcli.kernel.RaycastingScene.
#include "bindings/bindings.hpp"

#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/vector.h>

#include "bindings/arrays.hpp"
#include "rendering/counter_random.hpp"
#include "rendering/depth_noise.hpp"
#include "rendering/raycasting_scene.hpp"
#include "rendering/shading.hpp"

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

nb::object measured_depth_of(const RaycastingScene& self, nb::handle intrinsics_in, nb::handle size_in,
                             nb::handle pose_in, const DepthNoise& noise, nb::handle no_return_in,
                             std::uint64_t seed) {
  const PinholeCamera camera = to_camera(intrinsics_in, size_in);
  const Doubles pose(pose_in, "T_world_camera", {4, 4});
  const Pose T = to_pose(pose.data(), "T_world_camera");
  const Doubles shares(no_return_in, "no_return", {static_cast<Py_ssize_t>(self.solids().size())});
  std::vector<float> no_return, depth;
  for (std::size_t i = 0; i < shares.size(); ++i) {
    if (!(shares[i] >= 0.0 && shares[i] <= 1.0))
      throw nb::value_error("no_return: must be shares from 0 to 1");
    no_return.push_back(static_cast<float>(shares[i]));
  }
  {
    nb::gil_scoped_release unlocked;
    depth = measured_depth(self, camera, T, noise, no_return, seed);
  }
  return to_numpy(std::move(depth),
                  {static_cast<std::size_t>(camera.height), static_cast<std::size_t>(camera.width)});
}

nb::object philox_of(nb::handle counter_in, nb::handle key_in) {
  const View<std::uint64_t> counter(counter_in, "counter", {4}), key(key_in, "key", {2});
  Words words;
  for (std::size_t i = 0; i < 4; ++i) words[i] = static_cast<std::uint32_t>(counter[i]);
  words = philox(words, static_cast<std::uint32_t>(key[0]), static_cast<std::uint32_t>(key[1]));
  return to_numpy(std::vector<std::uint64_t>(words.begin(), words.end()), {4});
}

using Pixels = nb::ndarray<const std::uint8_t, nb::shape<-1, -1, 3>, nb::c_contig, nb::device::cpu>;

Colour to_colour(const double* rgb) {
  return {static_cast<float>(rgb[0]), static_cast<float>(rgb[1]), static_cast<float>(rgb[2])};
}

void make_looks(Looks* self, nb::handle colours_in, nb::handle gloss_in, nb::handle faces_in,
                const std::vector<std::shared_ptr<Texture>>& textures) {
  const Doubles gloss(gloss_in, "gloss", {kAny});
  const Doubles colours(colours_in, "colours", {gloss.rows(), 3});
  const Integers faces(faces_in, "face_textures", {gloss.rows(), 6});
  Looks looks;
  looks.textures.assign(textures.begin(), textures.end());
  for (std::size_t i = 0; i < gloss.size(); ++i) {
    Look look{to_colour(&colours[3 * i]), static_cast<float>(gloss[i]), {}};
    for (std::size_t face = 0; face < 6; ++face) {
      look.textures[face] = faces[6 * i + face];
      if (look.textures[face] < -1 || look.textures[face] >= static_cast<int>(textures.size()))
        throw nb::value_error(
            (Name("face_textures", static_cast<Py_ssize_t>(i)).text() + ": no such texture").c_str());
    }
    looks.of_solids.push_back(look);
  }
  new (self) Looks(std::move(looks));
}

Lighting make_lighting(double ambient, double headlight, double lamp, nb::handle pose_in,
                       nb::handle background_in) {
  const Doubles pose(pose_in, "T_world_lamp", {4, 4}), background(background_in, "background", {3});
  return {ambient, headlight, lamp, to_pose(pose.data(), "T_world_lamp"), to_colour(background.data())};
}

nb::object shaded_of(const RaycastingScene& self, nb::handle intrinsics_in, nb::handle size_in,
                     nb::handle pose_in, const Looks& looks, const Lighting& lighting) {
  const PinholeCamera camera = to_camera(intrinsics_in, size_in);
  const Doubles pose(pose_in, "T_world_camera", {4, 4});
  const Pose T = to_pose(pose.data(), "T_world_camera");
  if (looks.of_solids.size() != self.solids().size()) throw nb::value_error("looks: not of as many solids");
  std::vector<std::uint8_t> picture;
  {
    nb::gil_scoped_release unlocked;
    picture = shaded(self, camera, T, looks, lighting);
  }
  return to_numpy(std::move(picture),
                  {static_cast<std::size_t>(camera.height), static_cast<std::size_t>(camera.width), 3});
}

void make_texture(Texture* self, const Pixels& picture) {
  if (picture.size() == 0) throw nb::value_error("picture: has no pixels");
  new (self) Texture(picture.data(), static_cast<int>(picture.shape(1)), static_cast<int>(picture.shape(0)));
}

void bind_looks(nb::module_& m) {
  nb::class_<Texture>(m, "Texture", "A picture on a face, with smaller copies for what is far away.")
      .def("__init__", &make_texture, "picture"_a, nb::sig("def __init__(self, picture: " APC_U8 ") -> None"),
           R"(Take a picture.

Args:
    picture: (height, width, 3) red, green, blue, rows from the top.)");
  nb::class_<Looks>(m, "Looks", "How solids look.")
      .def("__init__", &make_looks, "colours"_a, "gloss"_a, "face_textures"_a, "textures"_a,
           nb::sig("def __init__(self, colours: " APC_F64 ", gloss: " APC_F64 ", face_textures: " APC_I32
                   ", textures: collections.abc.Sequence[Texture]) -> None"),
           R"(Take colours and textures.

The faces of boxes, and of the boxes around balls, are +x, -x, +y, -y, +z, -z; those of cylinders +z, -z, mantle. From
outside, +z is up on all but +z and -z, where +y is; the mantle begins at +x and goes on towards +y. Convex pieces have
no textures.

Args:
    colours: (N, 3) red, green, blue, 0 to 255, of faces without a texture.
    gloss: (N,) of highlights, 0 to 1.
    face_textures: (N, 6) index of the texture of each face, -1 for none.
    textures: The textures.)");
  nb::class_<Lighting>(m, "Lighting", "Where light comes from.")
      .def(
          "__init__",
          [](Lighting* self, double ambient, double headlight, double lamp, nb::handle T_world_lamp,
             nb::handle background) {
            new (self) Lighting(make_lighting(ambient, headlight, lamp, T_world_lamp, background));
          },
          "ambient"_a, "headlight"_a, "lamp"_a, "T_world_lamp"_a, "background"_a,
          nb::sig("def __init__(self, ambient: float, headlight: float, lamp: float, T_world_lamp: " APC_F64
                  ", background: " APC_F64 ") -> None"),
          R"(Take amounts of light, of which 1 makes a white surface white.

Args:
    ambient: From everywhere; a quarter less from below than from above.
    headlight: Of a light at the camera, on a surface square to it 0.5 m away.
    lamp: Of a lamp, on a surface square to its light.
    T_world_lamp: (4, 4) pose of the lamp; it shines along its z and throws shadows within 45 degrees of that.
    background: (3,) red, green, blue, 0 to 255, where nothing is seen.)");
}

void bind_noise(nb::module_& m) {
  const DepthNoise none;
  nb::class_<DepthNoise>(m, "DepthNoise", R"(Coefficients of a depth sensor.

The error of a depth z has the standard deviation constant + quadratic (z - from)^2 + disparity_error z^2 / (fx
baseline). Where a surface is met at an angle t > oblique_from to its normal, oblique / sqrt(z) t^2 / (pi/2 - t)^2 is
added. The first and the last are the terms of Nguyen, Izadi and Lovell 2012 for structured light, the third is that of
stereo.)")
      .def(
          "__init__",
          [](DepthNoise* self, double least, double greatest, double incidence_from, double incidence_to,
             double constant, double quadratic, double from, double oblique, double oblique_from,
             double baseline, double disparity_error, double disparity_step, double correlation,
             double lateral, double lateral_oblique, bool mixes_edges) {
            const DepthNoise noise{constant,        quadratic,      from,     oblique,     oblique_from,
                                   disparity_error, disparity_step, baseline, correlation, lateral,
                                   lateral_oblique, mixes_edges,    least,    greatest,    incidence_from,
                                   incidence_to};
            check(noise);
            new (self) DepthNoise(noise);
          },
          nb::kw_only(), "least"_a, "greatest"_a, "incidence_from"_a, "incidence_to"_a, "constant"_a = 0.0,
          "quadratic"_a = 0.0, "from_depth"_a = 0.0, "oblique"_a = 0.0, "oblique_from"_a = 0.0,
          "baseline"_a = 0.0, "disparity_error"_a = 0.0, "disparity_step"_a = 0.0, "correlation"_a = 0.0,
          "lateral"_a = 0.0, "lateral_oblique"_a = 0.0, "mixes_edges"_a = false,
          R"(Take coefficients.

Args:
    least: m > 0, the nearest depth that is measured.
    greatest: m, the farthest one.
    incidence_from: rad, angle to the normal up to which all comes back.
    incidence_to: rad, at most pi/2, from which on nothing does; linear in between.
    constant: m.
    quadratic: 1/m.
    from_depth: m.
    oblique: m^1.5.
    oblique_from: rad.
    baseline: m to the second eye, along the camera's x; what it does not see has no depth. 0 without one.
    disparity_error: px.
    disparity_step: px, in whole multiples of which disparities come; 0 for any.
    correlation: px, width of the Gaussian filter that makes errors of neighbours alike, 0.5 to 2; 0 for none.
    lateral: px, standard deviation by which edges are off along rows and columns.
    lateral_oblique: px, times t / (pi/2 - t), added to it.
    mixes_edges: Whether pixels at edges get depths between those of both surfaces, as by time of flight.

Raises:
    ValueError: No sensor can have them.)");
  m.def("philox4x32", &philox_of, "counter"_a, "key"_a,
        nb::sig("def philox4x32(counter: " APC_U64 ", key: " APC_U64 ") -> " APC_U64),
        R"(The random words of noise: Philox4x32-10 of Salmon, Moraes, Dror and Shaw 2011.

Args:
    counter: (4,) of 32 bits each.
    key: (2,) of 32 bits each.

Returns:
    (4,) of 32 bits each.)");
}

}  // namespace

void bind_rendering(nb::module_& m) {
  bind_noise(m);
  bind_looks(m);
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
    nothing is seen; the outward normal of its surface in the camera's frame, (H, W, 3), NaN where nothing is seen.)")
      .def("measured_depth", &measured_depth_of, "intrinsics"_a, "size"_a, "T_world_camera"_a, "noise"_a,
           "no_return"_a, "seed"_a,
           nb::sig("def measured_depth(self, intrinsics: " APC_F64 ", size: " APC_I32
                   ", T_world_camera: " APC_F64 ", noise: DepthNoise, no_return: " APC_F64
                   ", seed: int) -> " APC_F32),
           R"(See the solids as a depth sensor does.

What a pixel draws depends on its place and the seed alone: equal seeds give equal bytes.

Args:
    intrinsics: (4,) fx, fy, cx, cy in px.
    size: (2,) width and height in px.
    T_world_camera: (4, 4) pose of the camera.
    noise: Coefficients of the sensor.
    no_return: (N,) by solid, the share of blots of 4 x 4 px in which its material does not answer.
    seed: Of 64 bits.

Returns:
    (H, W) depth along the optical axis in m, NaN where nothing comes back.)")
      .def("shaded", &shaded_of, "intrinsics"_a, "size"_a, "T_world_camera"_a, "looks"_a, "lighting"_a,
           nb::sig("def shaded(self, intrinsics: " APC_F64 ", size: " APC_I32 ", T_world_camera: " APC_F64
                   ", looks: Looks, lighting: Lighting) -> " APC_U8),
           R"(See the solids in colour.

Args:
    intrinsics: (4,) fx, fy, cx, cy in px.
    size: (2,) width and height in px.
    T_world_camera: (4, 4) pose of the camera.
    looks: How the solids look, in their order.
    lighting: Where light comes from.

Returns:
    (H, W, 3) red, green, blue.)");
}

}  // namespace apc
