#include "host_tools/fit/speed_constraints.hpp"

#include <algorithm>
#include <cmath>

namespace inbetween {
namespace {

constexpr std::array<LimitedQuantity, 3> rates = {LimitedQuantity::velocity, LimitedQuantity::acceleration,
                                                  LimitedQuantity::jerk};
/// A span of the curve has this many moments, or fewer if the curve would have more than max_curve_moments.
/// What they miss between them is in the margin that is measured, and a peak that check() finds becomes a
/// moment. Fewer cost trials; the time of a step grows with them.
constexpr double moments_per_span = 24;
/// 66 spans have moments_per_span.
constexpr double max_curve_moments = 1600;
/// Never fewer: a span is a cubic, whose speed has two extremes and whose acceleration one.
/// SpeedFit.OfHundredsOfValuesIsFound has spans with so few.
constexpr double min_moments_per_span = 8;
/// A segment of the path has this many moments, and more where the direction turns by turn_between_moments
/// between two of them.
constexpr int moments_per_segment = 10;
/// In rad: between two such moments the share of an axis in the speed is missed by 0.05^2 / 8, which is 0.03
/// % and a twentieth of first_margin.
constexpr double turn_between_moments = 0.05;
/// A cusp turns within any stretch: the halvings end where the two moments beside it are 1 / 40 960 of the
/// segment apart.
constexpr int max_turn_halvings = 12;
/// As a share of the mean of the curve. The rig counts as standing below this speed, where a moment that
/// stays on the path has no derivative. At a larger one a moment that matters would be left out.
constexpr double standing_share = 1e-4;

std::size_t index_of(LimitedQuantity quantity) {
  return static_cast<std::size_t>(quantity);
}

/// 0 where there is none.
double limit_of(const RigAxis& axis, LimitedQuantity quantity) {
  switch (quantity) {
    case LimitedQuantity::velocity:
      return axis.max_velocity;
    case LimitedQuantity::acceleration:
      return axis.max_acceleration;
    case LimitedQuantity::jerk:
      return axis.max_jerk.value_or(0);
    case LimitedQuantity::acceleration_step:
      return axis.max_jerk ? axis.max_acceleration_step.value_or(0) : 0;
  }
  return 0;
}

/// A rate of an axis and its derivatives by L at a fixed speed, and by the speed and its derivatives.
struct Rate {
  double value = 0, by_distance = 0, by_speed = 0, by_speed_1 = 0, by_speed_2 = 0;
};

Rate rate_of(LimitedQuantity quantity, const std::array<double, 4>& turn, const std::array<double, 3>& w) {
  const auto& [t0, t1, t2, t3] = turn;
  const auto& [w0, w1, w2] = w;
  switch (quantity) {
    case LimitedQuantity::velocity:
      return {t0 * w0, t1 * w0, t0, 0, 0};
    case LimitedQuantity::acceleration:
      return {t1 * w0 * w0 + t0 * w1, t2 * w0 * w0 + t1 * w1, 2 * t1 * w0, t0, 0};
    default:
      return {w0 * (t2 * w0 * w0 + 3 * t1 * w1) + t0 * w2, w0 * (t3 * w0 * w0 + 3 * t2 * w1) + t1 * w2,
              3 * (t2 * w0 * w0 + t1 * w1), 3 * t1 * w0, t0};
  }
}

}  // namespace

/// The speed along the path at one place of the curve.
struct MotionSamples::Pace {
  CurvePlace place;
  CurveValues curve;
  double constant = 0;         ///< K
  std::array<double, 3> w{};   ///< along the path and its derivatives in time
  std::array<double, 3> by{};  ///< of them by phi and its derivatives
};

/// A place of the curve whose area, value and slope are known.
struct MotionSamples::KnownPlace {
  CurvePlace place;
  double area = 0, value = 0, first = 0;

  /// About where Phi is a little more or less: by Taylor's series of its inverse.
  [[nodiscard]] CurvePlace place_near(double wanted_area) const {
    const double step = (wanted_area - area) / value;
    return {place.span, place.t + step * (1 - step * first / (2 * value))};
  }
};

MotionSamples::MotionSamples(const Track& track, std::span<const RigAxis> axes, int refinements,
                             EndSteps steps, CurveEnds ends)
    : track_(track),
      axes_(axes),
      steps_(steps),
      ends_(ends),
      factor_(std::ldexp(1, refinements)),
      per_span_(track.curve_rate() * factor_),
      spans_(track.profile().span_count() * factor_),
      standing_(standing_share * track.profile().total_integral() / track.profile().span_count()) {
  find_stretches();
  const double in_span =
      std::round(std::clamp(max_curve_moments / spans_, min_moments_per_span, moments_per_span));
  const auto count = static_cast<int>(in_span * spans_);
  for (int i = 0; i <= count; ++i) curve_moments_.push_back(i / in_span);
  const std::int32_t segments = track.path().segment_count();
  for (std::int32_t i = 0; i < segments; ++i) sample_segment(i);
  for (std::int32_t i = 1; i < segments; ++i) add_key_steps(i);
}

void MotionSamples::add_moment(double frame, const ControlCurve& curve) {
  const double a = std::clamp(frame / track_.frames(), 0.0, 1.0) * spans_;
  curve_moments_.push_back(a);
  const Stretch& stretch = stretch_at(a);
  const double distance = stretch.offset + stretch.constant * curve.at(place_at(a, curve.span_count())).area;
  const PathPoint point = track_.arc_length().locate({distance, 0});
  if (point.segment < track_.path().segment_count()) add_path_moment(point.segment, point.t);
}

/// The stretch that Phi at a belongs to. A place where two stretches meet belongs to the later one.
const MotionSamples::Stretch& MotionSamples::stretch_at(double a) const {
  const auto next = std::ranges::upper_bound(stretches_, a, {}, &Stretch::begin);
  return next == stretches_.begin() ? *next : *(next - 1);
}

void MotionSamples::sample_segment(std::int32_t segment) {
  const ArcLength& lengths = track_.arc_length();
  if (!(lengths.segment_begin(segment + 1).minus(lengths.segment_begin(segment)) > 0)) return;
  add_path_moment(segment, 0);
  for (int i = 0; i < moments_per_segment; ++i) {
    const double begin = static_cast<double>(i) / moments_per_segment;
    const double end = static_cast<double>(i + 1) / moments_per_segment;
    add_turning(segment, begin, end, 0);
    add_path_moment(segment, end);
  }
}

void MotionSamples::add_turning(std::int32_t segment, double begin, double end, int depth) {
  PathTurns before;
  PathTurns after;
  if (!before.find(track_.path(), {segment, begin}) || !after.find(track_.path(), {segment, end})) return;
  double angle = 0;
  for (std::size_t d = 0; d < before.axes.size(); ++d) {
    angle = std::hypot(angle, track_.path().weights()[d] * (after.axes[d][0] - before.axes[d][0]));
  }
  // A cusp turns within any stretch, so the depth bounds the halvings.
  if (angle <= turn_between_moments || depth >= max_turn_halvings) return;
  const double middle = begin + (end - begin) / 2;
  add_turning(segment, begin, middle, depth + 1);
  add_path_moment(segment, middle);
  add_turning(segment, middle, end, depth + 1);
}

void MotionSamples::add_path_moment(std::int32_t segment, double t) {
  PathMoment moment;
  if (!moment.turns.find(track_.path(), {segment, t})) return;
  const ArcLength& lengths = track_.arc_length();
  moment.is_key = t == 0 || t == 1;
  const TwoSum distance = moment.is_key ? lengths.segment_begin(t == 0 ? segment : segment + 1)
                                        : lengths.distance(track_.path(), {segment, t});
  moment.distance = distance.high + distance.low;
  path_moments_.push_back(moment);
}

/// Adds the step of T' at a key between two segments that have a length.
void MotionSamples::add_key_steps(std::int32_t key) {
  PathTurns before;
  PathTurns after;
  if (!before.find(track_.path(), {key - 1, 1}) || !after.find(track_.path(), {key, 0})) return;
  const TwoSum& distance = track_.arc_length().segment_begin(key);
  PathMoment moment;
  moment.distance = distance.high + distance.low;
  moment.is_key = true;
  for (std::size_t d = 0; d < axes_.size(); ++d) {
    moment.turn_steps.push_back(after.axes[d][1] - before.axes[d][1]);
  }
  path_moments_.push_back(moment);
}

void MotionSamples::find_stretches() {
  if (track_.portions().empty()) {
    stretches_.push_back({.constant = track_.constant() / factor_});
    return;
  }
  for (const Portion& portion : track_.portions()) {
    const double drawn =
        static_cast<double>(portion.begin_frame) * track_.profile().span_count() / track_.frames();
    const double offset = portion.offset.high + portion.offset.low;
    stretches_.push_back({.begin = drawn * factor_,
                          .begin_distance = offset + portion.constant * track_.profile().integral(drawn),
                          .constant = portion.constant / factor_,
                          .offset = offset});
  }
}

MotionSamples::Pace MotionSamples::pace(const ControlCurve& curve, const CurvePlace& place,
                                        const Stretch& stretch) const {
  const CurveValues values = curve.at(place);
  const double by_0 = stretch.constant * per_span_;
  const double by_1 = by_0 * per_span_;
  const double by_2 = by_1 * per_span_;
  return {.place = place,
          .curve = values,
          .constant = stretch.constant,
          .w = {by_0 * values.value, by_1 * values.first, by_2 * values.second},
          .by = {by_0, by_1, by_2}};
}

void MotionSamples::add_values(const Pace& pace, const PathMoment& moment, bool stays_on_path) {
  for (std::size_t d = 0; d < axes_.size(); ++d) {
    for (const LimitedQuantity quantity : rates) {
      const double limit = limit_of(axes_[d], quantity);
      if (limit == 0) continue;
      const Rate rate = rate_of(quantity, moment.turns.axes[d], pace.w);
      CurveWeights by{.area = rate.by_distance * pace.constant,
                      .value = rate.by_speed * pace.by[0],
                      .first = rate.by_speed_1 * pace.by[1],
                      .second = rate.by_speed_2 * pace.by[2]};
      // The moment keeps its place on the path while the curve changes: its place on the curve moves by -dPhi
      // / phi.
      if (stays_on_path) {
        const CurveValues& curve = pace.curve;
        by.area = -(by.value * curve.first + by.first * curve.second + by.second * curve.third) / curve.value;
      }
      values_.push_back(
          {.axis = static_cast<std::uint32_t>(d),
           .quantity = quantity,
           .share = rate.value / limit,
           .weights = {by.area / limit, by.value / limit, by.first / limit, by.second / limit}});
    }
  }
}

/// Adds the step of the acceleration at a key.
void MotionSamples::add_step(const Pace& pace, const PathMoment& moment) {
  for (std::size_t d = 0; d < axes_.size(); ++d) {
    const double limit = limit_of(axes_[d], LimitedQuantity::acceleration_step);
    if (limit == 0) continue;
    const double step = moment.turn_steps[d] * pace.w[0] / limit;
    const double by = 2 * step * pace.by[0];
    values_.push_back({.axis = static_cast<std::uint32_t>(d),
                       .quantity = LimitedQuantity::acceleration_step,
                       .share = step * pace.w[0],
                       .weights = {.area = -by * pace.curve.first / pace.curve.value, .value = by}});
  }
}

/// Adds the steps of the acceleration at an end of the move, from `first` on: outside the move the rig rests.
void MotionSamples::add_end_step(std::size_t first) {
  for (std::size_t i = first, end = values_.size(); i < end; ++i) {
    LimitedValue step = values_[i];
    const RigAxis& axis = axes_[step.axis];
    const double limit = limit_of(axis, LimitedQuantity::acceleration_step);
    if (step.quantity != LimitedQuantity::acceleration || limit == 0) continue;
    const double ratio = axis.max_acceleration / limit;
    step.quantity = LimitedQuantity::acceleration_step;
    step.share *= ratio;
    step.weights = {step.weights.area * ratio, step.weights.value * ratio, step.weights.first * ratio, 0};
    values_.push_back(step);
  }
}

void MotionSamples::evaluate_curve_moment(const ControlCurve& curve, double a) {
  const Stretch& stretch = stretch_at(a);
  const Pace at = pace(curve, place_at(a, curve.span_count()), stretch);
  PathMoment moment;
  const double distance = stretch.offset + at.constant * at.curve.area;
  if (!moment.turns.find(track_.path(), track_.arc_length().locate({distance, 0}))) return;
  const std::size_t first = values_.size();
  add_values(at, moment, false);
  if ((steps_.begin && a <= 0) || (steps_.end && a >= spans_)) add_end_step(first);
  moments_.push_back({.place = at.place,
                      .first = first,
                      .end = values_.size(),
                      .is_linearized_here = moment.turns.scale > at.constant * at.curve.value / 4});
}

void MotionSamples::evaluate_path_moment(const ControlCurve& curve, const PathMoment& moment,
                                         KnownPlace& near) {
  const auto next = std::ranges::upper_bound(stretches_, moment.distance, {}, &Stretch::begin_distance);
  const Stretch& stretch = next == stretches_.begin() ? *next : *(next - 1);
  const double area = (moment.distance - stretch.offset) / stretch.constant;
  const Pace at = pace(curve, curve.place_of_area(area, near.place_near(area)), stretch);
  near = {at.place, at.curve.area, at.curve.value, at.curve.first};
  if (!(at.curve.value > standing_)) return;
  const std::size_t first = values_.size();
  if (moment.turn_steps.empty()) {
    add_values(at, moment, true);
  } else {
    add_step(at, moment);
  }
  moments_.push_back(
      {.place = at.place,
       .first = first,
       .end = values_.size(),
       .is_linearized_here = moment.is_key || moment.turns.scale < 2 * at.constant * at.curve.value});
}

void MotionSamples::evaluate(const ControlCurve& curve) {
  moments_.clear();
  values_.clear();
  for (const double a : curve_moments_) evaluate_curve_moment(curve, a);
  KnownPlace near;
  for (const PathMoment& moment : path_moments_) evaluate_path_moment(curve, moment, near);
}

Excess MotionSamples::worst(std::span<const Allowance> allowances) const {
  Excess worst;
  for (const Moment& moment : moments_) {
    if (!moment.is_linearized_here) continue;
    for (std::size_t i = moment.first; i < moment.end; ++i) {
      const LimitedValue& value = values_[i];
      const double excess = std::fabs(value.share) / allowances[value.axis][index_of(value.quantity)] - 1;
      if (!(excess <= worst.share)) worst = {excess, value.axis, value.quantity};
    }
  }
  return worst;
}

std::vector<Allowance> MotionSamples::peaks() const {
  std::vector<Allowance> peaks(axes_.size(), Allowance{});
  for (const LimitedValue& value : values_) {
    double& peak = peaks[value.axis][index_of(value.quantity)];
    peak = std::max(peak, std::fabs(value.share));
  }
  return peaks;
}

}  // namespace inbetween
