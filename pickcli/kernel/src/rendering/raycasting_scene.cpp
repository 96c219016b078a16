#include "rendering/raycasting_scene.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "simd/dispatch.hpp"

namespace apc {
namespace {

using simd8::kLanes;
using simd8::SeenSolid;

//! The least box of pixels in which points may lie, and their least depth.
struct ScreenBox {
  double low_u = std::numeric_limits<double>::infinity(), low_v = low_u, high_u = -low_u, high_v = -low_u;
  double nearest = low_u;

  void add(const PinholeCamera& camera, const Vec3& p) {
    const double u = camera.fx * p.x / p.z + camera.cx, v = camera.fy * p.y / p.z + camera.cy;
    low_u = std::min(low_u, u);
    low_v = std::min(low_v, v);
    high_u = std::max(high_u, u);
    high_v = std::max(high_v, v);
    nearest = std::min(nearest, p.z);
  }
};

//! Of the box around a solid: its corners before the camera, and where its edges come through the nearest
//! plane.
ScreenBox screen_box(const PinholeCamera& camera, const Pose& T_camera_solid, const Vec3& half) {
  std::array<Vec3, 8> corners;
  for (unsigned i = 0; i < 8; ++i)
    corners[i] =
        T_camera_solid * Vec3{i & 1 ? half.x : -half.x, i & 2 ? half.y : -half.y, i & 4 ? half.z : -half.z};
  ScreenBox box;
  constexpr double near = simd8::kNearest;
  for (unsigned i = 0; i < 8; ++i) {
    if (corners[i].z >= near) box.add(camera, corners[i]);
    for (unsigned bit = 1; bit < 8; bit *= 2) {
      const Vec3 &a = corners[i], &b = corners[i | bit];
      if (i & bit || (a.z < near) == (b.z < near)) continue;
      Vec3 crossing = a + (near - a.z) / (b.z - a.z) * (b - a);
      crossing.z = near;
      box.add(camera, crossing);
    }
  }
  return box;
}

int to_pixel(double place, int end) {
  return static_cast<int>(std::clamp(place, 0.0, static_cast<double>(end)));
}

void write(const Vec3& v, float* out) {
  out[0] = static_cast<float>(v.x);
  out[1] = static_cast<float>(v.y);
  out[2] = static_cast<float>(v.z);
}

//! The frame's axes and origin as the solid sees them, in single precision.
void set_view(SeenSolid& seen, const Pose& T_solid_camera) {
  write(T_solid_camera.p, seen.eye);
  write(T_solid_camera.R.column(0), seen.right);
  write(T_solid_camera.R.column(1), seen.down);
  write(T_solid_camera.R.column(2), seen.forward);
}

//! In the order of their nearest points, so that what is far is mostly found hidden by a single comparison.
//! Planes of all of them are put into one list.
std::vector<SeenSolid> seen_solids(const std::vector<RenderedSolid>& solids, const PinholeCamera& camera,
                                   const Pose& T_world_camera, std::vector<simd8::PlaneData>& planes) {
  std::size_t n_planes = 0;
  for (const RenderedSolid& solid : solids) n_planes += solid.planes.size();
  planes.reserve(n_planes);  // the solids point into it
  std::vector<SeenSolid> seen;
  const Pose T_camera_world = inverse(T_world_camera);
  for (std::size_t i = 0; i < solids.size(); ++i) {
    const RenderedSolid& solid = solids[i];
    const Pose T_camera_solid = T_camera_world * solid.T_world_solid;
    const ScreenBox box = screen_box(camera, T_camera_solid, solid.half);
    SeenSolid one{};
    // A pixel more on every side: the rays are rounded to single precision.
    one.first_column = to_pixel(std::floor(box.low_u) - 1.0, camera.width) / kLanes * kLanes;
    one.last_column = (to_pixel(std::ceil(box.high_u) + 2.0, camera.width) + kLanes - 1) / kLanes * kLanes;
    one.first_row = to_pixel(std::floor(box.low_v) - 1.0, camera.height);
    one.last_row = to_pixel(std::ceil(box.high_v) + 2.0, camera.height);
    if (!(box.nearest < std::numeric_limits<double>::infinity()) || one.first_row >= one.last_row ||
        one.first_column >= one.last_column)
      continue;
    const Pose T_solid_camera = inverse(T_camera_solid);
    set_view(one, T_solid_camera);
    write(solid.half, one.half);
    one.kind = solid.kind;
    one.index = static_cast<std::int32_t>(i);
    one.nearest = static_cast<float>(0.999999 * box.nearest);
    one.planes = planes.data() + planes.size();
    one.n_planes = static_cast<int>(solid.planes.size());
    for (const Plane& plane : solid.planes) {
      simd8::PlaneData data{};
      write(plane.normal, data.normal);
      data.offset = static_cast<float>(plane.offset);
      data.clearance = static_cast<float>(plane.offset - dot(plane.normal, T_solid_camera.p));
      planes.push_back(data);
    }
    seen.push_back(one);
  }
  std::stable_sort(seen.begin(), seen.end(),
                   [](const SeenSolid& a, const SeenSolid& b) { return a.nearest < b.nearest; });
  return seen;
}

//! The face of a box that a point is farthest outside of: +x, -x, +y, -y, +z, -z.
int box_face(const Vec3& p, const Vec3& half) {
  const double x = std::abs(p.x) - half.x, y = std::abs(p.y) - half.y, z = std::abs(p.z) - half.z;
  if (x > y) return x > z ? p.x < 0.0 : 4 + (p.z < 0.0);
  return y > z ? 2 + (p.y < 0.0) : 4 + (p.z < 0.0);
}

//! A vector along one axis of the frame.
Vec3 along(int axis, double length) {
  return {axis == 0 ? length : 0.0, axis == 1 ? length : 0.0, axis == 2 ? length : 0.0};
}

//! A solid in the frame of the camera, with the normals of its flat faces there.
class Posed {
 public:
  Posed(const RenderedSolid& solid, const Pose& T_world_camera)
      : solid_(solid),
        T_camera_solid_(inverse(T_world_camera) * solid.T_world_solid),
        T_solid_camera_(inverse(T_camera_solid_)) {
    for (int face = 0; face < 6; ++face)
      write((face % 2 ? -1.0 : 1.0) * T_camera_solid_.R.column(face / 2), faces_[face]);
  }

  //! Of the face at a point, in the camera's frame.
  void write_normal(const Vec3& point, float* out) const {
    const Vec3 p = T_solid_camera_ * point;
    if (solid_.kind == simd8::SolidKind::box && solid_.planes.empty())
      std::copy_n(faces_[box_face(p, solid_.half)], 3, out);
    else
      write(T_camera_solid_.R * surface_at(solid_, p).normal, out);
  }

 private:
  const RenderedSolid& solid_;
  Pose T_camera_solid_, T_solid_camera_;
  float faces_[6][3];
};

}  // namespace

RayHits RaycastingScene::cast_rays(const PinholeCamera& camera, const Pose& T_world_camera) const {
  const int W = camera.width, H = camera.height, stride = (W + kLanes - 1) / kLanes * kLanes;
  std::vector<float> x(static_cast<std::size_t>(stride)), y(static_cast<std::size_t>(H));
  for (int u = 0; u < stride; ++u) x[static_cast<std::size_t>(u)] = static_cast<float>(camera.x(u));
  for (int v = 0; v < H; ++v) y[static_cast<std::size_t>(v)] = static_cast<float>(camera.y(v));
  const std::size_t n = static_cast<std::size_t>(stride) * static_cast<std::size_t>(H);
  RayHits hits{std::vector<float>(n, std::numeric_limits<float>::infinity()),
               std::vector<std::int32_t>(n, -1)};
  const simd8::DepthData picture{x.data(), y.data(), hits.depth.data(), hits.index.data(), stride};
  std::vector<simd8::PlaneData> planes;
  const simd8::Cast cast = ray_cast();
  for (const SeenSolid& solid : seen_solids(solids_, camera, T_world_camera, planes)) cast(solid, picture);
  // Without the columns that fill the last lanes, and with NaN for nothing.
  std::size_t to = 0;
  for (std::size_t v = 0; stride > W && v < static_cast<std::size_t>(H); ++v)
    for (std::size_t u = 0; u < static_cast<std::size_t>(W); ++u, ++to) {
      const std::size_t from = v * static_cast<std::size_t>(stride) + u;
      hits.index[to] = hits.index[from];
      hits.depth[to] = hits.depth[from];
    }
  if (stride == W) to = n;
  hits.depth.resize(to);
  hits.index.resize(to);
  for (float& depth : hits.depth)
    if (depth == std::numeric_limits<float>::infinity()) depth = std::numeric_limits<float>::quiet_NaN();
  return hits;
}

std::vector<float> RaycastingScene::normals(const PinholeCamera& camera, const Pose& T_world_camera,
                                            const RayHits& hits) const {
  std::vector<Posed> posed;
  for (const RenderedSolid& solid : solids_) posed.emplace_back(solid, T_world_camera);
  std::vector<float> normals(3 * hits.depth.size());
  std::size_t pixel = 0;
  for (int v = 0; v < camera.height; ++v)
    for (int u = 0; u < camera.width; ++u, ++pixel) {
      float* out = &normals[3 * pixel];
      if (hits.index[pixel] < 0) {
        out[0] = out[1] = out[2] = std::numeric_limits<float>::quiet_NaN();
        continue;
      }
      const Posed& solid = posed[static_cast<std::size_t>(hits.index[pixel])];
      const double z = hits.depth[pixel];
      solid.write_normal({camera.x(u) * z, camera.y(v) * z, z}, out);
    }
  return normals;
}

SurfacePoint surface_at(const RenderedSolid& solid, const Vec3& p) {
  const Vec3& h = solid.half;
  if (solid.kind == simd8::SolidKind::sphere) return {p, (1.0 / norm(p)) * p, 0};
  if (solid.kind == simd8::SolidKind::cylinder) {
    const double radius = std::sqrt(p.x * p.x + p.y * p.y);
    if (radius - h.x > std::abs(p.z) - h.z) return {p, {p.x / radius, p.y / radius, 0.0}, 2};
    return {p, {0.0, 0.0, p.z < 0.0 ? -1.0 : 1.0}, p.z < 0.0 ? 1 : 0};
  }
  const int face = box_face(p, h);
  SurfacePoint found{p, along(face / 2, face % 2 ? -1.0 : 1.0), face};
  double outside = dot(found.normal, p) - (face < 2 ? h.x : face < 4 ? h.y : h.z);
  for (std::size_t k = 0; k < solid.planes.size(); ++k) {
    const double over = dot(solid.planes[k].normal, p) - solid.planes[k].offset;
    if (over <= outside) continue;
    outside = over;
    found = {p, solid.planes[k].normal, 6 + static_cast<int>(k)};
  }
  return found;
}

}  // namespace apc
