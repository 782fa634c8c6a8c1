#include "host_tools/fit/control_curve.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

namespace inbetween {
namespace {

using Ordinates = std::array<double, 4>;

/// How the Bezier ordinates of a span depend on the control values around it. Those beyond an end have no
/// influence, or are those at the other end of a periodic curve.
class SpanWeights {
 public:
  SpanWeights(std::size_t span, std::size_t span_count, CurveEnds ends)
      : span_(span), span_count_(span_count), ends_(ends) {
    const bool is_periodic = ends == CurveEnds::periodic;
    weights_[0] = span == 0 && !is_periodic ? Ordinates{0, 1, 0, 0} : Ordinates{1.0 / 6, 4.0 / 6, 1.0 / 6, 0};
    weights_[1] = {0, 2.0 / 3, 1.0 / 3, 0};
    weights_[2] = {0, 1.0 / 3, 2.0 / 3, 0};
    weights_[3] = span + 1 == span_count && !is_periodic ? Ordinates{0, 0, 1, 0}
                                                         : Ordinates{0, 1.0 / 6, 4.0 / 6, 1.0 / 6};
  }

  /// Of the ordinate, on the control value at `i`, 0..3.
  [[nodiscard]] double operator()(std::size_t ordinate, std::size_t i) const { return weights_[ordinate][i]; }
  /// The index of the control value at `i`, 0..3: span - 1 .. span + 2. Nothing beyond an end.
  [[nodiscard]] std::optional<std::size_t> index(std::size_t i) const {
    const std::size_t one_more = span_ + i;
    const bool is_beyond = one_more < 1 || one_more > span_count_ + 1;
    if (!is_beyond) return one_more - 1;
    if (ends_ == CurveEnds::natural) return std::nullopt;
    return one_more < 1 ? span_count_ - 1 : 1;
  }

 private:
  std::size_t span_, span_count_;
  CurveEnds ends_;
  std::array<Ordinates, 4> weights_{};
};

/// Adds a linear function of the ordinates of one span.
void add_ordinates(const Ordinates& factors, std::size_t span, CurveEnds ends, std::span<double> row) {
  const SpanWeights weights(span, row.size() - 1, ends);
  for (std::size_t i = 0; i < 4; ++i) {
    const std::optional<std::size_t> index = weights.index(i);
    for (std::size_t k = 0; index && k < 4; ++k) row[*index] += factors[k] * weights(k, i);
  }
}

SpeedSpan<double> span_of(const Ordinates& b) {
  return {b[0], b[1], b[2], b[3]};
}

/// The functions of a span at t as factors of its ordinates. Each factor is the function of a span whose one
/// ordinate is 1 and whose others are 0.
Ordinates factors_at(double t, const CurveWeights& weights) {
  Ordinates factors{};
  for (std::size_t k = 0; k < 4; ++k) {
    Ordinates unit{};
    unit[k] = 1;
    const SpeedSpan<double> span = span_of(unit);
    factors[k] = weights.area * span.integral(t) + weights.value * span.value(t) +
                 weights.first * span.derivative(t) + weights.second * span.second(t);
  }
  return factors;
}

}  // namespace

ControlCurve::ControlCurve(std::span<const double> values, CurveEnds ends) {
  TwoSum<double> area;
  areas_.push_back(0);
  for (std::size_t i = 0; i + 1 < values.size(); ++i) {
    spans_.push_back(speed_span(values, i, ends));
    area.add(spans_.back().integral());
    areas_.push_back(area.high + area.low);
  }
}

CurveValues ControlCurve::at(const CurvePlace<double>& place) const {
  const auto index = static_cast<std::size_t>(place.span);
  const SpeedSpan<double>& span = spans_[index];
  return {.area = areas_[index] + span.integral(place.t),
          .value = span.value(place.t),
          .first = span.derivative(place.t),
          .second = span.second(place.t),
          .third = span.third()};
}

CurvePlace<double> ControlCurve::place_of_area(double area) const {
  const auto above = std::ranges::lower_bound(areas_, area);
  if (above == areas_.begin()) return {0, 0};
  if (above == areas_.end()) return {static_cast<std::int32_t>(spans_.size()) - 1, 1};
  const auto index = static_cast<std::size_t>(above - areas_.begin()) - 1;
  const SpeedSpan<double>& span = spans_[index];
  const double wanted = area - areas_[index];
  double low = 0;
  double high = 1;
  double t = span.integral() > 0 ? wanted / span.integral() : 0.5;
  for (int i = 0; i < std::numeric_limits<double>::digits; ++i) {
    const double excess = span.integral(t) - wanted;
    (excess < 0 ? low : high) = t;
    const double newton = t - excess / span.value(t);
    const double next = newton > low && newton < high ? newton : (low + high) / 2;
    if (std::fabs(next - t) <= std::numeric_limits<double>::epsilon()) break;
    t = next;
  }
  return {static_cast<std::int32_t>(index), t};
}

ControlCurve::Largest ControlCurve::largest() const {
  Largest found;
  for (std::size_t i = 0; i < spans_.size(); ++i) {
    const SpeedSpan<double>& span = spans_[i];
    const auto look = [&](double t) {
      if (!(t >= 0 && t <= 1)) return;
      const double value = std::fabs(span.value(t));
      if (value > found.value) found = {value, static_cast<double>(i) + t};
    };
    look(0);
    look(1);
    // phi' / 3 = c + 2 b t + a t^2
    const double c = span.b1 - span.b0;
    const double b = (span.b2 - span.b1) - c;
    const double a = (span.b3 - span.b2) - (span.b2 - span.b1) - b;
    const double root = std::sqrt(std::max(b * b - a * c, 0.0));
    const double larger = -(b + std::copysign(root, b));
    if (a != 0) look(larger / a);
    if (larger != 0) look(c / larger);
  }
  return found;
}

CurvePlace<double> place_at(double a, std::size_t span_count) {
  const double last = static_cast<double>(span_count) - 1;
  const double span = std::clamp(std::floor(a), 0.0, last);
  return {static_cast<std::int32_t>(span), std::clamp(a - span, 0.0, 1.0)};
}

void add_row(const CurvePlace<double>& place, const CurveWeights& weights, std::span<double> row,
             CurveEnds ends) {
  const auto index = static_cast<std::size_t>(place.span);
  add_ordinates(factors_at(place.t, weights), index, ends, row);
  if (weights.area == 0) return;
  const double quarter = weights.area / 4;
  for (std::size_t i = 0; i < index; ++i) add_ordinates({quarter, quarter, quarter, quarter}, i, ends, row);
}

std::vector<double> gram_matrix(std::size_t count, CurveEnds ends) {
  constexpr std::array<double, 4> binomial3 = {1, 3, 3, 1};
  constexpr std::array<double, 7> binomial6 = {1, 6, 15, 20, 15, 6, 1};
  std::vector<double> matrix(count * count);
  for (std::size_t span = 0; span + 1 < count; ++span) {
    const SpanWeights weights(span, count - 1, ends);
    for (std::size_t k = 0; k < 4; ++k) {
      for (std::size_t l = 0; l < 4; ++l) {
        const double product = binomial3[k] * binomial3[l] / (7 * binomial6[k + l]);
        for (std::size_t i = 0; i < 4; ++i) {
          for (std::size_t j = 0; j < 4; ++j) {
            const std::optional<std::size_t> row = weights.index(i);
            const std::optional<std::size_t> column = weights.index(j);
            if (row && column) matrix[*row * count + *column] += product * weights(k, i) * weights(l, j);
          }
        }
      }
    }
  }
  return matrix;
}

double mean_square(std::span<const double> values, CurveEnds ends) {
  const ControlCurve curve(values, ends);
  // phi^2 is of degree 6 on a span: Gauss and Legendre's rule with 4 points is exact.
  constexpr std::array<double, 2> places = {0.8611363115940526, 0.3399810435848563};
  constexpr std::array<double, 2> weights = {0.3478548451374538, 0.6521451548625461};
  double sum = 0;
  for (std::size_t i = 0; i < curve.span_count(); ++i) {
    for (std::size_t k = 0; k < places.size(); ++k) {
      for (const double side : {-1.0, 1.0}) {
        const double value = curve.at({static_cast<std::int32_t>(i), (1 + side * places[k]) / 2}).value;
        sum += weights[k] / 2 * value * value;
      }
    }
  }
  return sum / static_cast<double>(curve.span_count());
}

std::vector<double> refined(std::span<const double> values, CurveEnds ends) {
  const std::size_t f = values.size() - 1;
  std::vector<double> fine(values.begin(), values.end());
  fine.resize(2 * f + 1);
  refine_control_values<double>(fine, f, ends);
  return fine;
}

std::vector<bool> rests_of(std::span<const double> values, CurveEnds ends) {
  std::vector<bool> rests;
  for (std::size_t i = 0; i < values.size(); ++i) rests.push_back(is_rest(values, i, ends));
  return rests;
}

}  // namespace inbetween
