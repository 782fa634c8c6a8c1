#include "host_tools/fit/speed_descent.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace inbetween {
namespace {

/// The price of an excess at first, beside a change that is the square of a share of the mean. The price
/// rises by price_factor if the excess does not go away. None of 2000 random fits needed more than
/// highest_price.
constexpr double first_price = 20;
constexpr double price_factor = 1000;
constexpr double highest_price = 1e4;
/// The cost is linear in the excess, but for this share, which is quadratic because the method needs it.
constexpr double quadratic_share = 1e-3;
constexpr int max_steps = 80;
constexpr double first_radius = 0.5;  // in means of the wanted curve
constexpr double min_radius = 1e-7;
/// The last step is one that gains less than this share of the cost.
constexpr double min_gain = 1e-5;
/// This is added to the cost, so that the search ends at once for a curve that need not change.
constexpr double smallest_cost = 1e-6;
/// Rounding of the linear conditions.
constexpr double condition_tolerance = 1e-10;
/// One program looks for conditions at most this often; it needs about as many as there are free values.
constexpr int max_searches = 400;

/// One step of the descent: the program in which every limit is linear, about `here`.
class Programme {
 public:
  struct Region {
    double unit = 1, radius = 1;
  };

  Programme(QuadraticProgram start, const MotionSamples& samples, std::span<const Allowance> allowances,
            std::span<const double> here, const Region& region)
      : programme_(std::move(start)),
        samples_(samples),
        allowances_(allowances),
        here_(here),
        region_(region),
        row_(here.size() + 1) {}

  /// False if rounding leaves no solution.
  bool solve() {
    row_.back() = 1;
    if (!programme_.add(row_, 0)) return false;
    // There are thousands of limits, of which few are active. Each round adds only those that are broken
    // most.
    for (int i = 0; i < max_searches; ++i) {
      bool added = false;
      if (!add_box(added) || !add_limits(added)) return false;
      if (!added) break;
    }
    return true;
  }
  [[nodiscard]] std::span<const double> values() const { return programme_.x().first(here_.size()); }
  [[nodiscard]] double slack() const { return std::max(programme_.x().back(), 0.0); }

 private:
  struct Breach {
    double size = condition_tolerance;
    const Moment* moment = nullptr;
    const LimitedValue* value = nullptr;
    double sign = 1;
  };

  /// The control values stay in 0..100 and in the trust region.
  bool add_box(bool& added) {
    for (std::size_t i = 0; i < here_.size(); ++i) {
      const double here = here_[i] / region_.unit;
      const double low = std::max(0.0, here - region_.radius);
      const double high = std::min(largest_control_value / region_.unit, here + region_.radius);
      const double x = programme_.x()[i];
      const bool is_low = x < low - condition_tolerance;
      if (!is_low && !(x > high + condition_tolerance)) continue;
      std::ranges::fill(row_, 0.0);
      row_[i] = is_low ? 1 : -1;
      if (!programme_.add(row_, is_low ? low : -high)) return false;
      added = true;
    }
    return true;
  }

  /// Adds, for every limit, the moment at which it is exceeded most.
  bool add_limits(bool& added) {
    std::vector<double> difference;
    for (std::size_t i = 0; i < here_.size(); ++i) {
      difference.push_back(programme_.x()[i] * region_.unit - here_[i]);
    }
    const ControlCurve change(difference, samples_.ends());
    std::vector<Breach> worst(allowances_.size() * limited_quantities);
    for (const Moment& moment : samples_.moments()) {
      if (!moment.is_linearized_here) continue;
      const CurveValues by = change.at(moment.place);
      for (std::size_t k = moment.first; k < moment.end; ++k) {
        const LimitedValue& value = samples_.values()[k];
        const CurveWeights& w = value.weights;
        const double share =
            value.share + w.area * by.area + w.value * by.value + w.first * by.first + w.second * by.second;
        const auto quantity = static_cast<std::size_t>(value.quantity);
        const double size = std::fabs(share) / allowances_[value.axis][quantity] - 1 - slack();
        Breach& breach = worst[value.axis * limited_quantities + quantity];
        if (size > breach.size) breach = {size, &moment, &value, share > 0 ? 1.0 : -1.0};
      }
    }
    for (const Breach& breach : worst) {
      if (breach.moment == nullptr) continue;
      added = true;
      if (!add(breach)) return false;
    }
    return true;
  }

  bool add(const Breach& breach) {
    const LimitedValue& value = *breach.value;
    const double allowance = allowances_[value.axis][static_cast<std::size_t>(value.quantity)];
    const double scale = -breach.sign * region_.unit / allowance;
    const CurveWeights weights{value.weights.area * scale, value.weights.value * scale,
                               value.weights.first * scale, value.weights.second * scale};
    std::ranges::fill(row_, 0.0);
    const std::span<double> row = std::span(row_).first(here_.size());
    add_row(breach.moment->place, weights, row, samples_.ends());
    double at_here = 0;
    for (std::size_t i = 0; i < here_.size(); ++i) at_here += row[i] * here_[i] / region_.unit;
    row_.back() = 1;
    return programme_.add(row_, breach.sign * value.share / allowance - 1 + at_here);
  }

  QuadraticProgram programme_;
  const MotionSamples& samples_;
  std::span<const Allowance> allowances_;
  std::span<const double> here_;
  Region region_;
  std::vector<double> row_;
};

}  // namespace

SpeedDescent::SpeedDescent(const CurveFrame& frame)
    : frame_(frame), unit_(ControlCurve(frame.wanted, frame.ends).mean()) {
  static_cast<void>(programme(frame_.wanted, first_price));
}

QuadraticProgram SpeedDescent::programme(std::span<const double> target, double price) const {
  const std::size_t count = frame_.wanted.size();
  const std::size_t n = count + 1;
  const std::vector<double> gram = gram_matrix(count, frame_.ends);
  std::vector<double> matrix(n * n);
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t k = 0; k < count; ++k) {
      matrix[i * n + k] = gram[i * count + k] / static_cast<double>(count - 1);
    }
  }
  // The last variable is the slack, the excess that the penalty allows.
  matrix.back() = quadratic_share * price;
  std::vector<double> goal;
  for (const double value : target) goal.push_back(value / unit_);
  goal.push_back(-1 / (2 * quadratic_share));
  QuadraticProgram programme(matrix, goal);
  std::vector<double> row(n);
  const auto demand = [&](double bound) {
    if (!programme.add_equality(row, bound))
      throw std::invalid_argument("the areas of the speed curve contradict its rests");
    std::ranges::fill(row, 0.0);
  };
  for (std::size_t i = 0; i < count; ++i) {
    if (!frame_.rests[i]) continue;
    row[i] = 1;
    demand(0);
  }
  if (frame_.ends == CurveEnds::periodic) {
    row[0] = 1;
    row[count - 1] = -1;
    demand(0);
  }
  const ControlCurve wanted(frame_.wanted, frame_.ends);
  CurvePlace<double> before;
  // Differences of neighbouring areas are independent of each other; the areas themselves would nearly not
  // be.
  for (const double a : frame_.fixed_areas) {
    const CurvePlace<double> place = place_at(a, count - 1);
    add_row(place, {.area = 1}, std::span(row).first(count), frame_.ends);
    add_row(before, {.area = -1}, std::span(row).first(count), frame_.ends);
    demand((wanted.at(place).area - wanted.at(before).area) / unit_);
    before = place;
  }
  return programme;
}

/// Removes the rounding from control values: rests are 0 again, no value leaves 0..100, and a periodic curve
/// ends on its first value.
std::vector<double> SpeedDescent::valid(std::span<const double> x) const {
  std::vector<double> values;
  for (std::size_t i = 0; i < frame_.wanted.size(); ++i) {
    const double value = frame_.rests[i] || x[i] < condition_tolerance ? 0 : x[i] * unit_;
    values.push_back(std::min<double>(value, largest_control_value));
  }
  if (frame_.ends == CurveEnds::periodic) values.back() = values.front();
  return values;
}

std::vector<double> SpeedDescent::nearest(std::span<const double> values) const {
  const std::size_t count = values.size();
  QuadraticProgram nearest = programme(values, first_price);
  std::vector<double> row(count + 1);
  const double high = largest_control_value / unit_;
  for (bool added = true; added;) {
    added = false;
    for (std::size_t i = 0; i < count; ++i) {
      const double x = nearest.x()[i];
      if (frame_.rests[i] || (x >= -condition_tolerance && x <= high + condition_tolerance)) continue;
      std::ranges::fill(row, 0.0);
      row[i] = x < 0 ? 1 : -1;
      if (!nearest.add(row, x < 0 ? 0 : -high)) throw std::invalid_argument("no speed curve from 0 to 100");
      added = true;
    }
  }
  return valid(nearest.x());
}

double SpeedDescent::change_squared(std::span<const double> values) const {
  std::vector<double> difference;
  for (std::size_t i = 0; i < values.size(); ++i)
    difference.push_back((values[i] - frame_.wanted[i]) / unit_);
  return mean_square(difference, frame_.ends);
}

Descent SpeedDescent::run(std::span<const double> start, MotionSamples& samples,
                          std::span<const Allowance> allowances) const {
  double price = first_price;
  double radius = first_radius;
  QuadraticProgram prototype = programme(frame_.wanted, price);
  Descent here = at({start.begin(), start.end()}, samples, allowances);
  const auto cost = [&](const Descent& descent) {
    return descent.change * descent.change + price * std::max(descent.excess.share, 0.0);
  };
  for (int step = 0; step < max_steps && radius > min_radius; ++step) {
    Programme linear(prototype, samples, allowances, here.values, {unit_, radius});
    if (!linear.solve()) {
      radius /= 4;
      continue;
    }
    std::vector<double> values = valid(linear.values());
    const double promised = cost(here) - change_squared(values) - price * linear.slack();
    // Nothing is left to gain at this price. If a limit is still exceeded, the price was too low.
    if (promised <= min_gain * (cost(here) + smallest_cost)) {
      if (here.excess.share <= descent_tolerance || price >= highest_price) break;
      price *= price_factor;
      radius = std::max(radius, first_radius / 10);
      prototype = programme(frame_.wanted, price);
      continue;
    }
    double length = 0;
    for (std::size_t i = 0; i < values.size(); ++i) {
      length = std::max(length, std::fabs(values[i] - here.values[i]) / unit_);
    }
    Descent next = at(std::move(values), samples, allowances);
    const double gained = cost(here) - cost(next);
    // The usual rule of trust regions: shrink after a poor step, grow after a good one.
    if (gained < promised / 4) radius = std::min(radius, length) / 3;
    if (gained > 3 * promised / 4) radius = std::max(radius, 2 * length);
    if (gained > promised / 100) {
      here = std::move(next);
    } else {
      // The step is rejected, so the samples must go back to the curve that stays.
      samples.evaluate(ControlCurve(here.values, frame_.ends));
    }
  }
  return here;
}

Descent SpeedDescent::at(std::vector<double> values, MotionSamples& samples,
                         std::span<const Allowance> allowances) const {
  samples.evaluate(ControlCurve(values, frame_.ends));
  const double change = std::sqrt(change_squared(values));
  return {.values = std::move(values), .excess = samples.worst(allowances), .change = change};
}

}  // namespace inbetween
