//! \file
//! A polyline whose corners are smoothed: its states and bounds of its derivatives.
//!
//! At corner k, at arc length s_k, the direction changes by turn_k within h_k of it: the slope of the ramp
//! is the quintic smoothstep there. The parameter s is the arc length of the polyline, in the Euclidean norm
//! of joint units (rad and m alike).
#pragma once

#include <cstddef>
#include <vector>

namespace apc {

//! The polyline, row-major.
struct PolylineData {
  std::vector<double> corners;       //!< (K, n), K >= 1
  std::vector<double> s;             //!< (K,) arc length of every corner, increasing from 0
  std::vector<double> half_lengths;  //!< (K,) h of every corner; 0 where nothing is smoothed
  std::vector<double> directions;    //!< (K + 1, n) unit vectors before and after every corner
  std::vector<double> turns;         //!< (K, n) change of direction at every corner
};

class BlendedPolyline {
 public:
  explicit BlendedPolyline(PolylineData data);

  std::size_t n() const { return n_; }
  double length() const { return data_.s.back(); }

  //! q and its derivatives by s up to highest (0 to 3) at s (M,), clamped to the curve: out (highest + 1, M,
  //! n).
  void evaluate(const double* s, std::size_t M, int highest, double* out) const;

  //! Sorted s of both ends, of all stops, and of nodes within the blends, dense where the path bends fast.
  //! Between two that lie in no blend it is straight.
  std::vector<double> knots() const;

  //! Whether nothing bends on each of the intervals start (M,) .. end (M,), which lie between knots.
  void are_lines(const double* start, const double* end, std::size_t M, bool* out) const;

  //! Upper bounds (M, n) of |q''| on each of the intervals start (M,) .. end (M,).
  void bound_second(const double* start, const double* end, std::size_t M, double* out) const;

  //! Upper bounds (M, n) of |q'''| on each of the intervals start (M,) .. end (M,).
  void bound_third(const double* start, const double* end, std::size_t M, double* out) const;

  //! Upper bounds (M,) of the Euclidean distance from the polyline on each of the intervals start .. end.
  void bound_deviation(const double* start, const double* end, std::size_t M, double* out) const;

 private:
  //! Corners [first, last), among which are all whose blends reach into an interval.
  struct Corners {
    std::size_t first, last;
  };
  Corners near(double start, double end) const;
  std::size_t edge_of(double s) const;
  void add_nodes(std::size_t first, std::size_t last, std::vector<double>& out) const;
  const double* direction(std::size_t edge) const { return &data_.directions[(edge + 1) * n_]; }
  const double* turn(std::size_t k) const { return &data_.turns[k * n_]; }

  PolylineData data_;
  std::size_t n_;
  std::vector<double> starts_, ends_;  //!< (K,) of the blends, made monotonic
};

//! A motion along such a curve, from rest to rest: s and its derivatives at times t, each (K,).
struct Pace {
  std::size_t K;
  const double *t, *s, *ds, *dds;
};

//! What joints may do at most, each (n,).
struct JointLimits {
  const double *velocity, *acceleration, *jerk;
};

//! Factor of time (K - 1,), at least 1, at which the quintics between the pace's points keep the limits times
//! scale (K - 1,).
void needed_time_scale(const BlendedPolyline& curve, const Pace& pace, const JointLimits& limits,
                       const double* scale, double* out);

}  // namespace apc
