#include "host_tools/fit/control_curve.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace inbetween {
ControlCurve::ControlCurve(std::span<const double> values, CurveEnds ends) {
  TwoSum area;
  areas_.push_back(0);
  for (std::size_t i = 0; i + 1 < values.size(); ++i) {
    spans_.push_back(speed_span(values, i, ends));
    area.add(spans_.back().integral());
    areas_.push_back(area.high + area.low);
  }
}

CurvePlace ControlCurve::place_of_area(double area, const CurvePlace& near) const {
  // Newton's method doubles the digits: after such a step, as a share of what is left to either end, the next
  // one would change nothing but rounding.
  constexpr double last_step = 1e-9;
  const auto guess = static_cast<std::size_t>(near.span);
  const bool is_same_span = guess < spans_.size() && areas_[guess] < area && area <= areas_[guess + 1];
  const std::size_t above =
      is_same_span ? guess + 1
                   : static_cast<std::size_t>(std::ranges::lower_bound(areas_, area) - areas_.begin());
  if (above == 0) return {0, 0};
  if (above == areas_.size()) return {static_cast<std::int32_t>(spans_.size()) - 1, 1};
  const std::size_t index = above - 1;
  const SpeedSpan& span = spans_[index];
  const double wanted = area - areas_[index];
  double low = 0;
  double high = 1;
  double t = span.integral() > 0 ? wanted / span.integral() : 0.5;
  if (near.span == static_cast<std::int32_t>(index) && near.t > 0 && near.t < 1) {
    t = near.t;
  }
  for (int i = 0; i < std::numeric_limits<double>::digits; ++i) {
    const double excess = span.integral(t) - wanted;
    (excess < 0 ? low : high) = t;
    const double newton = t - excess / span.value(t);
    const double next = newton > low && newton < high ? newton : (low + high) / 2;
    const double step = std::fabs(next - t);
    if (step <= std::numeric_limits<double>::epsilon()) break;
    t = next;
    if (next == newton && step <= last_step * std::min(t, 1 - t)) break;
  }
  return {static_cast<std::int32_t>(index), t};
}

ControlCurve::Largest ControlCurve::largest() const {
  Largest found;
  for (std::size_t i = 0; i < spans_.size(); ++i) {
    const SpeedSpan& span = spans_[i];
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

CurvePlace place_at(double a, std::size_t span_count) {
  const double last = static_cast<double>(span_count) - 1;
  const double span = std::clamp(std::floor(a), 0.0, last);
  return {static_cast<std::int32_t>(span), std::clamp(a - span, 0.0, 1.0)};
}

double mean_square(std::span<const double> values, CurveEnds ends) {
  const ControlCurve curve(values, ends);
  double sum = 0;
  for (std::size_t i = 0; i < curve.span_count(); ++i) {
    for (const auto& [place, weight] : gauss_points) {  // exact: phi^2 is of degree 6 on a span
      const double value = curve.at({static_cast<std::int32_t>(i), place}).value;
      sum += weight * value * value;
    }
  }
  return sum / static_cast<double>(curve.span_count());
}

std::vector<double> refined(std::span<const double> values, CurveEnds ends) {
  const std::size_t f = values.size() - 1;
  std::vector<double> fine(values.begin(), values.end());
  fine.resize(2 * f + 1);
  refine_control_values(fine, f, ends);
  return fine;
}

std::vector<bool> rests_of(std::span<const double> values, CurveEnds ends) {
  std::vector<bool> rests;
  for (std::size_t i = 0; i < values.size(); ++i) rests.push_back(is_rest(values, i, ends));
  return rests;
}

}  // namespace inbetween
