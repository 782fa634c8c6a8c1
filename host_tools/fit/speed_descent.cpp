#include "host_tools/fit/speed_descent.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <utility>

namespace inbetween {
namespace {

/// The price of an excess at first, beside a change that is the square of a share of the mean. A lower one
/// needs a second price more often; a higher one hides beside it what a step gains.
constexpr double first_price = 20;
/// The price rises by this if the excess does not go away: one step from first_price is beyond highest_price.
constexpr double price_factor = 1000;
/// None of 2000 random fits needed more: an excess that stays at this price is taken for one that no curve
/// nearby avoids.
constexpr double highest_price = 1e4;
/// The cost is linear in the excess, but for this share, which is quadratic because the method needs it
/// (BandProgram::allow_ease). A larger share lets a small excess stand.
constexpr double quadratic_share = 1e-3;
/// A radius that only shrinks, to a third or a quarter, is at min_radius after 15 steps; the others gain. The
/// bound is for gains that get smaller and smaller.
constexpr int max_steps = 80;
/// In means of the wanted curve, as min_radius is: half as much as a usual value has, for the limits are
/// linearized. It grows after a good step and shrinks after a poor one.
constexpr double first_radius = 0.5;
/// A tenth of descent_tolerance: a smaller step changes no verdict.
constexpr double min_radius = descent_tolerance / 10;
/// The last step is one that gains less than this share of the cost. It is a square: the change itself gains
/// half of it.
constexpr double min_gain = 1e-4;
/// This is added to the cost, so that the search ends at once for a curve that need not change: a thousandth
/// of the mean, squared.
constexpr double smallest_cost = 1e-6;
/// Rounding of the linear conditions, with values about 1. It is far less than descent_tolerance, by which a
/// limit may be exceeded.
constexpr double condition_tolerance = 1e-10;
/// As a share, and more than a product and a quotient differ by. With less a value that breaks its limit by
/// rounding might be passed over, with more some are divided in vain.
constexpr double comparison_rounding = 1e-14;
/// At first a step looks only at limits of which so much is used, and then at those that it broke: of
/// thousands few are active. With less the programs are larger, with more there are more looks.
constexpr double looked_at_share = 0.8;
/// Each look adds a limit at least that the step broke. A step that needs more looks than this is none, and a
/// shorter one is tried.
constexpr int max_looks = 30;
/// Many keys on few control values make a crowd of moments that say nearly the same. Where there are more
/// than so many moments, a look takes of each crowd the one that uses most of a limit: a fit with 10 000 keys
/// takes a fifth of the time. With fewer moments all are looked at.
constexpr std::size_t min_crowded_moments = 5000;
/// A crowd lies within this part of a span, which is less than the moments of the curve are apart
/// (moments_per_span).
constexpr double crowds_per_span = 64;
/// So many looks take the foremost of each crowd only. The later ones take all, so that nothing is left out.
constexpr int crowded_looks = 8;

/// One step of the descent: the limits as linear conditions, about the curve at which the samples are
/// evaluated.
class LinearLimits {
 public:
  LinearLimits(const MotionSamples& samples, std::span<const Allowance> allowances, const CurveSums& sums,
               std::span<const double> here, double unit)
      : samples_(samples),
        allowances_(allowances),
        sums_(sums),
        here_(here),
        unit_(unit),
        taken_(2 * samples.values().size()) {}

  /// Adds those of which a large share is used.
  void add_tight(BandProgram& program) {
    const std::vector<double> none(here_.size());
    add(none, looked_at_share - 1, is_crowded_, program);
  }
  /// Adds those that `values` would break by more than `slack`. Whether there are any.
  bool add_broken(std::span<const double> values, double slack, int look, BandProgram& program) {
    std::vector<double> difference;
    for (std::size_t i = 0; i < here_.size(); ++i) difference.push_back(values[i] - here_[i]);
    return add(difference, slack + condition_tolerance, is_crowded_ && look < crowded_looks, program);
  }

 private:
  /// The value of a crowd that is furthest beyond one limit.
  struct Foremost {
    double excess = 0;
    const Moment* moment = nullptr;
    std::size_t value = 0;
  };

  bool add(std::span<const double> difference, double excess, bool only_foremost, BandProgram& program) {
    const ControlCurve change(difference, samples_.ends());
    // Of the many values nearly all are far below: a product tells so more quickly than a quotient.
    std::vector<Allowance> least(allowances_.begin(), allowances_.end());
    for (Allowance& allowance : least) {
      for (double& value : allowance) value *= (1 + excess) * (1 - comparison_rounding);
    }
    std::vector<Foremost> crowd(2 * limited_quantities * allowances_.size());
    std::vector<std::size_t> met;  // of the crowd
    std::int64_t crowd_begin = -1;
    bool added = false;
    const auto take_foremost = [&] {
      for (const std::size_t i : met) {
        const bool is_above = i % 2 != 0;
        const LimitedValue& value = samples_.values()[crowd[i].value];
        const double allowance = allowances_[value.axis][static_cast<std::size_t>(value.quantity)];
        taken_[2 * crowd[i].value + (is_above ? 1 : 0)] = true;
        add(*crowd[i].moment, value, (is_above ? -1 : 1) / allowance, program);
        crowd[i] = {};
        added = true;
      }
      met.clear();
    };
    for (const Moment& moment : samples_.moments()) {
      if (!moment.is_linearized_here) continue;
      const auto begin =
          static_cast<std::int64_t>((moment.place.span + moment.place.t) * crowds_per_span);  // not below 0
      if (!only_foremost || begin != crowd_begin) take_foremost();
      crowd_begin = begin;
      const CurveValues by = change.at(moment.place);
      for (std::size_t k = moment.first; k < moment.end; ++k) {
        const LimitedValue& value = samples_.values()[k];
        const CurveWeights& w = value.weights;
        const double share =
            value.share + w.area * by.area + w.value * by.value + w.first * by.first + w.second * by.second;
        const auto quantity = static_cast<std::size_t>(value.quantity);
        if (std::fabs(share) < least[value.axis][quantity]) continue;
        const double beyond = std::fabs(share) / allowances_[value.axis][quantity] - 1;
        const std::size_t is_above = share > 0 ? 1 : 0;
        if (!(beyond > excess) || taken_[2 * k + is_above]) continue;
        const std::size_t limit = 2 * (value.axis * limited_quantities + quantity) + is_above;
        if (crowd[limit].moment == nullptr) met.push_back(limit);
        if (crowd[limit].moment == nullptr || beyond > crowd[limit].excess)
          crowd[limit] = {beyond, &moment, k};
      }
    }
    take_foremost();
    return added;
  }

  /// The share at the new curve, times `scale`, is to be -1 or more.
  void add(const Moment& moment, const LimitedValue& value, double scale, BandProgram& program) const {
    const CurveWeights& w = value.weights;
    const CurveSums::Terms terms = sums_.at(
        moment.place,
        {w.area * scale * unit_, w.value * scale * unit_, w.first * scale * unit_, w.second * scale * unit_});
    const CurveValues at = here_curve_.at(moment.place);
    const double at_here = w.area * at.area + w.value * at.value + w.first * at.first + w.second * at.second;
    program.demand_at_least(terms, -1 - scale * (value.share - at_here), true);
  }

  const MotionSamples& samples_;
  std::span<const Allowance> allowances_;
  const CurveSums& sums_;
  std::span<const double> here_;
  ControlCurve here_curve_{here_, samples_.ends()};
  double unit_;
  bool is_crowded_ = samples_.moments().size() > min_crowded_moments;
  std::vector<bool> taken_;  ///< whether the lower and the upper limit of every value is a condition
};

/// The control values stay in 0..100, and within `radius` of `here`.
void demand_box(const CurveSums& sums, std::span<const double> here, double unit, double radius,
                BandProgram& program) {
  for (std::size_t i = 0; i < here.size(); ++i) {
    CurveSums::Terms value = sums.value(i);
    if (value.empty()) continue;
    program.demand_at_least(value, std::max(0.0, here[i] / unit - radius));
    for (Term& term : value) term.weight = -term.weight;
    program.demand_at_least(value, -std::min(largest_control_value / unit, here[i] / unit + radius));
  }
}

}  // namespace

SpeedDescent::SpeedDescent(const CurveFrame& frame)
    : frame_(frame),
      sums_(frame.rests, frame.ends),
      unit_(ControlCurve(frame.wanted, frame.ends).mean()),
      distance_(programme(frame_.wanted)) {}

BandProgram SpeedDescent::programme(std::span<const double> target) const {
  BandProgram program(sums_.unknown_count());
  const std::size_t spans = frame_.wanted.size() - 1;
  sums_.add_distance(in_units(target), 2 / static_cast<double>(spans), program);
  sums_.demand_ends(program);
  sums_.demand_start(program);
  const ControlCurve wanted(frame_.wanted, frame_.ends);
  CurveSums::Terms before = sums_.at({}, {.area = 1});
  double area_before = 0;
  for (const double a : frame_.fixed_areas) {
    const CurvePlace place = place_at(a, spans);
    const CurveSums::Terms terms = sums_.at(place, {.area = 1});
    const double area = wanted.at(place).area / unit_;
    // Between the two the curve rests: the area is the same.
    const bool is_same = std::ranges::equal(terms, before, [](const Term& one, const Term& other) {
      return one.unknown == other.unknown && one.weight == other.weight;
    });
    if (!is_same) {
      program.demand(terms, area);
    } else if (std::fabs(area - area_before) > condition_tolerance * (1 + area)) {
      throw std::invalid_argument("the areas of the speed curve contradict its rests");
    }
    before = terms;
    area_before = area;
  }
  return program;
}

std::vector<double> SpeedDescent::in_units(std::span<const double> values) const {
  std::vector<double> result;
  for (const double value : values) result.push_back(value / unit_);
  return result;
}

/// Removes the rounding from control values: rests are 0 again, no value leaves 0..100, and a periodic curve
/// ends on its first value.
std::vector<double> SpeedDescent::values_of(const BandProgram& program) const {
  std::vector<double> values;
  for (std::size_t i = 0; i < frame_.wanted.size(); ++i) {
    const double x = program.value(sums_.value(i));
    values.push_back(x < condition_tolerance ? 0 : std::min<double>(x * unit_, largest_control_value));
  }
  if (frame_.ends == CurveEnds::periodic) values.back() = values.front();
  return values;
}

std::vector<double> SpeedDescent::nearest(std::span<const double> values) const {
  BandProgram program = programme(values);
  demand_box(sums_, values, unit_, std::numeric_limits<double>::infinity(), program);
  if (!program.solve(sums_.unknowns(in_units(values)))) {
    throw std::invalid_argument("no speed curve from 0 to 100");
  }
  return values_of(program);
}

/// The largest difference of two control values, in units.
double SpeedDescent::distance_of(std::span<const double> one, std::span<const double> other) const {
  double distance = 0;
  for (std::size_t i = 0; i < one.size(); ++i) {
    distance = std::max(distance, std::fabs(one[i] - other[i]) / unit_);
  }
  return distance;
}

double SpeedDescent::change_squared(std::span<const double> values) const {
  std::vector<double> difference;
  for (std::size_t i = 0; i < values.size(); ++i)
    difference.push_back((values[i] - frame_.wanted[i]) / unit_);
  return mean_square(difference, frame_.ends);
}

std::optional<SpeedDescent::Step> SpeedDescent::step_from(const Descent& here, const MotionSamples& samples,
                                                          const Region& region) const {
  BandProgram program = distance_;
  program.allow_ease(region.price, 2 * quadratic_share * region.price);
  demand_box(sums_, here.values, unit_, region.radius, program);
  LinearLimits limits(samples, region.allowances, sums_, here.values, unit_);
  limits.add_tight(program);
  const std::vector<double> start = sums_.unknowns(in_units(here.values));
  for (int look = 0; look < max_looks; ++look) {
    if (!program.solve(start)) return std::nullopt;
    Step step{values_of(program), program.ease()};
    if (!limits.add_broken(step.values, step.ease, look, program)) return step;
  }
  return std::nullopt;
}

Descent SpeedDescent::run(std::span<const double> start, MotionSamples& samples,
                          std::span<const Allowance> allowances, const std::function<bool()>& is_over) const {
  Region region{.allowances = allowances, .price = first_price, .radius = first_radius};
  Descent here = at({start.begin(), start.end()}, samples, allowances);
  // An excess that nobody minds costs nothing: with the price it would hide what a step gains.
  const auto priced = [&](double excess) {
    return region.price * std::max(excess - descent_tolerance / 2, 0.0);
  };
  const auto cost = [&](const Descent& descent) {
    return descent.change * descent.change + priced(descent.excess.share);
  };
  // The limits are curved, and a step along their tangent leaves them. The step from there leads back to
  // them, and so a poor step is judged with the next one (Chamberlain et al. 1982, The watchdog technique).
  struct Trial {
    Descent from, fallback;
    double promised = 0;
  };
  std::optional<Trial> trial;
  const auto give_trial_up = [&] {
    here = std::move(trial->fallback);
    trial.reset();
    samples.evaluate(ControlCurve(here.values, frame_.ends));
  };
  for (int i = 0; i < max_steps && region.radius > min_radius && !(is_over && is_over()); ++i) {
    std::optional<Step> step = step_from(here, samples, region);
    const double promised = step ? cost(here) - change_squared(step->values) - priced(step->ease) : 0;
    const bool is_at_end = promised <= min_gain * (cost(here) + smallest_cost);
    if (trial && is_at_end) {
      give_trial_up();
    } else if (!step) {
      region.radius /= 4;
    } else if (is_at_end) {
      // Nothing is left to gain at this price. If a limit is still exceeded, the price was too low.
      if (here.excess.share <= descent_tolerance || region.price >= highest_price) break;
      region.price *= price_factor;
      region.radius = std::max(region.radius, first_radius / 10);
    } else {
      const double length = distance_of(step->values, here.values);
      Descent next = at(std::move(step->values), samples, allowances);
      const double gained = cost(trial ? trial->from : here) - cost(next);
      const double wanted = trial ? trial->promised : promised;
      if (gained > wanted / 4) {
        // The usual rule of trust regions: grow after a good step, shrink after a poor one.
        if (!trial && gained > 3 * wanted / 4) region.radius = std::max(region.radius, 2 * length);
        here = std::move(next);
        trial.reset();
      } else if (!trial) {
        region.radius = std::min(region.radius, length) / 3;
        trial = Trial{.from = here, .fallback = gained > wanted / 100 ? next : here, .promised = promised};
        here = std::move(next);
      } else {
        give_trial_up();
      }
    }
  }
  if (trial) give_trial_up();
  return here;
}

Descent SpeedDescent::at(std::vector<double> values, MotionSamples& samples,
                         std::span<const Allowance> allowances) const {
  samples.evaluate(ControlCurve(values, frame_.ends));
  const double change = std::sqrt(change_squared(values));
  return {.values = std::move(values), .excess = samples.worst(allowances), .change = change};
}

}  // namespace inbetween
