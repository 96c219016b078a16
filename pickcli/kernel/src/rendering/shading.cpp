#include "rendering/shading.hpp"

#include <algorithm>
#include <cmath>

#include "rendering/portable_math.hpp"

namespace apc {
namespace {

constexpr int kShadowSize = 1024;      //!< px of the picture that the lamp sees
constexpr float kShadowSlack = 9e-3f;  //!< m, farther from the lamp than what it sees: in the shadow
constexpr float kHeadDistance = 0.5f;  //!< m at which the light at the camera has its stated amount
constexpr float kHeadNearest = 0.3f;   //!< m: nearer, it gets no brighter
constexpr float kLeastFacing = 0.12f;  //!< cosine that textures of grazing faces are filtered for at most

struct Vec3f {
  float x, y, z;
};

Vec3f to_single(const Vec3& v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}
float dot(const Vec3f& a, const Vec3f& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
Vec3f operator*(float s, const Vec3f& a) { return {s * a.x, s * a.y, s * a.z}; }
Vec3f operator+(const Vec3f& a, const Vec3f& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
Vec3f operator-(const Vec3f& a, const Vec3f& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }

//! A pose in single precision.
struct Posef {
  explicit Posef(const Pose& T)
      : x(to_single(T.R.column(0))),
        y(to_single(T.R.column(1))),
        z(to_single(T.R.column(2))),
        p(to_single(T.p)) {}
  Vec3f operator*(const Vec3f& v) const { return v.x * x + v.y * y + v.z * z + p; }
  Vec3f turned(const Vec3f& v) const { return v.x * x + v.y * y + v.z * z; }

  Vec3f x, y, z, p;
};

Colour square(const Colour& c) { return {c.r * c.r, c.g * c.g, c.b * c.b}; }

//! Where a place of a face is in its texture, from its left and its top as seen from outside, +z (or of +z
//! and -z, +y) up; and how wide the texture is on it in m.
struct Place {
  float u, v, width;
  int face;
};

Place place_on_box(const Vec3f& p, const Vec3f& h, int face) {
  switch (face) {
    case 0:
      return {0.5f + 0.5f * p.y / h.y, 0.5f - 0.5f * p.z / h.z, 2.0f * h.y, 0};
    case 1:
      return {0.5f - 0.5f * p.y / h.y, 0.5f - 0.5f * p.z / h.z, 2.0f * h.y, 1};
    case 2:
      return {0.5f - 0.5f * p.x / h.x, 0.5f - 0.5f * p.z / h.z, 2.0f * h.x, 2};
    case 3:
      return {0.5f + 0.5f * p.x / h.x, 0.5f - 0.5f * p.z / h.z, 2.0f * h.x, 3};
    case 4:
      return {0.5f + 0.5f * p.x / h.x, 0.5f - 0.5f * p.y / h.y, 2.0f * h.x, 4};
    default:
      return {0.5f - 0.5f * p.x / h.x, 0.5f - 0.5f * p.y / h.y, 2.0f * h.x, 5};
  }
}

int largest_face(const Vec3f& p) {
  const float x = std::abs(p.x), y = std::abs(p.y), z = std::abs(p.z);
  if (x > y) return x > z ? p.x < 0.0f : 4 + (p.z < 0.0f);
  return y > z ? 2 + (p.y < 0.0f) : 4 + (p.z < 0.0f);
}

//! In turns from +x towards +y, in [0, 1]: Abramowitz and Stegun, 4.4.49, off by less than 2e-6 turns.
float turns(float x, float y) {
  const float ax = std::abs(x), ay = std::abs(y), t = std::min(ax, ay) / std::max(std::max(ax, ay), 1e-20f),
              s = t * t;
  float a = t * (0.9998660f + s * (-0.3302995f + s * (0.1801410f + s * (-0.0851330f + s * 0.0208351f)))) *
            0.15915494f;
  if (ay > ax) a = 0.25f - a;
  if (x < 0.0f) a = 0.5f - a;
  return y < 0.0f ? 1.0f - a : a;
}

//! A solid as the picture needs it.
struct Shown {
  Shown(const RenderedSolid& solid, const Look& look, const Pose& T_camera_world)
      : solid(solid),
        look(look),
        T_camera_solid(T_camera_world * solid.T_world_solid),
        T_solid_camera(inverse(T_camera_world * solid.T_world_solid)),
        half(to_single(solid.half)) {}

  const RenderedSolid& solid;
  const Look& look;
  Posef T_camera_solid, T_solid_camera;
  Vec3f half;
};

struct Surface {
  Vec3f normal;  //!< in the camera's frame
  Place place;   //!< face -1: without a texture
};

Surface surface_of(const Shown& shown, const Vec3f& p) {
  const Posef& T = shown.T_camera_solid;
  const Vec3f& h = shown.half;
  if (shown.solid.kind == simd8::SolidKind::sphere) {
    const int face = largest_face(p);
    const float largest = face < 2 ? std::abs(p.x) : face < 4 ? std::abs(p.y) : std::abs(p.z);
    return {(1.0f / h.x) * T.turned(p), place_on_box((h.x / largest) * p, h, face)};
  }
  if (shown.solid.kind == simd8::SolidKind::cylinder) {
    const float radius = std::sqrt(p.x * p.x + p.y * p.y);
    if (radius - h.x > std::abs(p.z) - h.z)
      return {(p.x / radius) * T.x + (p.y / radius) * T.y,
              {turns(p.x, p.y), 0.5f - 0.5f * p.z / h.z, 6.2831853f * h.x, 2}};
    Place place = place_on_box(p, h, p.z < 0.0f ? 5 : 4);
    place.face -= 4;
    return {(p.z < 0.0f ? -1.0f : 1.0f) * T.z, place};
  }
  if (!shown.solid.planes.empty()) {
    const SurfacePoint found = surface_at(shown.solid, {p.x, p.y, p.z});
    const Vec3f normal = to_single(found.normal);
    return {T.turned(normal), place_on_box(p, h, largest_face(normal))};
  }
  const Vec3f over{std::abs(p.x) - h.x, std::abs(p.y) - h.y, std::abs(p.z) - h.z};
  const int axis = over.x > over.y ? (over.x > over.z ? 0 : 2) : (over.y > over.z ? 1 : 2);
  const float side = axis == 0 ? p.x : axis == 1 ? p.y : p.z;
  const int face = 2 * axis + (side < 0.0f);
  const Vec3f& column = axis == 0 ? T.x : axis == 1 ? T.y : T.z;
  return {(side < 0.0f ? -1.0f : 1.0f) * column, place_on_box(p, h, face)};
}

//! What the lamp sees, to tell shadows.
class Lamp {
 public:
  Lamp(const RaycastingScene& scene, const Lighting& lighting, const Pose& T_camera_world)
      : amount_(static_cast<float>(lighting.lamp)),
        place_(to_single(T_camera_world * lighting.T_world_lamp.p)),
        T_lamp_camera_(inverse(T_camera_world * lighting.T_world_lamp)) {
    if (amount_ <= 0.0f) return;
    constexpr double half = 0.5 * kShadowSize;
    seen_ = scene.cast_rays({half, half, half - 0.5, half - 0.5, kShadowSize, kShadowSize},
                            lighting.T_world_lamp);
  }

  bool is_on() const { return amount_ > 0.0f; }
  Vec3f towards(const Vec3f& point) const {
    const Vec3f way = place_ - point;
    return (1.0f / std::sqrt(dot(way, way))) * way;
  }

  //! The share of four pixels around a point in which the lamp sees nothing before it, times the amount of
  //! light.
  float on(const Vec3f& point, std::int32_t index) const {
    constexpr float half = 0.5f * kShadowSize;
    const Vec3f p = T_lamp_camera_ * point;
    if (!(p.z > 0.1f)) return 0.0f;
    const float u = half * p.x / p.z + (half - 0.5f), v = half * p.y / p.z + (half - 0.5f);
    if (!(u >= 0.0f && v >= 0.0f && u < kShadowSize - 2 && v < kShadowSize - 2)) return amount_;
    const int column = static_cast<int>(u), row = static_cast<int>(v);
    const float a = u - static_cast<float>(column), b = v - static_cast<float>(row);
    const std::size_t first = static_cast<std::size_t>(row) * kShadowSize + static_cast<std::size_t>(column);
    // No convex solid throws a shadow on its own lit side; where the lamp sees nothing, a NaN, it is light.
    const auto lit = [&](std::size_t i) {
      return seen_.index[i] != index && seen_.depth[i] < p.z - kShadowSlack ? 0.0f : 1.0f;
    };
    const float upper = (1.0f - a) * lit(first) + a * lit(first + 1);
    const float lower = (1.0f - a) * lit(first + kShadowSize) + a * lit(first + kShadowSize + 1);
    return amount_ * ((1.0f - b) * upper + b * lower);
  }

 private:
  float amount_;
  Vec3f place_;
  Posef T_lamp_camera_;
  RayHits seen_;
};

std::uint8_t to_byte(float squared) {
  return static_cast<std::uint8_t>(std::sqrt(std::min(squared, 65025.0f)) + 0.5f);
}

}  // namespace

std::vector<std::uint8_t> shaded(const RaycastingScene& scene, const PinholeCamera& camera,
                                 const Pose& T_world_camera, const Looks& looks, const Lighting& lighting) {
  const Pose T_camera_world = inverse(T_world_camera);
  const RayHits hits = scene.cast_rays(camera, T_world_camera);
  const Lamp lamp(scene, lighting, T_camera_world);
  std::vector<Shown> solids;
  solids.reserve(scene.solids().size());
  for (std::size_t i = 0; i < scene.solids().size(); ++i)
    solids.emplace_back(scene.solids()[i], looks.of_solids[i], T_camera_world);
  const Vec3f up = to_single(T_camera_world.R.column(2));
  const float ambient = static_cast<float>(lighting.ambient), focal = static_cast<float>(camera.fx);
  const float headlight = static_cast<float>(lighting.headlight) * kHeadDistance * kHeadDistance;
  std::vector<std::uint8_t> picture(3 * hits.depth.size());
  std::size_t pixel = 0;
  for (int v = 0; v < camera.height; ++v)
    for (int u = 0; u < camera.width; ++u, ++pixel) {
      std::uint8_t* out = &picture[3 * pixel];
      Colour light = square(lighting.background);
      if (hits.index[pixel] >= 0) {
        const Shown& shown = solids[static_cast<std::size_t>(hits.index[pixel])];
        const float z = hits.depth[pixel];
        const Vec3f point{static_cast<float>(camera.x(u)) * z, static_cast<float>(camera.y(v)) * z, z};
        const Surface surface = surface_of(shown, shown.T_solid_camera * point);
        const float distance2 = dot(point, point), distance = std::sqrt(distance2);
        const Vec3f back = (-1.0f / distance) * point;
        const float facing = std::max(dot(surface.normal, back), 0.0f);
        Colour colour = shown.look.colour;
        const int texture =
            surface.place.face < 0 ? -1 : shown.look.textures[static_cast<std::size_t>(surface.place.face)];
        if (texture >= 0) {
          const Texture& shape = *looks.textures[static_cast<std::size_t>(texture)];
          const float covered = z / focal / std::max(facing, kLeastFacing) *
                                static_cast<float>(shape.width()) / surface.place.width;
          colour = shape.at(surface.place.u, surface.place.v, covered);
        }
        const float head = headlight * facing / std::max(distance2, kHeadNearest * kHeadNearest);
        float amount = ambient * (0.875f + 0.125f * dot(surface.normal, up)) + head;
        float shine = head * facing * facing;
        if (lamp.is_on()) {
          const Vec3f way = lamp.towards(point);
          const float towards = dot(surface.normal, way);
          if (towards > 0.0f) {
            const float on = lamp.on(point, hits.index[pixel]);
            amount += on * towards;
            const Vec3f middle = way + back;  // Blinn 1977
            const float mirrored = dot(surface.normal, middle),
                        c2 = mirrored * mirrored / dot(middle, middle);
            const float c4 = c2 * c2, c16 = c4 * c4 * c4 * c4;
            shine += on * c16 * c16;
          }
        }
        const float white = 65025.0f * shown.look.gloss * shine;
        light = amount * square(colour) + Colour{white, white, white};
      }
      out[0] = to_byte(light.r), out[1] = to_byte(light.g), out[2] = to_byte(light.b);
    }
  return picture;
}

}  // namespace apc
