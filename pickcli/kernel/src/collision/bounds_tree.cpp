#include "collision/bounds_tree.hpp"

#include <algorithm>
#include <limits>

namespace apc {
namespace {

using simd8::kLanes;

constexpr std::size_t kMostOnTop = 4;  // rows: going through a few is quicker than a level more
constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct Entry {
  float center[3];  //!< m; where it is rounded to does not matter for an order
  int index;
};

//! The longest side of the box around some entries.
struct Side {
  int axis;
  float low, high;  //!< m, along the axis
};

Side longest_side(const Entry* first, const Entry* last) {
  float low[3] = {first->center[0], first->center[1], first->center[2]};
  float high[3] = {low[0], low[1], low[2]};
  for (const Entry* e = first; e != last; ++e)
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], e->center[axis]);
      high[axis] = std::max(high[axis], e->center[axis]);
    }
  int longest = 0;
  for (int axis = 1; axis < 3; ++axis)
    if (high[axis] - low[axis] > high[longest] - low[longest]) longest = axis;
  return {longest, low[longest], high[longest]};
}

//! As std::nth_element along a side: what is before the middle comes before it. Of many the ranges are told
//! apart by a histogram first, which takes no branch that cannot be foreseen; scratch holds as many.
void divide(Entry* first, Entry* middle, Entry* last, const Side& side, Entry* scratch) {
  constexpr int kBins = 32;
  constexpr std::ptrdiff_t kFew = 128;
  const auto is_before = [axis = side.axis](const Entry& a, const Entry& b) {
    return a.center[axis] != b.center[axis] ? a.center[axis] < b.center[axis] : a.index < b.index;
  };
  const float scale = static_cast<float>(kBins - 1) / (side.high - side.low);
  if (last - first < kFew || !(scale < std::numeric_limits<float>::max())) {
    std::nth_element(first, middle, last, is_before);
    return;
  }
  const auto bin_of = [&](const Entry& e) {
    return static_cast<int>((e.center[side.axis] - side.low) * scale);
  };
  std::ptrdiff_t counts[kBins] = {};
  for (const Entry* e = first; e != last; ++e) ++counts[bin_of(*e)];
  int bin = 0;
  std::ptrdiff_t n_before = 0;
  while (n_before + counts[bin] <= middle - first) n_before += counts[bin++];
  // Those of bins before, in and after that of the middle.
  Entry* next[3] = {scratch, scratch + n_before, scratch + n_before + counts[bin]};
  for (const Entry* e = first; e != last; ++e) {
    const int at = bin_of(*e);
    *next[(at >= bin) + (at > bin)]++ = *e;
  }
  std::copy(scratch, scratch + (last - first), first);
  std::nth_element(first + n_before, middle, first + n_before + counts[bin], is_before);
}

//! Halves at multiples of a block, which becomes an eighth of itself once all there is fits into one.
void order(Entry* first, Entry* last, std::ptrdiff_t block, Entry* scratch) {
  const std::ptrdiff_t n = last - first;
  while (n <= block) block /= kLanes;
  if (block < kLanes) return;
  Entry* middle = first + (n / block + (n % block != 0)) / 2 * block;
  divide(first, middle, last, longest_side(first, last), scratch);
  order(first, middle, block, scratch);
  order(middle, last, block, scratch);
}

Bounds of_nothing() {
  return {{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}};
}

//! Bounds of eight each, in single precision.
std::vector<simd8::Bounds8> in_rows(const std::vector<Bounds>& things, double slop) {
  std::vector<simd8::Bounds8> rows((things.size() + kLanes - 1) / kLanes);
  for (std::size_t i = 0; i < rows.size() * kLanes; ++i) {
    const Bounds& b = i < things.size() ? things[i] : of_nothing();
    const double low[3] = {b.low.x, b.low.y, b.low.z}, high[3] = {b.high.x, b.high.y, b.high.z};
    for (int axis = 0; axis < 3; ++axis) {
      rows[i / kLanes].low[axis][i % kLanes] = static_cast<float>(low[axis] - slop);
      rows[i / kLanes].high[axis][i % kLanes] = static_cast<float>(high[axis] + slop);
    }
  }
  return rows;
}

//! Around each eight.
std::vector<Bounds> around_rows(const std::vector<Bounds>& things) {
  std::vector<Bounds> out((things.size() + kLanes - 1) / kLanes, of_nothing());
  for (std::size_t i = 0; i < things.size(); ++i) out[i / kLanes] = around(out[i / kLanes], things[i]);
  return out;
}

}  // namespace

Bounds around(const Bounds& a, const Bounds& b) {
  return {{std::min(a.low.x, b.low.x), std::min(a.low.y, b.low.y), std::min(a.low.z, b.low.z)},
          {std::max(a.high.x, b.high.x), std::max(a.high.y, b.high.y), std::max(a.high.z, b.high.z)}};
}

std::vector<int> spatial_order(const std::vector<Vec3>& centers) {
  std::vector<Entry> entries;
  entries.reserve(centers.size());
  for (const Vec3& c : centers)
    entries.push_back({{static_cast<float>(c.x), static_cast<float>(c.y), static_cast<float>(c.z)},
                       static_cast<int>(entries.size())});
  std::ptrdiff_t block = kLanes;
  while (block < static_cast<std::ptrdiff_t>(entries.size())) block *= kLanes;
  std::vector<Entry> scratch(entries.size());
  if (!entries.empty()) order(entries.data(), entries.data() + entries.size(), block, scratch.data());
  std::vector<int> out;
  out.reserve(entries.size());
  for (const Entry& entry : entries) out.push_back(entry.index);
  return out;
}

BoundsTree::BoundsTree(const std::vector<Bounds>& things, double slop) {
  for (std::vector<Bounds> level = things; !level.empty(); level = around_rows(level)) {
    levels_.push_back(in_rows(level, slop));
    if (levels_.back().size() <= kMostOnTop) break;
  }
}

simd8::TreeData BoundsTree::single_precision() const {
  simd8::TreeData data{};
  if (!levels_.empty()) data.n_on_top = static_cast<int>(levels_.back().size());
  for (const std::vector<simd8::Bounds8>& level : levels_) data.levels[data.n_levels++] = level.data();
  return data;
}

double BoundsTree::distance(const simd8::Bounds8& boxes, int i, const Vec3& point) {
  const double p[3] = {point.x, point.y, point.z};
  double d[3];
  for (int axis = 0; axis < 3; ++axis)
    d[axis] = std::max({boxes.low[axis][i] - p[axis], p[axis] - boxes.high[axis][i], 0.0});
  return norm({d[0], d[1], d[2]});
}

}  // namespace apc
