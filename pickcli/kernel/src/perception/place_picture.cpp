#include "perception/place_picture.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "simd/dispatch.hpp"

namespace apc {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr double kLeastShare = 0.01;
constexpr float kBehind = 0.005f;  //!< m behind what the second eye just sees, that counts as hidden from it

//! Pixels around the corners of the box around a solid; empty if one is not before the camera.
simd8::Window window(const PinholeCamera& camera, const Pose& T, const Vec3& half) {
  double low_u = 1e9, low_v = 1e9, high_u = -1e9, high_v = -1e9;
  for (unsigned i = 0; i < 8; ++i) {
    const Vec3 p = T * Vec3{i & 1 ? half.x : -half.x, i & 2 ? half.y : -half.y, i & 4 ? half.z : -half.z};
    if (!(p.z > simd8::kNearestOfPlace)) return {0, 0, 0, 0};
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

//! m from an end of its range within which a sensor may lose a surface by its noise.
double lost_within(const DepthNoise& noise, double fx, double end) {
  return 2.0 * std::sqrt(variance(noise, fx, end));
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

void write(const Vec3& v, float* out) {
  out[0] = static_cast<float>(v.x);
  out[1] = static_cast<float>(v.y);
  out[2] = static_cast<float>(v.z);
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
      nearest_(static_cast<float>(noise.least + lost_within(noise, measured_.camera.fx, noise.least))),
      farthest_(
          static_cast<float>(noise.greatest - lost_within(noise, measured_.camera.fx, noise.greatest))),
      inverse_variance_(padded(), 0.0f),
      hidden_(hidden_from_second_eye(measured_, noise.baseline)),
      known_costs_(padded(), 0.0f) {
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
  for (std::vector<float>* each : {&measured_.depth, &measured_.share, &known_.depth, &hidden_, &length_})
    each->resize(padded(), 0.0f);
  x_.resize(x_.size() + simd8::kLanes, 0.0f);
}

PlacePicture::Returns PlacePicture::returns(double no_return) const {
  Returns out{};
  for (int k = 0; k < simd8::kFacings; ++k) {
    const double angle = std::acos(std::min((k + 0.5) / simd8::kFacings, 1.0));
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
  const int k = std::clamp(static_cast<int>(facing * simd8::kFacings), 0, simd8::kFacings - 1);
  const float colour = colour_costs[static_cast<std::size_t>(measured_.colour[pixel])];
  const bool is_unseen = depth > hidden_[pixel] || depth < nearest_ || depth > farthest_;
  const float none =
      is_unseen ? std::min(static_cast<float>(costs_.unseen), returns.none[k]) : returns.none[k];
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
  std::vector<float> colour(padded(), 0.0f);
  for (std::size_t i = 0; i < n_pixels(); ++i)
    colour[i] = product.colour_costs[static_cast<std::size_t>(measured_.colour[i])];
  products_.push_back({std::move(product), own, std::move(colour)});
  return n_products() - 1;
}

simd8::Hypothesis PlacePicture::hypothesis(const Entry& entry, const Pose& T) const {
  const Pose back = inverse(T);
  simd8::Hypothesis out{};
  out.kind = entry.product.kind;
  write(entry.product.half, out.half);
  write(back.p, out.eye);
  write(back.R.column(0), out.right);
  write(back.R.column(1), out.down);
  write(back.R.column(2), out.forward);
  out.some = entry.returns.some;
  out.none = entry.returns.none;
  out.colour = entry.colour.data();
  return out;
}

simd8::PlaceData PlacePicture::data() const {
  return {x_.data(), y_.data(), length_.data(), measured_.depth.data(), measured_.share.data(),
          inverse_variance_.data(), hidden_.data(), width(), nearest_, farthest_,
          static_cast<float>(costs_.front), static_cast<float>(costs_.behind),
          static_cast<float>(costs_.unseen), static_cast<float>(costs_.weight)};
}

Sight PlacePicture::sight(int index, const Pose& T) const {
  const Entry& entry = products_[static_cast<std::size_t>(index)];
  const simd8::Window w = window(measured_.camera, T, entry.product.half);
  const simd8::Hypothesis item = hypothesis(entry, T);
  const simd8::PlaceData place = data();
  const simd8::ShowRow show_row = row_shower();
  const auto in_row = static_cast<std::size_t>(std::max(w.last_u - w.first_u, 0) + simd8::kLanes);
  Sight out;
  std::size_t n = 0;
  for (int v = w.first_v; v < w.last_v; ++v) {
    out.pixel.resize(n + in_row);
    out.depth.resize(n + in_row);
    out.cost.resize(n + in_row);
    n += static_cast<std::size_t>(show_row(item, place, known_.depth.data(), v, w.first_u, w.last_u,
                                           &out.pixel[n], &out.depth[n], &out.cost[n]));
  }
  out.pixel.resize(n);
  out.depth.resize(n);
  out.cost.resize(n);
  return out;
}

double PlacePicture::cost_before(int index, const Pose& T, const Composite& others, int* shown) const {
  const Entry& entry = products_[static_cast<std::size_t>(index)];
  const simd8::Window w = window(measured_.camera, T, entry.product.half);
  const simd8::Gain found =
      picture_cost()(hypothesis(entry, T), data(), {others.depth.data(), others.cost.data()}, w);
  if (shown) *shown = found.shown;
  return found.cost;
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
