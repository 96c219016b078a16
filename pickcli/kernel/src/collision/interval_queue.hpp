//! \file
//! What is still to be proven of an edge.
#pragma once

#include <algorithm>
#include <vector>

#include "simd/simd8_collision.hpp"

namespace apc {

//! All t within half of middle.
struct Interval {
  double middle, half;
  simd8::Frames world, self;  //!< not yet proven for it: frames against the world, against inner frames
};

//! Intervals still to be proven, widest first: a hit anywhere on the edge is found early.
class IntervalQueue {
 public:
  //! The whole edge in eighths. intervals: memory to use.
  explicit IntervalQueue(std::vector<Interval>& intervals) : intervals_(intervals) {
    constexpr simd8::Frames everything = ~simd8::Frames{0};
    constexpr double half = 0.5 / simd8::kLanes;
    intervals_.clear();
    for (int i = 0; i < simd8::kLanes; ++i)
      intervals_.push_back({(2 * i + 1) * half, half, everything, everything});
  }

  //! The next eight intervals. Lanes that would idle are filled by halving: they cost the same.
  void take(Interval* out) {
    while (pending() < simd8::kLanes) halve(intervals_[first_++]);
    std::copy_n(intervals_.begin() + static_cast<std::ptrdiff_t>(first_), simd8::kLanes, out);
    first_ += simd8::kLanes;
    if (first_ > 4096) drop_taken();
  }

  void halve(Interval whole) {
    const double half = 0.5 * whole.half;
    intervals_.push_back({whole.middle - half, half, whole.world, whole.self});
    intervals_.push_back({whole.middle + half, half, whole.world, whole.self});
  }

  int pending() const { return static_cast<int>(intervals_.size() - first_); }

 private:
  void drop_taken() {
    intervals_.erase(intervals_.begin(), intervals_.begin() + static_cast<std::ptrdiff_t>(first_));
    first_ = 0;
  }

  std::vector<Interval>& intervals_;
  std::size_t first_ = 0;
};

}  // namespace apc
