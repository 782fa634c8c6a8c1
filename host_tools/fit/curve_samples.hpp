// A function of time as the integral of a B-spline, by least squares from samples.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "host_tools/fit/curve_sums.hpp"

namespace inbetween {

/// What the curve must be.
struct CurveBounds {
  double total = 0;  ///< Phi at the end
  bool rests_at_start = false, rests_at_end = false;
};

/// Samples at moments of [0, 1], and curves of `spans` spans that are to follow them. A fit costs the number
/// of samples and spans.
class CurveSamples {
 public:
  CurveSamples(std::span<const double> moments, std::size_t spans);

  [[nodiscard]] std::size_t spans() const { return spans_; }

  /// offset + Phi at any moment.
  struct Free {
    double offset = 0;
    std::vector<double> values;
  };
  /// The nearest to `samples`, one per moment. Control values have any sign.
  [[nodiscard]] Free fit(std::span<const double> samples) const;
  /// The nearest with Phi(0) = 0 and what the bounds say, no control value below 0. Nothing where there is
  /// none.
  [[nodiscard]] std::optional<std::vector<double>> fit(std::span<const double> samples,
                                                       const CurveBounds& bounds) const;

 private:
  /// Curves near the samples; values and areas are counted in shares of `unit`.
  [[nodiscard]] BandProgram programme(const CurveSums& sums, std::span<const double> samples,
                                      double unit) const;

  std::size_t spans_;
  std::vector<CurvePlace> places_;
};

/// Schwarz' criterion, up to what is common to all: the less the better. `square` is the mean square of what
/// is left of the samples.
double information(double square, std::size_t samples, std::size_t parameters);

}  // namespace inbetween
