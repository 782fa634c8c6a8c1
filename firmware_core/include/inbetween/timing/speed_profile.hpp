#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "inbetween/base/precision.hpp"
#include "inbetween/base/result.hpp"

/// The speed curve phi(a) that the animator draws: how fast, in proportion, with no notion of distance.

namespace inbetween {

inline constexpr int largest_control_value = 100;

/// One span of the curve, a in [i, i + 1], as Bezier ordinates. All four are means of neighbouring
/// control values with weights >= 0, so nothing computed from them leaves the hull of the control
/// values, and a curve that is >= 0 has an integral that never falls.
struct SpeedSpan {
  double b0 = 0, b1 = 0, b2 = 0, b3 = 0;

  [[nodiscard]] constexpr double value(double t) const {
    const double r = 1 - t;
    return r * r * (r * b0 + 3 * t * b1) + t * t * (3 * r * b2 + t * b3);
  }
  [[nodiscard]] constexpr double derivative(double t) const {
    const double r = 1 - t;
    return 3 * (r * r * (b1 - b0) + 2 * r * t * (b2 - b1) + t * t * (b3 - b2));
  }
  [[nodiscard]] constexpr double second(double t) const {
    return 6 * ((1 - t) * ((b2 - b1) - (b1 - b0)) + t * ((b3 - b2) - (b2 - b1)));
  }
  [[nodiscard]] constexpr double third() const { return 6 * ((b3 - b0) - 3 * (b2 - b1)); }
  /// Integral from 0 to t: the quartic with Bezier ordinates 0, b0/4, (b0+b1)/4, ...
  [[nodiscard]] constexpr double integral(double t) const {
    const double r = 1 - t;
    const double s01 = b0 + b1;
    const double s02 = s01 + b2;
    return t * (r * r * r * b0 + t * (1.5 * r * r * s01 + t * (r * s02 + t * (s02 + b3) / 4)));
  }
  [[nodiscard]] constexpr double integral() const { return ((b0 + b1) + (b2 + b3)) / 4; }
};

/// What the curve knows of its control values beyond the ends.
enum class CurveEnds : std::uint8_t {
  natural,   ///< phi'' is 0 at both ends, and phi is v_0 and v_f there
  periodic,  ///< v_f is v_0, and behind it comes v_1: the curve goes on from its end to its beginning
};

/// Span `index` of the curve that SpeedProfile describes, for f + 1 >= 2 control values of any sign and size.
constexpr SpeedSpan speed_span(std::span<const double> values, std::size_t index,
                               CurveEnds ends = CurveEnds::natural) {
  const std::size_t f = values.size() - 1;
  const auto knot = [&](std::size_t i) {  // phi at a = i; the natural ends give the value itself
    const bool is_end = i == 0 || i == f;
    if (is_end && ends == CurveEnds::periodic) return (values[f - 1] + 4 * values[0] + values[1]) / 6;
    return is_end ? values[i] : (values[i - 1] + 4 * values[i] + values[i + 1]) / 6;
  };
  const double here = values[index];
  const double next = values[index + 1];
  return {knot(index), (2 * here + next) / 3, (here + 2 * next) / 3, knot(index + 1)};
}

/// Doubles the number of spans and leaves the curve as it is, its ends included (Lane and Riesenfeld
/// 1980): phi(a) of the coarse curve is phi(2 a) of the fine one. In place: `values` begins with the f + 1
/// coarse values and has room for 2 f + 1.
constexpr void refine_control_values(std::span<double> values, std::size_t f,
                                     CurveEnds ends = CurveEnds::natural) {
  const double seam = (values[f - 1] + 6 * values[0] + values[1]) / 8;  // where the curve is periodic
  // From the right: 2 i and 2 i + 1 stand at or behind i, and the coarse values left of i are still there.
  double right = values[f];  // coarse value i + 1
  double here = values[f];   // coarse value i
  for (std::size_t i = f + 1; i-- > 0;) {
    const double left = i > 0 ? values[i - 1] : here;
    const double end = ends == CurveEnds::periodic ? seam : here;
    values[2 * i] = i == 0 || i == f ? end : (left + 6 * here + right) / 8;
    if (i < f) values[2 * i + 1] = (here + right) / 2;
    right = here;
    here = left;
  }
}

/// Rises from 0 to 1 with two derivatives 0 at both ends: control values times it come from rest.
constexpr double smooth_step(double x) {
  const double u = std::clamp(x, 0.0, 1.0);
  return u * u * u * (10 - u * (15 - 6 * u));
}

/// Whether the curve stands still at a control value: three zeros in a row, or two at an end, of which a
/// periodic curve has none.
constexpr bool is_rest(std::span<const double> values, std::size_t index,
                       CurveEnds ends = CurveEnds::natural) {
  if (ends == CurveEnds::periodic) {
    const std::size_t period = values.size() - 1;
    const auto is_zero = [&](std::size_t beyond) {
      return values[(index + 2 * period + beyond - 2) % period] == 0;
    };
    for (std::size_t first = 0; first < 3; ++first) {
      if (is_zero(first) && is_zero(first + 1) && is_zero(first + 2)) return true;
    }
    return false;
  }
  const auto zeros = [&](std::size_t first, std::size_t last) {
    const auto part = values.subspan(first, last - first + 1);
    return std::ranges::all_of(part, [](double value) { return value == 0; });
  };
  const std::size_t f = values.size() - 1;
  if (index <= 1 && zeros(0, 1)) return true;
  if (index + 1 >= f && zeros(f - 1, f)) return true;
  for (std::size_t middle = std::max<std::size_t>(index, 2) - 1; middle <= index + 1; ++middle) {
    if (middle + 1 <= f && zeros(middle - 1, middle + 1)) return true;
  }
  return false;
}

/// The memory of a speed profile, owned by the caller.
struct SpeedProfileMemory {
  std::span<SpeedSpan> spans;   ///< f
  std::span<TwoSum> integrals;  ///< f + 1
};

/// Uniform cubic B-spline with control values v_0..v_f over a = 0..f and natural ends: the phantom
/// values v_-1 = 2 v_0 - v_1 and v_f+1 = 2 v_f - v_f-1 make the second derivative zero there
/// (Bartels, Beatty and Barsky 1987, ch. 4). Hence phi(0) = v_0, phi(f) = v_f and
/// min v <= phi <= max v. With periodic ends phi, phi' and phi'' are at f what they are at 0. Refers to the
/// caller's memory.
class SpeedProfile {
 public:
  /// No curve, for a track that is timed by the frames of its keys: span_count() is 0.
  static SpeedProfile none() { return {}; }
  /// Errors: wrong_count (none), not_finite, out_of_range (outside [0, 100], with the index of the
  /// control value; periodic ends of which the last control value is not the first), capacity. One value
  /// means two equal ones. Cost: linear in f.
  static Result<SpeedProfile> make(std::span<const double> control_values, const SpeedProfileMemory& memory,
                                   CurveEnds ends = CurveEnds::natural);

  /// f, the number of spans: a runs over [0, f].
  [[nodiscard]] std::int32_t span_count() const { return static_cast<std::int32_t>(spans_.size()); }
  [[nodiscard]] const SpeedSpan& span(std::int32_t index) const {
    return spans_[static_cast<std::size_t>(index)];
  }
  /// Phi at the start of span `index`, 0..f; Phi(f) at index f.
  [[nodiscard]] const TwoSum& integral_before(std::int32_t index) const {
    return integrals_[static_cast<std::size_t>(index)];
  }
  [[nodiscard]] double total_integral() const { return integrals_.back().high; }

  /// phi, phi', phi'' and Phi at a in [0, f]; a outside is a defect of the caller.
  [[nodiscard]] double value(double a) const { return at(a).value(local(a)); }
  [[nodiscard]] double derivative(double a) const { return at(a).derivative(local(a)); }
  [[nodiscard]] double second(double a) const { return at(a).second(local(a)); }
  [[nodiscard]] double integral(double a) const {
    const TwoSum& before = integral_before(index(a));
    return before.high + (before.low + at(a).integral(local(a)));
  }

 private:
  SpeedProfile() = default;
  [[nodiscard]] std::int32_t index(double a) const {
    const auto whole = static_cast<std::int32_t>(a);
    return whole < span_count() ? whole : span_count() - 1;
  }
  [[nodiscard]] const SpeedSpan& at(double a) const { return span(index(a)); }
  [[nodiscard]] double local(double a) const { return a - static_cast<double>(index(a)); }

  std::span<const SpeedSpan> spans_;
  std::span<const TwoSum> integrals_;
};

template <std::size_t ControlValues>
struct SpeedProfileStorage {
  std::array<SpeedSpan, (ControlValues > 1 ? ControlValues : 2) - 1> spans;
  std::array<TwoSum, (ControlValues > 1 ? ControlValues : 2)> integrals;

  [[nodiscard]] SpeedProfileMemory memory() { return {spans, integrals}; }
};

}  // namespace inbetween
