#include "rendering/depth_noise.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "rendering/counter_random.hpp"
#include "rendering/portable_math.hpp"

namespace apc {
namespace {

constexpr float kHalfPi = 1.57079633f, kNothing = std::numeric_limits<float>::quiet_NaN();
constexpr float kSteepest = 1.55f;     //!< rad: beyond, the noise of grazing rays is that of this angle
constexpr float kSameSurface = 1e-3f;  //!< m that another solid must be nearer by to hide a point
constexpr int kReach = 2;              //!< px of the filter that correlates neighbours

constexpr double kMostPixels = 1e8;

void require(bool is_so, const char* told) {
  if (!is_so) throw std::invalid_argument(told);
}

//! Streams of random numbers.
enum Stream : std::uint32_t { kAxial, kAcross, kDown, kMixing, kIncidence, kBlots };

//! What the camera sees without noise, and the angles between rays and normals in rad.
struct Picture {
  Picture(const RaycastingScene& scene, const PinholeCamera& camera, const Pose& T)
      : width(static_cast<std::size_t>(camera.width)),
        hits(scene.cast_rays(camera, T)),
        normals(scene.normals(camera, T, hits)) {
    for (int u = 0; u < camera.width; ++u) x.push_back(static_cast<float>(camera.x(u)));
    for (int v = 0; v < camera.height; ++v) y.push_back(static_cast<float>(camera.y(v)));
    angles.resize(hits.depth.size());
    std::size_t pixel = 0;
    for (const float down : y)
      for (const float right : x) {
        const float* n = &normals[3 * pixel];
        const float facing =
            -(n[0] * right + n[1] * down + n[2]) / std::sqrt(right * right + down * down + 1.0f);
        const float cosine = facing > 0.0f ? std::min(facing, 1.0f) : 0.0f;
        angles[pixel++] = std::min(portable::arc_cosine(cosine), kSteepest);
      }
  }

  std::size_t at(int u, int v) const {
    return static_cast<std::size_t>(v) * width + static_cast<std::size_t>(u);
  }

  //! The ray of a pixel times the normal of what another one sees.
  float along(std::size_t normal_of, int u, int v) const {
    const float* n = &normals[3 * normal_of];
    return n[0] * x[static_cast<std::size_t>(u)] + n[1] * y[static_cast<std::size_t>(v)] + n[2];
  }

  //! Whether two pixels of one convex solid see the same face: then their normals have the same bits.
  bool is_one_plane(std::size_t a, std::size_t b) const {
    const float *n = &normals[3 * a], *m = &normals[3 * b];
    return n[0] == m[0] && n[1] == m[1] && n[2] == m[2];
  }

  std::size_t width;
  RayHits hits;
  std::vector<float> normals, angles, x, y;
};

//! What the second eye sees of all points within range that the first one may see.
class SecondEye {
 public:
  SecondEye(const RaycastingScene& scene, const PinholeCamera& camera, const Pose& T_world_camera,
            const DepthNoise& noise)
      : baseline_(noise.baseline), camera_(camera) {
    if (!(baseline_ > 0.0)) return;
    const double widest = camera.fx * baseline_ / noise.least,
                 narrowest = camera.fx * baseline_ / noise.greatest;
    scale_ = static_cast<float>(camera.fx * baseline_);
    shift_ = static_cast<float>(widest);
    camera_.cx += widest;
    const double width = camera_.width + std::ceil(widest - narrowest);
    require(width * camera_.height < kMostPixels, "the second eye needs too wide a picture: raise least");
    camera_.width = static_cast<int>(width);
    hits_ = scene.cast_rays(camera_, T_world_camera * Pose{{}, {baseline_, 0.0, 0.0}});
  }

  //! Whether what a pixel of the first eye has found is hidden from it. along: ray times normal.
  bool misses(int u, int v, float z, float along, float normal_x, std::int32_t index) const {
    if (!(baseline_ > 0.0)) return false;
    if (z * along >= static_cast<float>(baseline_) * normal_x) return true;  // its surface is turned away
    const float column = static_cast<float>(u) + shift_ - scale_ / z;
    const int nearest = std::clamp(static_cast<int>(column + 0.5f), 0, camera_.width - 1);
    const std::size_t pixel = static_cast<std::size_t>(v) * static_cast<std::size_t>(camera_.width) +
                              static_cast<std::size_t>(nearest);
    return hits_.index[pixel] != index && hits_.depth[pixel] < z - kSameSurface;
  }

 private:
  double baseline_;
  float scale_ = 0.0f, shift_ = 0.0f;  //!< a depth z is seen at column u + shift - scale / z
  PinholeCamera camera_;
  RayHits hits_;
};

//! Weights of a Gaussian over neighbours, such that the sum of independent numbers keeps its variance.
std::array<float, 2 * kReach + 1> filter(double width) {
  std::array<float, 2 * kReach + 1> weights{};
  if (width <= 0.0) {
    weights[kReach] = 1.0f;
    return weights;
  }
  double squares = 0.0, one[2 * kReach + 1];
  for (int i = -kReach; i <= kReach; ++i) {
    one[i + kReach] = std::exp(-0.5 * i * i / (width * width));
    squares += one[i + kReach] * one[i + kReach];
  }
  for (int i = 0; i <= 2 * kReach; ++i)
    weights[static_cast<std::size_t>(i)] = static_cast<float>(one[i] / std::sqrt(squares));
  return weights;
}

//! A standard normal number per pixel, correlated with its neighbours.
std::vector<float> axial_errors(const PinholeCamera& camera, const CounterRandom& random,
                                double correlation) {
  const auto W = static_cast<std::size_t>(camera.width), H = static_cast<std::size_t>(camera.height);
  const auto weights = filter(correlation);
  std::vector<float> errors(W * H, 0.0f), white, filtered(W);
  for (std::size_t row = 0; row < H + 2 * kReach; ++row) {
    random.fill_normals(static_cast<int>(row), kAxial, W + 2 * kReach, white);
    std::fill(filtered.begin(), filtered.end(), 0.0f);
    for (std::size_t i = 0; i < weights.size(); ++i)
      for (std::size_t u = 0; u < W; ++u) filtered[u] += weights[i] * white[u + i];
    for (std::size_t i = 0; i < weights.size(); ++i) {
      if (row < i || row - i >= H) continue;
      float* out = &errors[(row - i) * W];
      for (std::size_t u = 0; u < W; ++u) out[u] += weights[i] * filtered[u];
    }
  }
  return errors;
}

//! One measurement, row by row.
class Measurement {
 public:
  Measurement(const RaycastingScene& scene, const PinholeCamera& camera, const Pose& T_world_camera,
              const DepthNoise& noise, const std::vector<float>& no_return, std::uint64_t seed)
      : camera_(camera),
        noise_(noise),
        no_return_(no_return),
        random_(seed),
        picture_(scene, camera, T_world_camera),
        second_(scene, camera, T_world_camera, noise),
        axial_(axial_errors(camera, random_, noise.correlation)) {}

  std::vector<float> run() const {
    std::vector<float> depth(axial_.size()), across, down;
    for (int v = 0; v < camera_.height; ++v) {
      if (noise_.lateral > 0.0) {
        random_.fill_normals(v, kAcross, picture_.width, across);
        random_.fill_normals(v, kDown, picture_.width, down);
      }
      for (int u = 0; u < camera_.width; ++u) {
        Return found = own(u, v);
        if (noise_.lateral > 0.0)
          found = beside(found, u, v, across[static_cast<std::size_t>(u)], down[static_cast<std::size_t>(u)]);
        depth[picture_.at(u, v)] = measured(found, u, v);
      }
    }
    return depth;
  }

 private:
  //! What a ray is answered from.
  struct Return {
    float z;                 //!< m
    std::int32_t index;      //!< of the solid, -1: nothing
    std::size_t surface_of;  //!< the pixel that sees its surface, with normal and angle
  };

  Return own(int u, int v) const {
    const std::size_t pixel = picture_.at(u, v);
    return {picture_.hits.depth[pixel], picture_.hits.index[pixel], pixel};
  }

  //! Where the ray of a pixel meets the plane of what a pixel beside it sees: edges move, and flat faces keep
  //! their depth.
  Return beside(const Return& found, int u, int v, float across, float down) const {
    const float t = found.index < 0 ? 0.0f : picture_.angles[found.surface_of];
    const float off =
        static_cast<float>(noise_.lateral) + static_cast<float>(noise_.lateral_oblique) * tilt(t);
    const int other_u = shifted(u, off * across, camera_.width),
              other_v = shifted(v, off * down, camera_.height);
    Return other = own(other_u, other_v);
    if (other.index < 0) return other;
    if (other.index == found.index && picture_.is_one_plane(other.surface_of, found.surface_of)) return found;
    const float along = picture_.along(other.surface_of, u, v);
    if (!(along < 0.0f)) return {kNothing, -1, other.surface_of};
    other.z *= picture_.along(other.surface_of, other_u, other_v) / along;
    if (noise_.mixes_edges && found.index >= 0 && found.index != other.index)
      other.z += uniform(random_.at(u, v, kMixing)[0]) * (found.z - other.z);
    return other;
  }

  //! The place rounded to a pixel; moves of any size are cut at the edge of the picture.
  static int shifted(int place, float by, int end) {
    constexpr float kPositive = 4096.0f;  // conversion rounds towards 0
    const float cut = std::clamp(by, -kPositive, kPositive);
    return std::clamp(place + static_cast<int>(cut + (kPositive + 0.5f)) - static_cast<int>(kPositive), 0,
                      end - 1);
  }

  static float tilt(float t) { return t / (kHalfPi - t); }

  float measured(const Return& found, int u, int v) const {
    if (found.index < 0 || is_lost(found, u, v)) return kNothing;
    const float z = found.z + sigma(found.z, picture_.angles[found.surface_of]) * axial_[picture_.at(u, v)];
    const float told = quantised(z);
    return told >= static_cast<float>(noise_.least) && told <= static_cast<float>(noise_.greatest) ? told
                                                                                                   : kNothing;
  }

  bool is_lost(const Return& found, int u, int v) const {
    const float t = picture_.angles[found.surface_of], from = static_cast<float>(noise_.incidence_from);
    const float width = static_cast<float>(noise_.incidence_to) - from;
    if (t > from && uniform(random_.at(u, v, kIncidence)[0]) * width < t - from) return true;
    const float share = no_return_[static_cast<std::size_t>(found.index)];
    if (share > 0.0f && uniform(random_.at(u / kBlot, v / kBlot, kBlots)[0]) < share) return true;
    return second_.misses(u, v, found.z, picture_.along(found.surface_of, u, v),
                          picture_.normals[3 * found.surface_of], found.index);
  }

  float sigma(float z, float t) const {
    const float beyond = z - static_cast<float>(noise_.from);
    float sigma =
        static_cast<float>(noise_.constant) + static_cast<float>(noise_.quadratic) * beyond * beyond;
    if (noise_.disparity_error > 0.0)
      sigma += static_cast<float>(noise_.disparity_error / (camera_.fx * noise_.baseline)) * z * z;
    if (noise_.oblique > 0.0 && t > static_cast<float>(noise_.oblique_from))
      sigma += static_cast<float>(noise_.oblique) / std::sqrt(z) * tilt(t) * tilt(t);
    return sigma;
  }

  float quantised(float z) const {
    if (!(noise_.disparity_step > 0.0)) return z;
    const float scale = static_cast<float>(camera_.fx * noise_.baseline / noise_.disparity_step),
                steps = scale / z;
    return steps > 0.0f && steps < 8e6f ? scale / static_cast<float>(static_cast<int>(steps + 0.5f))
                                        : kNothing;
  }

  const PinholeCamera& camera_;
  const DepthNoise& noise_;
  const std::vector<float>& no_return_;
  const CounterRandom random_;
  const Picture picture_;
  const SecondEye second_;
  const std::vector<float> axial_;
};

}  // namespace

void check(const DepthNoise& n) {
  for (const double value : {n.constant, n.quadratic, n.from, n.oblique, n.oblique_from, n.disparity_error,
                             n.disparity_step, n.baseline, n.correlation, n.lateral, n.lateral_oblique,
                             n.least, n.greatest, n.incidence_from, n.incidence_to})
    require(value >= 0.0 && std::isfinite(value), "coefficients must be finite and at least 0");
  require(n.least > 0.0 && n.least < n.greatest, "least must be above 0 and below greatest");
  require(n.incidence_from < n.incidence_to && n.incidence_to <= kHalfPi,
          "incidence_from must be below incidence_to, and that at most pi/2");
  require(n.correlation == 0.0 || (n.correlation >= 0.5 && n.correlation <= 2.0),
          "correlation must be 0, or 0.5 to 2 px");
  require(n.baseline > 0.0 || (n.disparity_error == 0.0 && n.disparity_step == 0.0),
          "disparities need a baseline above 0");
}

std::vector<float> measured_depth(const RaycastingScene& scene, const PinholeCamera& camera,
                                  const Pose& T_world_camera, const DepthNoise& noise,
                                  const std::vector<float>& no_return, std::uint64_t seed) {
  return Measurement(scene, camera, T_world_camera, noise, no_return, seed).run();
}

}  // namespace apc
