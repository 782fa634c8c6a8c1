// The speed curve as a linear function of its control values. The fit of a speed curve is built on it.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "inbetween/timing/speed_profile.hpp"
#include "inbetween/timing/track.hpp"

namespace inbetween {

/// The curve at one place: Phi from 0 to there, phi, and the first three derivatives of phi by a.
struct CurveValues {
  double area = 0, value = 0, first = 0, second = 0, third = 0;
};

/// A linear function of the curve at one place: the sum of each weight times the number of the same name in
/// CurveValues.
struct CurveWeights {
  double area = 0, value = 0, first = 0, second = 0;
};

/// The curve of SpeedProfile for control values of any sign and size, because the difference of two speed
/// curves is such a curve too. It has at least two control values, of which the last is the first if the
/// curve is periodic.
class ControlCurve {
 public:
  explicit ControlCurve(std::span<const double> values, CurveEnds ends = CurveEnds::natural);

  /// f
  [[nodiscard]] std::size_t span_count() const { return spans_.size(); }
  [[nodiscard]] CurveValues at(const CurvePlace& place) const {
    const auto index = static_cast<std::size_t>(place.span);
    const SpeedSpan& span = spans_[index];
    return {.area = areas_[index] + span.integral(place.t),
            .value = span.value(place.t),
            .first = span.derivative(place.t),
            .second = span.second(place.t),
            .third = span.third()};
  }
  [[nodiscard]] double total() const { return areas_.back(); }
  /// The mean of phi over a.
  [[nodiscard]] double mean() const { return total() / static_cast<double>(span_count()); }
  /// The place where Phi first reaches `area`. The curve is nowhere negative. An area beyond the ends gives
  /// the nearer end. `near` is a place not far from it, if one is known. O(log f).
  [[nodiscard]] CurvePlace place_of_area(double area, const CurvePlace& near = {}) const;
  /// The largest |phi|, and its a. Exact: at the ends of spans and where phi' = 0.
  struct Largest {
    double value = 0, a = 0;
  };
  [[nodiscard]] Largest largest() const;

 private:
  std::vector<SpeedSpan> spans_;
  std::vector<double> areas_;  ///< f + 1: Phi where each span begins
};

/// a = span + t, the end of the last span for a = f.
CurvePlace place_at(double a, std::size_t span_count);

/// Gauss and Legendre's rule on 0..1: places and weights. It is exact up to degree 7.
struct GaussPoint {
  double place = 0, weight = 0;
};
inline constexpr std::array<GaussPoint, 4> gauss_points{{{0.0694318442029737, 0.1739274225687269},
                                                         {0.3300094782075719, 0.3260725774312731},
                                                         {0.6699905217924281, 0.3260725774312731},
                                                         {0.9305681557970263, 0.1739274225687269}}};

/// The mean of phi^2 over a.
double mean_square(std::span<const double> values, CurveEnds ends = CurveEnds::natural);

/// The same curve on twice as many spans, exactly, its ends kept (Lane and Riesenfeld 1980): phi(a) of
/// the one is phi(2 a) of the other.
std::vector<double> refined(std::span<const double> values, CurveEnds ends = CurveEnds::natural);

/// Tells for every control value whether the curve rests there, as the core sees it: two zeros at an end,
/// three in a row elsewhere.
std::vector<bool> rests_of(std::span<const double> values, CurveEnds ends = CurveEnds::natural);

}  // namespace inbetween
