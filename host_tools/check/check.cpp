#include "host_tools/check/check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <utility>

#include "host_tools/check/planned_stops.hpp"
#include "inbetween/limits/motion_steps.hpp"

namespace inbetween {
namespace {

constexpr std::string_view turn_remedy =
    "let the speed touch 0 there with corners = \"ease\", or move a key so that the path goes round";

/// Nothing is refined that is further from its limit than this share of it.
constexpr double slack_share = 1e-6;

CheckedAxis axis_at_rest(const RigAxis& axis) {
  return {.name = axis.name,
          .unit = std::string(to_string(axis.unit)),
          .range = std::nullopt,
          .limit_min = axis.min,
          .limit_max = axis.max,
          .velocity = {.limit = axis.max_velocity},
          .acceleration = {.limit = axis.max_acceleration},
          .jerk = {.limit = axis.max_jerk}};
}

/// The axes of one track, as indexes into those of the rig.
std::vector<std::size_t> axes_of_track(const Plan& plan, std::size_t track) {
  std::vector<std::size_t> axes(plan.move().tracks[track].axes.size());
  for (std::size_t a = 0; a < plan.axes().size(); ++a) {
    if (plan.axes()[a].track == track) axes[plan.axes()[a].track_axis] = a;
  }
  return axes;
}

/// The larger of two peaks; where they are equal, the first.
void raise(CheckedPeak& peak, const Peak<double>& found) {
  if (!(found.value > peak.value)) return;
  peak.value = found.value;
  peak.frame = found.frame;
}

void raise(CheckedAxis& axis, const AxisPeaks<double>& peaks) {
  if (!axis.range) axis.range = CheckedRange{peaks.lowest, peaks.highest};
  if (peaks.lowest.value < axis.range->lowest.value) axis.range->lowest = peaks.lowest;
  if (peaks.highest.value > axis.range->highest.value) axis.range->highest = peaks.highest;
  raise(axis.velocity, peaks.velocity);
  raise(axis.acceleration, peaks.acceleration);
  raise(axis.jerk, peaks.jerk);
}

void bound_track(const Plan& plan, std::size_t index, CheckReport& report) {
  const std::vector<std::size_t> axes = axes_of_track(plan, index);
  std::vector<PeakSlack<double>> slack;
  for (const std::size_t a : axes) {
    const RigAxis& axis = plan.rig()->axes[a];
    slack.push_back({.velocity = slack_share * axis.max_velocity,
                     .acceleration = slack_share * axis.max_acceleration,
                     .jerk = slack_share * axis.max_jerk.value_or(0)});
  }
  std::vector<AxisTurn<double>> turns(axes.size());
  std::vector<AxisPeaks<double>> peaks(axes.size());
  value_or_throw(bound_motion<double>(plan.tracks()[index].track(), slack, {turns}, peaks));
  for (std::size_t d = 0; d < axes.size(); ++d) raise(report.axes[axes[d]], peaks[d]);
}

void bound_rolls(const Plan& plan, CheckReport& report) {
  const MoveRolls<double>& rolls = plan.played().rolls();
  for (const std::span<const RollAxis<double>> roll : {rolls.before, rolls.after}) {
    for (std::size_t d = 0; d < roll.size(); ++d) raise(report.axes[plan.axis_of(d)], roll[d].peaks());
  }
}

/// 0 where it is no more than rounding.
double without_rounding(double step, const CheckedPeak& peak) {
  const double largest = std::max(std::isfinite(peak.value) ? peak.value : 0, peak.limit.value_or(0));
  return step > step_rounding * largest ? step : 0;
}

void add_steps(const std::vector<std::size_t>& axes, const std::vector<AxisStep<double>>& steps,
               std::optional<std::int32_t> key, double frame, CheckReport& report) {
  for (std::size_t d = 0; d < axes.size(); ++d) {
    const CheckedAxis& axis = report.axes[axes[d]];
    const CheckedStep step{.key = key,
                           .frame = frame,
                           .axis = axes[d],
                           .velocity = without_rounding(steps[d].velocity, axis.velocity),
                           .acceleration = without_rounding(steps[d].acceleration, axis.acceleration)};
    if (step.velocity > 0 || step.acceleration > 0) report.steps.push_back(step);
  }
}

/// At the ends a move that is moving meets its roll, or is refused because there is none. By the frame:
/// several keys may lie in one place there.
bool is_joined_by_roll(const Track<double>& track, double frame) {
  return (frame <= 0 && is_moving(track, RollEnd::before)) ||
         (frame >= track.frames() && is_moving(track, RollEnd::after));
}

void list_steps(const Plan& plan, std::size_t index, CheckReport& report) {
  const std::vector<std::size_t> axes = axes_of_track(plan, index);
  const Track<double>& track = plan.tracks()[index].track();
  const std::int32_t segments = track.path().segment_count();
  std::vector<AxisStep<double>> steps(axes.size());
  for (std::int32_t i = 0; i <= segments; ++i) {
    const double frame = steps_at_key<double>(track, i, steps);
    if (!is_joined_by_roll(track, frame)) add_steps(axes, steps, track.path().key_at(i), frame, report);
    if (i == segments) break;
    const Standstills<double> standstills = standstills_within(track, i);
    for (std::size_t k = 0; k < standstills.count; ++k) {
      const double turn = steps_at_standstill<double>(track, {i, standstills.t[k]}, steps);
      add_steps(axes, steps, std::nullopt, turn, report);
    }
  }
}

/// What is wrong with one axis, in words.
class AxisRefusals {
 public:
  AxisRefusals(const Plan& plan, std::size_t index, CheckReport& report)
      : move_(plan.move()),
        track_(plan.move().tracks[*plan.axes()[index].track]),
        place_(plan.place_of(index)),
        rig_(*plan.rig()),
        limits_(plan.rig()->axes[index]),
        index_(index),
        axis_(report.axes[index]),
        report_(report) {}

  void add_all() {
    add_position();
    add_velocity_step();
    add_acceleration_step();
    if (add_unbounded()) return;
    add_peak(axis_.velocity, "max_velocity", "/s");
    add_peak(axis_.acceleration, "max_acceleration", "/s^2");
    add_peak(axis_.jerk, "max_jerk", "/s^3");
  }

 private:
  void refuse(const Place& place, std::string message, bool slower_helps) {
    report_.refusals.push_back({place, std::move(message), slower_helps});
  }

  void add_position() {
    const Peak<double>& lowest = axis_.range->lowest;
    const Peak<double>& highest = axis_.range->highest;
    const double below = limits_.min - lowest.value;
    const double above = highest.value - limits_.max;
    if (below <= 0 && above <= 0) return;
    const Peak<double>& worst = below > above ? lowest : highest;
    refuse(
        place_,
        fmt::format("axis {} would go to {} {} at frame {:.2f}, outside {}..{} of the rig {}; move its keys "
                    "inward",
                    in_quotes(axis_.name), worst.value, axis_.unit, worst.frame, limits_.min, limits_.max,
                    in_quotes(rig_.name)),
        false);
  }

  /// Of the steps of this axis the largest, and how many there are beside it.
  struct LargestStep {
    const CheckedStep* step = nullptr;
    std::size_t others = 0;

    void take(const CheckedStep& next, double CheckedStep::*size) {
      if (step != nullptr) ++others;
      if (step == nullptr || next.*size > step->*size) step = &next;
    }
    [[nodiscard]] std::string where() const {
      std::string words = fmt::format("frame {:.2f}", step->frame);
      if (step->key) words = fmt::format("key {}, {}", *step->key, words);
      if (others > 0) words += fmt::format(", and at {} more place{}", others, others == 1 ? "" : "s");
      return words;
    }
  };

  void add_velocity_step() {
    LargestStep largest;
    for (const CheckedStep& step : report_.steps) {
      if (step.axis == index_ && step.velocity > 0) largest.take(step, &CheckedStep::velocity);
    }
    if (largest.step == nullptr) return;
    refuse(place_of(*largest.step),
           fmt::format("axis {} would step by {:.6g} {}/s at {}, which no drive can follow; {}",
                       in_quotes(axis_.name), largest.step->velocity, axis_.unit, largest.where(),
                       remedy_of(*largest.step)),
           false);
  }

  void add_acceleration_step() {
    LargestStep largest;
    for (const CheckedStep& step : report_.steps) {
      // Where the velocity steps, that has been said and cures both.
      const bool is_refused = step.velocity == 0 && breaks_jerk_limit(step, limits_);
      if (step.axis == index_ && is_refused) largest.take(step, &CheckedStep::acceleration);
    }
    if (largest.step == nullptr) return;
    const auto [step, most] = told_apart(largest.step->acceleration,
                                         limits_.max_acceleration_step.value_or(0), Digits::significant, 6);
    const std::string rule = limits_.max_acceleration_step ? "max_acceleration_step is " + most
                                                           : std::string("max_jerk allows no step");
    refuse(place_of(*largest.step),
           fmt::format("axis {} would step by {} {}/s^2 at {}, and {}; {}", in_quotes(axis_.name), step,
                       axis_.unit, largest.where(), rule, remedy_of(*largest.step)),
           limits_.max_acceleration_step.has_value());
  }

  /// Where something has no bound, whatever is above it has none either: it is said once.
  bool add_unbounded() {
    if (!std::isfinite(axis_.velocity.value)) {
      add_unbounded("a velocity", axis_.velocity, "stands still for the axes that have a weight");
    } else if (!std::isfinite(axis_.acceleration.value)) {
      add_unbounded("an acceleration", axis_.acceleration, "turns on the spot");
    } else if (!std::isfinite(axis_.jerk.value) && axis_.jerk.limit) {
      add_unbounded("a jerk", axis_.jerk, "turns on the spot");
    } else {
      return false;
    }
    return true;
  }
  void add_unbounded(std::string_view quantity, const CheckedPeak& peak, std::string_view what) {
    refuse(
        place_,
        fmt::format("axis {} would need {} without bound near frame {:.2f}, where the path {} and is passed "
                    "at a speed; {}",
                    in_quotes(axis_.name), quantity, peak.frame, what, turn_remedy),
        false);
  }

  void add_peak(const CheckedPeak& peak, std::string_view limit, std::string_view per) {
    if (!peak.is_exceeded()) return;
    const auto [value, most] = told_apart(peak.value, *peak.limit, Digits::significant, 6);
    refuse(place_,
           fmt::format("axis {} would reach {} {}{} at frame {:.2f}, and {} is {}; {}", in_quotes(axis_.name),
                       value, axis_.unit, per, peak.frame, limit, most,
                       track_.timing == Timing::speed
                           ? "give the move more frames, or draw a flatter speed curve there"
                           : "give the move more frames there"),
           true);
  }

  [[nodiscard]] static bool is_start(const CheckedStep& step) { return step.frame <= 0; }
  [[nodiscard]] bool is_end(const CheckedStep& step) const { return step.frame >= move_.frames; }
  [[nodiscard]] const MoveKey* key_of(const CheckedStep& step) const {
    return step.key ? &track_.keys[static_cast<std::size_t>(*step.key)] : nullptr;
  }

  [[nodiscard]] const Place& place_of(const CheckedStep& step) const {
    if (is_start(step) && !track_.speed_places.empty()) return track_.speed_places.front();
    if (is_end(step) && !track_.speed_places.empty()) return track_.speed_places.back();
    return step.key ? key_of(step)->place : place_;
  }
  [[nodiscard]] std::string remedy_of(const CheckedStep& step) const {
    if (track_.timing == Timing::frames && kinetic_of(track_) != MoveKinetic::pace) {
      if (track_.spline == Spline::linear) return "use spline = \"smooth\" and kinetic = \"curves\"";
      if (kinetic_of(track_) != MoveKinetic::curves) return "use kinetic = \"curves\"";
      return "use spline = \"smooth\"";
    }
    if (track_.timing == Timing::frames && (is_start(step) || is_end(step))) return "use rest = \"both\"";
    if (is_start(step)) return "begin the speed curve with 0, 0, at rest";
    if (is_end(step)) return "end the speed curve with 0, 0, at rest";
    if (!step.key) return std::string(turn_remedy);
    if (key_of(step)->breaks) return "take away the break of the key";
    const std::string ease = track_.timing == Timing::frames
                                 ? "let the speed touch 0 there with ease = true"
                                 : "let the speed touch 0 there with ease = true, or rest there with hold";
    return (track_.spline != Spline::smooth ? "use spline = \"smooth\", or " : "") + ease;
  }

  const MoveFile& move_;
  const MoveTrack& track_;
  const Place& place_;
  const RigFile& rig_;
  const RigAxis& limits_;
  std::size_t index_;
  const CheckedAxis& axis_;
  CheckReport& report_;
};

std::string_view name_of(RollEnd end) {
  return end == RollEnd::before ? "pre-roll" : "post-roll";
}

/// How far beyond its limit, in words: "would go to -3 mm at frame -12.00, outside 0..1500".
std::string breach_in_words(const RollBreach<double>& breach, const RigAxis& axis) {
  const std::string_view unit = to_string(axis.unit);
  const auto [value, most] = told_apart(breach.value, breach.limit, Digits::significant, 6);
  const auto beyond = [&, &value = value, &most = most](std::string_view per, std::string_view limit) {
    return fmt::format("would reach {} {}{} at frame {:.2f}, and {} is {}", value, unit, per, breach.frame,
                       limit, most);
  };
  switch (breach.quantity) {
    case RollQuantity::velocity:
      return beyond("/s", "max_velocity");
    case RollQuantity::acceleration:
      return beyond("/s^2", "max_acceleration");
    case RollQuantity::jerk:
      return beyond("/s^3", "max_jerk");
    case RollQuantity::position:
      break;
  }
  return fmt::format("would go to {} {} at frame {:.2f}, outside {:g}..{:g}", value, unit, breach.frame,
                     axis.min, axis.max);
}

/// An axis that starts on its limit and moves away from it has no room, however slow it is.
bool has_room(const Plan& plan, const RollObstacle& obstacle) {
  const RollBreach<double>& breach = obstacle.breach;
  if (breach.quantity != RollQuantity::position) return true;
  std::vector<AxisMotion<double>> joints(plan.played().axis_count());
  static_cast<void>(joints_of(plan.played().tracks(), obstacle.end, std::span(joints)));
  const double position = joints[static_cast<std::size_t>(breach.axis)].position;
  const AxisLimits<double>& limits = plan.limits()[static_cast<std::size_t>(breach.axis)];
  const double room = breach.value > breach.limit ? limits.max() - position : position - limits.min();
  return room > step_rounding * (limits.max() - limits.min());
}

void refuse_roll(const Plan& plan, const RollObstacle& obstacle, CheckReport& report) {
  const RollBreach<double>& breach = obstacle.breach;
  const std::size_t index = plan.axis_of(static_cast<std::size_t>(breach.axis));
  const RigAxis& axis = plan.rig()->axes[index];
  const MoveTrack& track = plan.move().tracks[*plan.axes()[index].track];
  const bool starts = obstacle.end == RollEnd::before;
  // The move breaks the limit itself, which has been said.
  if (breach.at_joint && !report.refusals.empty()) return;
  const bool room = has_room(plan, obstacle);
  const std::string remedy =
      track.timing == Timing::speed
          ? fmt::format("{} the speed curve with 0, 0, at rest{}", starts ? "begin" : "end",
                        room ? ", or give the move more frames" : ", or move the key inward")
          : std::string(room ? "give the move more frames" : "move the key inward");
  report.refusals.push_back({track.speed_places.empty() ? plan.place_of(index)
                             : starts                   ? track.speed_places.front()
                                                        : track.speed_places.back(),
                             fmt::format("the move {} moving, and on a {} of {} frames axis {} {}; {}",
                                         starts ? "starts" : "ends", name_of(obstacle.end), breach.frames,
                                         in_quotes(axis.name), breach_in_words(breach, axis), remedy),
                             room});
}

void refuse_stop(const Plan& plan, const StopObstacle<double>& obstacle, CheckReport& report) {
  const std::size_t index = plan.axis_of(static_cast<std::size_t>(obstacle.axis));
  const CheckedAxis& axis = report.axes[index];
  const bool by_jerk = obstacle.quantity == StopQuantity::jerk;
  // A bound of a stretch may be above the one of the whole move, which is nearer to the truth.
  const double peak = by_jerk ? axis.jerk.value : axis.acceleration.value;
  const auto [value, most] =
      told_apart(std::min(obstacle.value, peak), obstacle.limit, Digits::significant, 6);
  // The motion itself is beyond its limit, which has been said.
  if (!report.refusals.empty()) return;
  report.refusals.push_back(
      {plan.place_of(index),
       fmt::format("axis {} could not be stopped at frame {:.2f}: the motion alone takes {} {}{} there, "
                   "and {} is {}; give the move more frames, or raise {}",
                   in_quotes(axis.name), obstacle.frame, value, axis.unit, by_jerk ? "/s^3" : "/s^2",
                   by_jerk ? "stop_jerk" : "stop_acceleration", most,
                   by_jerk ? "stop_jerk" : "stop_acceleration"),
       true});
}

void prove_stops(const Plan& plan, CheckReport& report) {
  report.planned_stops = std::make_shared<const PlannedStops>(plan);
  const PlannedStops& planned = *report.planned_stops;
  if (planned.obstacle()) return refuse_stop(plan, *planned.obstacle(), report);
  CheckedStops stops{.longest = planned.bounds()->longest_in_time(), .axes = {}};
  for (const CheckedAxis& axis : report.axes) {
    stops.axes.push_back({.velocity = axis.velocity, .acceleration = {}, .jerk = {}});
  }
  for (std::size_t d = 0; d < planned.peaks().size(); ++d) {
    const AxisPeaks<double>& peaks = planned.peaks()[d];
    const AxisLimits<double>& limits = plan.limits()[d];
    CheckedStopAxis& axis = stops.axes[plan.axis_of(d)];
    axis.acceleration.limit = limits.stop_acceleration();
    axis.jerk.limit = limits.stop_jerk();
    raise(axis.acceleration, peaks.acceleration);
    raise(axis.jerk, peaks.jerk);
    // The bounds were made to reach the limit: what is above it is the rounding of this sum.
    axis.acceleration.value = std::min(axis.acceleration.value, limits.stop_acceleration());
    if (limits.stop_jerk()) axis.jerk.value = std::min(axis.jerk.value, *limits.stop_jerk());
  }
  report.stops = std::move(stops);
}

void find_highest_rate(const Plan& plan, CheckReport& report) {
  std::vector<PlayedAxis<double>> played(plan.limits().size());
  for (std::size_t d = 0; d < played.size(); ++d) {
    const std::size_t index = plan.axis_of(d);
    const CheckedAxis& axis = report.axes[index];
    const auto peak = [](const CheckedPeak& found) { return Peak<double>{found.value, found.frame}; };
    played[d].peaks = {.lowest = axis.range->lowest,
                       .highest = axis.range->highest,
                       .velocity = peak(axis.velocity),
                       .acceleration = peak(axis.acceleration),
                       .jerk = peak(axis.jerk)};
    for (const CheckedStep& step : report.steps) {
      if (step.axis == index) {
        played[d].acceleration_step = std::max(played[d].acceleration_step, step.acceleration);
      }
    }
  }
  report.highest_rate = highest_rate<double>(played, plan.limits());
  const bool steps =
      std::ranges::any_of(report.steps, [](const CheckedStep& step) { return step.velocity > 0; });
  if (steps) report.highest_rate = 0;
}

}  // namespace

bool CheckedPeak::is_exceeded() const {
  return limit && !(value <= *limit);
}

bool breaks_jerk_limit(const CheckedStep& step, const RigAxis& limits) {
  return limits.max_jerk && step.acceleration > limits.max_acceleration_step.value_or(0);
}

CheckReport check(const Plan& plan) {
  CheckReport report;
  for (const RigAxis& axis : plan.rig()->axes) report.axes.push_back(axis_at_rest(axis));
  for (std::size_t t = 0; t < plan.tracks().size(); ++t) {
    bound_track(plan, t, report);
    list_steps(plan, t, report);
    const Track<double>& track = plan.tracks()[t].track();
    if (track.has_profile()) report.speed_error = std::max(report.speed_error, track.arc_length().delta());
  }
  bound_rolls(plan, report);
  for (std::size_t a = 0; a < report.axes.size(); ++a) {
    if (report.axes[a].range) AxisRefusals(plan, a, report).add_all();
  }
  for (const RollObstacle& obstacle : plan.roll_obstacles()) refuse_roll(plan, obstacle, report);
  prove_stops(plan, report);
  find_highest_rate(plan, report);
  return report;
}

void refuse_beyond_limits(const CheckReport& report) {
  if (report.fits()) return;
  throw LimitError(report.refusals.front().place, report.refusals.front().message);
}

}  // namespace inbetween
