#include "perception/place_picture.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace apc {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr double kNearest = 0.02;  //!< m: no item is that near to the camera
constexpr double kLeastShare = 0.01;
constexpr float kBehind = 0.005f;  //!< m behind what the second eye just sees, that counts as hidden from it
constexpr int kChunk = 256;  //!< px of a row that are cast at once

//! Rays of one row of pixels against one solid, in single precision. A ray along a face divides by zero: the
//! infinities of IEEE 754 are then the right answer.
class RowCaster {
 public:
  RowCaster(const Product& product, const Pose& T_camera_item) : kind_(product.kind) {
    const Pose back = inverse(T_camera_item);
    write(product.half, half_);
    write(back.p, eye_);
    write(back.R.column(0), right_);
    write(back.R.column(1), down_);
    write(back.R.column(2), forward_);
  }

  //! Depths at which the rays enter, infinite where they pass by. x: of n rays at depth 1; y: of all of them.
  void cast(const float* x, float y, int n, float* depth) {
    for (int i = 0; i < 3; ++i) base_[i] = forward_[i] + y * down_[i];
    if (kind_ == SolidKind::box)
      cast_box(x, n, depth);
    else
      for (int k = 0; k < n; ++k) depth[k] = cast_round(x[k]);
  }

  //! Cosine between ray and normal where the ray (x, in the row) enters.
  //! length: of the ray up to depth 1.
  float facing(float x, float depth, float length) const {
    float d[3], p[3];
    for (int i = 0; i < 3; ++i) {
      d[i] = base_[i] + x * right_[i];
      p[i] = eye_[i] + depth * d[i];
    }
    if (kind_ == SolidKind::sphere) return -(p[0] * d[0] + p[1] * d[1] + p[2] * d[2]) / (half_[0] * length);
    if (kind_ == SolidKind::cylinder) {
      const float across = std::sqrt(p[0] * p[0] + p[1] * p[1]);
      if (across - half_[0] > std::abs(p[2]) - half_[2])
        return -(p[0] * d[0] + p[1] * d[1]) / (half_[0] * length);
      return std::abs(d[2]) / length;
    }
    int axis = 0;
    for (int i = 1; i < 3; ++i)
      if (std::abs(p[i]) - half_[i] > std::abs(p[axis]) - half_[axis]) axis = i;
    return std::abs(d[axis]) / length;
  }

 private:
  static void write(const Vec3& v, float* out) {
    out[0] = static_cast<float>(v.x);
    out[1] = static_cast<float>(v.y);
    out[2] = static_cast<float>(v.z);
  }

  void cast_box(const float* x, int n, float* depth) const {
    for (int k = 0; k < n; ++k) {
      float near = static_cast<float>(kNearest), far = kInfinity;
      for (int i = 0; i < 3; ++i) {
        const float inverse = 1.0f / (base_[i] + x[k] * right_[i]);
        const float a = (-half_[i] - eye_[i]) * inverse, b = (half_[i] - eye_[i]) * inverse;
        const float low = a < b ? a : b, high = a < b ? b : a;
        near = low > near ? low : near;
        far = high < far ? high : far;
      }
      depth[k] = near <= far ? near : kInfinity;
    }
  }

  float cast_round(float x) const {
    float d[3], near = static_cast<float>(kNearest), far = kInfinity, along = 0.0f, length2 = 0.0f;
    for (int i = 0; i < 3; ++i) d[i] = base_[i] + x * right_[i];
    const int axes = kind_ == SolidKind::sphere ? 3 : 2;
    for (int i = 0; i < axes; ++i) {
      along += eye_[i] * d[i];
      length2 += d[i] * d[i];
    }
    const float middle = length2 > 1e-30f ? -along / length2 : 0.0f;
    float distance2 = 0.0f;
    for (int i = 0; i < axes; ++i) distance2 += (eye_[i] + middle * d[i]) * (eye_[i] + middle * d[i]);
    const float inside = half_[0] * half_[0] - distance2;
    if (!(inside >= 0.0f)) return kInfinity;
    if (length2 > 1e-30f) {
      const float half_chord = std::sqrt(inside / length2);
      near = std::max(near, middle - half_chord);
      far = std::min(far, middle + half_chord);
    }
    if (axes == 2) {
      const float inverse = 1.0f / d[2], a = (-half_[2] - eye_[2]) * inverse,
                  b = (half_[2] - eye_[2]) * inverse;
      near = std::max(near, std::min(a, b));
      far = std::min(far, std::max(a, b));
    }
    return near <= far ? near : kInfinity;
  }

  SolidKind kind_;
  float half_[3], eye_[3], right_[3], down_[3], forward_[3], base_[3]{};
};

struct Window {
  int first_u, last_u, first_v, last_v;  //!< last ones excluded
};

//! Pixels around the corners of the box around a solid; empty if one is not before the camera.
Window window(const PinholeCamera& camera, const Pose& T, const Vec3& half) {
  double low_u = 1e9, low_v = 1e9, high_u = -1e9, high_v = -1e9;
  for (unsigned i = 0; i < 8; ++i) {
    const Vec3 p = T * Vec3{i & 1 ? half.x : -half.x, i & 2 ? half.y : -half.y, i & 4 ? half.z : -half.z};
    if (!(p.z > kNearest)) return {0, 0, 0, 0};
    const double u = camera.fx * p.x / p.z + camera.cx, v = camera.fy * p.y / p.z + camera.cy;
    low_u = std::min(low_u, u), high_u = std::max(high_u, u);
    low_v = std::min(low_v, v), high_v = std::max(high_v, v);
  }
  const auto pixel = [](double place, int end) {
    return static_cast<int>(std::clamp(place, 0.0, static_cast<double>(end)));
  };
  return {pixel(std::floor(low_u), camera.width), pixel(std::ceil(high_u) + 1.0, camera.width),
          pixel(std::floor(low_v), camera.height), pixel(std::ceil(high_v) + 1.0, camera.height)};
}

double variance(const DepthNoise& noise, double fx, double z) {
  const double beyond = z - noise.from;
  double sigma = noise.constant + noise.quadratic * beyond * beyond;
  if (noise.disparity_error > 0.0) sigma += noise.disparity_error * z * z / (fx * noise.baseline);
  const double step = noise.disparity_step > 0.0 ? noise.disparity_step * z * z / (fx * noise.baseline) : 0.0;
  return sigma * sigma + step * step / 12.0;
}

//! Depths behind which no surface is seen by the second eye, which is to the right: measured surfaces farther to
//! the right hide it (a point at column u hides what is at u' < u and has u - f b / z <= u' - f b / z').
std::vector<float> hidden_from_second_eye(const MeasuredPicture& measured, double baseline) {
  const int width = measured.camera.width;
  std::vector<float> from(measured.depth.size(), kInfinity);
  const auto scale = static_cast<float>(measured.camera.fx * baseline);
  if (!(scale > 0.0f)) return from;
  for (int v = 0; v < measured.camera.height; ++v) {
    float disparity = 0.0f;  // largest of what is to the right, less the distance in columns
    for (int u = width - 2; u >= 0; --u) {
      const std::size_t at = static_cast<std::size_t>(v) * static_cast<std::size_t>(width) +
                             static_cast<std::size_t>(u);
      if (measured.share[at + 1] > 0.0f) disparity = std::max(disparity, scale / measured.depth[at + 1]);
      disparity -= 1.0f;
      if (disparity > 0.0f) from[at] = scale / disparity + kBehind;
    }
  }
  return from;
}

}  // namespace

PlacePicture::PlacePicture(MeasuredPicture measured, KnownSurface known,
                           const std::vector<float>& known_colour_costs, const DepthNoise& noise,
                           const PixelCosts& costs)
    : measured_(std::move(measured)),
      known_(std::move(known)),
      noise_(noise),
      costs_(costs),
      n_labels_(static_cast<int>(known_colour_costs.size())),
      inverse_variance_(measured_.depth.size()),
      hidden_(hidden_from_second_eye(measured_, noise.baseline)),
      known_costs_(measured_.depth.size(), 0.0f) {
  const PinholeCamera& camera = measured_.camera;
  for (int u = 0; u < camera.width; ++u) x_.push_back(static_cast<float>(camera.x(u)));
  for (int v = 0; v < camera.height; ++v) y_.push_back(static_cast<float>(camera.y(v)));
  for (const float y : y_)
    for (const float x : x_) length_.push_back(std::sqrt(x * x + y * y + 1.0f));
  const Returns plain = returns(0.0);
  for (std::size_t i = 0; i < n_pixels(); ++i) {
    if (measured_.share[i] > 0.0f)
      inverse_variance_[i] = static_cast<float>(
          1.0 / (variance(noise_, camera.fx, measured_.depth[i]) + costs_.slack * costs_.slack));
    if (std::isnan(known_.depth[i]))
      known_.depth[i] = kInfinity;
    else
      known_costs_[i] = cost(i, known_.depth[i], known_.facing[i], plain, known_colour_costs);
  }
}

PlacePicture::Returns PlacePicture::returns(double no_return) const {
  Returns out{};
  for (int k = 0; k < kFacings; ++k) {
    const double angle = std::acos(std::min((k + 0.5) / kFacings, 1.0));
    const double share =
        std::clamp((noise_.incidence_to - angle) / (noise_.incidence_to - noise_.incidence_from), 0.0, 1.0);
    const double comes =
        std::clamp(share * (1.0 - no_return) * (1.0 - costs_.lost), kLeastShare, 1.0 - kLeastShare);
    out.some[k] = static_cast<float>(-std::log(comes));
    out.none[k] = static_cast<float>(-std::log(1.0 - comes));
  }
  return out;
}

float PlacePicture::cost(std::size_t pixel, float depth, float facing, const Returns& returns,
                         const std::vector<float>& colour_costs) const {
  const float share = measured_.share[pixel], weight = static_cast<float>(costs_.weight);
  const int k = std::clamp(static_cast<int>(facing * kFacings), 0, kFacings - 1);
  const float colour = colour_costs[static_cast<std::size_t>(measured_.colour[pixel])];
  const float none = depth > hidden_[pixel]
                         ? std::min(static_cast<float>(costs_.hidden), returns.none[k])
                         : returns.none[k];
  if (!(share > 0.0f)) return weight * (none + colour);
  const float off = measured_.depth[pixel] - depth, half_square = 0.5f * off * off * inverse_variance_[pixel];
  const auto front = static_cast<float>(costs_.front), behind = static_cast<float>(costs_.behind);
  // Something else is there: neither its colour nor its answer tell of this surface.
  if (off < 0.0f && half_square >= front) return weight * share * front;
  const float told = off < 0.0f ? half_square : std::min(half_square, behind);
  return weight * (share * (returns.some[k] + told) + (1.0f - share) * none + colour);
}

int PlacePicture::add(Product product) {
  const Returns own = returns(product.no_return);
  products_.push_back({std::move(product), own});
  return n_products() - 1;
}

template <typename Visit>
void PlacePicture::each_hit(const Product& product, const Pose& T, const Visit& visit) const {
  const Window w = window(measured_.camera, T, product.half);
  RowCaster caster(product, T);
  float depth[kChunk];
  for (int v = w.first_v; v < w.last_v; ++v)
    for (int first = w.first_u; first < w.last_u; first += kChunk) {
      const int n = std::min(kChunk, w.last_u - first);
      const float *x = &x_[static_cast<std::size_t>(first)], y = y_[static_cast<std::size_t>(v)];
      caster.cast(x, y, n, depth);
      const std::size_t pixel =
          static_cast<std::size_t>(v) * static_cast<std::size_t>(width()) + static_cast<std::size_t>(first);
      for (int k = 0; k < n; ++k) {
        const std::size_t at = pixel + static_cast<std::size_t>(k);
        // An infinite depth is that of a ray that passes by, and of pixels without anything known.
        if (depth[k] < known_.depth[at] && known_.depth[at] < kInfinity)
          visit(at, depth[k], [&, k, at] { return caster.facing(x[k], depth[k], length_[at]); });
      }
    }
}

Sight PlacePicture::sight(int index, const Pose& T) const {
  const Entry& entry = products_[static_cast<std::size_t>(index)];
  Sight out;
  each_hit(entry.product, T, [&](std::size_t pixel, float depth, const auto& facing) {
    out.pixel.push_back(static_cast<std::int32_t>(pixel));
    out.depth.push_back(depth);
    out.cost.push_back(cost(pixel, depth, facing(), entry.returns, entry.product.colour_costs));
  });
  return out;
}

double PlacePicture::cost_before(int index, const Pose& T, const Composite& others, int* shown) const {
  const Entry& entry = products_[static_cast<std::size_t>(index)];
  double sum = 0.0;
  int n = 0;
  each_hit(entry.product, T, [&](std::size_t pixel, float depth, const auto& facing) {
    if (!(depth < others.depth[pixel])) return;
    ++n;
    sum += static_cast<double>(cost(pixel, depth, facing(), entry.returns, entry.product.colour_costs) -
                               others.cost[pixel]);
  });
  if (shown) *shown = n;
  return sum;
}

Solid PlacePicture::solid(int index, const Pose& T) const {
  const Product& p = product(index);
  return make_solid(T, p.half, p.kind, 0.0);
}

double PlacePicture::penetration(int index, const Pose& T) const {
  const Solid own = solid(index, T);
  double deepest = 0.0;
  for (const Solid& other : known_.solids) deepest = std::max(deepest, -signed_distance(own, other, 0.0));
  return deepest;
}

Vec3 PlacePicture::point(std::size_t pixel) const {
  const auto width = static_cast<std::size_t>(measured_.camera.width);
  const double z = measured_.depth[pixel];
  return {static_cast<double>(x_[pixel % width]) * z, static_cast<double>(y_[pixel / width]) * z, z};
}

}  // namespace apc
