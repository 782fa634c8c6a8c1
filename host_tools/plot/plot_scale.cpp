#include "host_tools/plot/plot_scale.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace inbetween {
namespace {

// Pixels per unit of a smaller range would overflow.
constexpr double min_size = 1e-290;

// mantissa * 10^exponent. Dividing by a positive power gives 0.3 where multiplying by 0.1 gives
// 0.30000000000000004.
struct Step {
  double mantissa = 1;
  int exponent = 0;

  [[nodiscard]] double times(double count) const {
    const double power = std::pow(10.0, std::abs(exponent));
    return exponent < 0 ? count * mantissa / power : count * mantissa * power;
  }
  [[nodiscard]] double value() const { return times(1); }
  [[nodiscard]] Step next() const {
    if (mantissa < 2) return {2, exponent};
    if (mantissa < 5) return {5, exponent};
    return {1, exponent + 1};
  }
};

struct Multiples {
  double first = 0;
  double last = 0;
};

// A tick that is outside by rounding only is still wanted.
Multiples multiples_inside(const Range& range, const Step& step) {
  constexpr double slack = 1e-9;
  return {std::ceil(range.low / step.value() - slack), std::floor(range.high / step.value() + slack)};
}

int decimals_for(double step) {
  return std::max(0, static_cast<int>(std::ceil(-std::log10(step) - 1e-9)));
}

double power_of_ten_below(double value) {
  return std::pow(10.0, std::floor(std::log10(value)));
}

}  // namespace

Range range_of(std::span<const double> values) {
  if (values.empty()) return {};
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  return {*low, *high};
}

Range widened(Range range, double share) {
  const double magnitude = std::max(std::abs(range.low), std::abs(range.high));
  if (range.size() > std::max(1e-12 * magnitude, min_size)) {
    return {range.low - share * range.size(), range.high + share * range.size()};
  }
  const double middle = range.low + range.size() / 2;
  const double half = std::max(0.5, 1e-11 * magnitude);
  return {middle - half, middle + half};
}

std::vector<double> round_ticks(const Range& range, int max_count, double smallest_step) {
  Step step{1, static_cast<int>(std::floor(std::log10(range.size() / max_count))) - 1};
  Multiples inside = multiples_inside(range, step);
  Step finer = step;
  while (step.value() < smallest_step * (1 - 1e-9) || inside.last - inside.first + 1 > max_count) {
    finer = step;
    step = step.next();
    inside = multiples_inside(range, step);
  }
  const bool is_finer_allowed = finer.value() >= smallest_step * (1 - 1e-9);
  if (inside.last - inside.first < 1 && max_count > 1 && is_finer_allowed) {
    // One number alone gives no scale; the outer ones of the next finer step do.
    const Multiples all = multiples_inside(range, finer);
    return {finer.times(all.first) + 0.0, finer.times(all.last) + 0.0};
  }
  std::vector<double> ticks;
  const int gaps = static_cast<int>(inside.last - inside.first);
  // + 0.0 turns the negative zero, which would be printed "-0", into zero.
  for (int i = 0; i <= gaps; ++i) ticks.push_back(step.times(inside.first + i) + 0.0);
  return ticks;
}

TickLabels tick_labels(std::span<const double> ticks) {
  TickLabels out;
  if (ticks.empty()) return out;
  const Range range = range_of(ticks);
  const double magnitude = std::max(std::abs(range.low), std::abs(range.high));
  const double step = ticks.size() > 1 ? ticks[1] - ticks[0] : magnitude;
  if (step <= 0) {
    out.labels.assign(ticks.size(), "0");
    return out;
  }
  // More than five digits do not fit beside a panel; what they have in common goes to the title of the axis.
  if (magnitude / step > 1e4) {
    const double block = 10 * power_of_ten_below(range.size());
    out.offset = std::round((range.low + range.size() / 2) / block) * block;
  }
  const double greatest = std::max(std::abs(range.low - out.offset), std::abs(range.high - out.offset));
  if (greatest >= 1e6 || decimals_for(step) > 4) {
    out.factor = std::pow(10.0, 3 * std::floor(std::log10(greatest) / 3));
  }
  // A lone tick is its own step and needs the digits that it has, not those of its power of ten.
  const int decimals = ticks.size() > 1 ? decimals_for(step / out.factor) : -1;
  for (const double tick : ticks) {
    const double shown = (tick - out.offset) / out.factor;
    out.labels.push_back(decimals < 0 ? fmt::format("{:.10g}", shown)
                                      : fmt::format("{:.{}f}", shown, decimals));
  }
  return out;
}

std::string axis_title(std::string_view name, std::string_view unit, const TickLabels& labels) {
  std::string title(name);
  if (labels.offset != 0)
    title += fmt::format(" {} {}", labels.offset < 0 ? '+' : '-', std::abs(labels.offset));
  std::string units = labels.factor == 1 ? std::string{} : fmt::format("1e{:.0f}", std::log10(labels.factor));
  if (!units.empty() && !unit.empty()) units += ' ';
  units += unit;
  if (!units.empty()) title += fmt::format(" ({})", units);
  return title;
}

double round_step(double min_step) {
  Step step;
  while (step.value() < min_step) step = step.next();
  return step.value();
}

}  // namespace inbetween
