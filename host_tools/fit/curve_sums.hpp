// The control values of a speed curve as differences of running sums: in these an area of the curve, too,
// speaks of neighbours only.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "host_tools/fit/control_curve.hpp"
#include "host_tools/numerics/band_program.hpp"

namespace inbetween {

/// Speed curves with f + 1 control values, of which some stay 0, as the unknowns of a BandProgram.
///
/// On every span the curve is the sum of four uniform B-splines, also beside its ends: values -1 and f + 1
/// stand there, which the ends of the curve tell. The unknowns are the sums of the values up to each, in an
/// order in which neighbours, and of a periodic curve the two ends, are near. Values that stay 0 have no
/// unknown.
class CurveSums {
 public:
  using Terms = std::vector<Term>;

  /// `rests` has an entry for every control value: whether it stays 0.
  CurveSums(const std::vector<bool>& rests, CurveEnds ends);

  [[nodiscard]] std::size_t unknown_count() const { return count_; }
  /// The unknowns of a curve, whose values are 0 where they are to stay so.
  [[nodiscard]] std::vector<double> unknowns(std::span<const double> values) const;

  /// Control value i, 0..f.
  [[nodiscard]] Terms value(std::size_t i) const;
  /// The linear function of the curve at a place.
  [[nodiscard]] Terms at(const CurvePlace& place, const CurveWeights& weights) const;

  /// Demands what the ends say of the values beside them.
  void demand_ends(BandProgram& program) const;
  /// Demands that the area begins with 0. Without it, it begins anywhere.
  void demand_start(BandProgram& program) const;
  /// Adds factor * (integral of (phi - wanted)^2 over a) / 2 to the cost, but for what does not change.
  void add_distance(std::span<const double> wanted, double factor, BandProgram& program) const;

 private:
  /// Values and sums from -1 and -2 on.
  [[nodiscard]] Terms unrolled_value(std::size_t i) const;
  [[nodiscard]] std::vector<double> unrolled(std::span<const double> values) const;

  std::size_t f_;
  CurveEnds ends_;
  std::vector<std::size_t> place_of_sum_;  ///< f + 4 of them
  std::size_t count_ = 0;
};

}  // namespace inbetween
