//! \file
//! The intervals of an edge that are still to be proven.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "collision/interval_queue.hpp"

using apc::Interval;
using apc::IntervalQueue;

namespace {

//! Sum of the lengths.
double covered(const Interval* first, const Interval* last) {
  double length = 0.0;
  for (const Interval* i = first; i != last; ++i) length += 2.0 * i->half;
  return length;
}

}  // namespace

TEST_CASE("a new queue holds the whole edge in equal parts") {
  std::vector<Interval> memory;
  IntervalQueue queue(memory);
  Interval taken[apc::simd8::kLanes];
  queue.take(taken);
  CHECK(queue.pending() == 0);
  CHECK(covered(std::begin(taken), std::end(taken)) == 1.0);
  double end = 0.0;
  for (const Interval& each : taken) {
    CHECK_LE(std::abs(each.middle - each.half - end), 1e-15);
    end = each.middle + each.half;
    CHECK(each.world == ~apc::simd8::Frames{0});
  }
  CHECK_LE(std::abs(end - 1.0), 1e-15);
}

TEST_CASE("halving leaves no gap and keeps what is unproven") {
  std::vector<Interval> memory;
  IntervalQueue queue(memory);
  Interval taken[apc::simd8::kLanes];
  queue.take(taken);
  for (Interval& each : taken) queue.halve({each.middle, each.half, 5, 9});
  CHECK(queue.pending() == 2 * apc::simd8::kLanes);
  double length = 0.0;
  while (queue.pending() > 0) {
    queue.take(taken);
    length += covered(std::begin(taken), std::end(taken));
    for (const Interval& each : taken) {
      CHECK(each.world == 5);
      CHECK(each.self == 9);
      CHECK(each.half == 1.0 / 32);
    }
  }
  CHECK(length == 1.0);
}

TEST_CASE("lanes that would idle are filled by halving") {
  std::vector<Interval> memory;
  IntervalQueue queue(memory);
  Interval taken[apc::simd8::kLanes];
  queue.take(taken);
  queue.halve({0.25, 0.25, 1, 1});  // two intervals, for eight lanes
  queue.take(taken);
  CHECK(queue.pending() == 0);
  CHECK(covered(std::begin(taken), std::end(taken)) == 0.5);
}

TEST_CASE("the widest interval comes first, also after thousands") {
  std::vector<Interval> memory;
  IntervalQueue queue(memory);
  Interval taken[apc::simd8::kLanes];
  double widest = 1.0;
  for (int round = 0; round < 10; ++round) {
    const int n = queue.pending() / apc::simd8::kLanes;
    for (int i = 0; i < n; ++i) {
      queue.take(taken);
      for (const Interval& each : taken) {
        CHECK_LE(each.half, widest);
        widest = each.half;
        queue.halve(each);
      }
    }
  }
  CHECK(queue.pending() == (apc::simd8::kLanes << 10));
}
