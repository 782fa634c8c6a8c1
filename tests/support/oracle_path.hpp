// The path of the oracle: positions, derivatives, and lengths by adaptive quadrature, all in long double.
#pragma once

#include <array>
#include <vector>

#include "tests/support/oracle_spline.hpp"

namespace inbetween::oracle {

/// Where on a path: segment i lies between keys i and i + 1, 0 <= t <= 1.
struct Place {
  int segment = 0;
  long double t = 0;
};

class Path {
 public:
  /// Throws std::invalid_argument as segment_cubics() does.
  explicit Path(const Keys& keys);

  int segments() const { return static_cast<int>(segments_.size()); }
  int axes() const { return static_cast<int>(weights_.size()); }
  long double weight(int axis) const { return weights_.at(static_cast<std::size_t>(axis)); }

  // Every function below throws std::out_of_range for a segment or axis that does not exist and for a t
  // outside [0, 1] or NaN.

  long double position(int segment, long double t, int axis) const;
  /// Position minus that of the key where the segment starts: keeps its digits where keys lie far from zero.
  long double offset(int segment, long double t, int axis) const;
  /// Derivative of order 1 to 3 with respect to t.
  long double derivative(int order, int segment, long double t, int axis) const;
  /// |diag(weights) dP/dt|.
  long double speed(int segment, long double t) const;

  // Lengths are measured through the weights. Their relative error is below 1e-17 and their absolute error
  // below 1e-19 of the path, whichever is larger, also across cusps.

  /// Length from t0 to t1; negative where t1 < t0.
  long double length(int segment, long double t0, long double t1) const;
  /// Length from one place to another; negative going back. Short steps are integrated directly, not
  /// subtracted.
  long double travelled(Place from, Place to) const;
  long double distance(int segment, long double t) const { return travelled({0, 0}, {segment, t}); }
  long double total_length() const { return total_length_; }

  /// The place at a distance from the start, by Newton's method kept inside a shrinking bracket. 0 is the
  /// start and total_length() the end; where the path stands still at that distance, the first such place.
  /// Throws std::out_of_range outside [0, total_length()].
  Place place(long double distance) const;

  /// The smallest over the largest speed(segment, .) of one segment, least over all segments that move: 0 at
  /// a cusp or a key without tangent, 1 on a straight line evenly run. Where nothing moves, 1.
  long double slowest() const;

  /// Which smooth piece of its segment t lies in: speed() has kinks or near-kinks only between two pieces.
  int piece(int segment, long double t) const;

 private:
  struct Segment {
    std::vector<Cubic> axis;
    std::vector<std::array<long double, 3>> weighted_slope;  ///< coefficients of w dP/dt per axis
    long double largest_speed = 0;
    std::vector<long double> bounds;           ///< of the pieces: 0, slow places, 1
    std::vector<long double> length_to_bound;  ///< from t = 0
  };

  const Segment& at(int segment, long double t) const;
  const Cubic& cubic(int segment, long double t, int axis) const;
  long double length(const Segment& segment, long double t0, long double t1) const;
  long double t_within(const Segment& segment, long double distance) const;

  std::vector<Segment> segments_;
  std::vector<long double> weights_;
  std::vector<long double> segment_length_;
  long double total_length_ = 0;
};

}  // namespace inbetween::oracle
